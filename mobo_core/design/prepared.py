"""The URDFs of many designs: xacro expands each joint macro once, with its numbers left open.

xacro computes with Python's operators on whatever its macros' parameters are. Here they are open numbers, which
write down what is done to them, so that the same can be done to floats later: the same operations in the same
order, hence the same digits. What cannot be left open, such as the sine of a length, is left to xacro each time.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from typing import Any
from xml.dom.minidom import parseString

import xacro

from mobo_core.design.description import (
    arm_source,
    centers_of,
    is_mounted,
    joint_call,
    mount_call,
    to_urdf,
    tool_call,
)
from mobo_core.design.design import Design
from mobo_core.design.space import DesignSpace
from mobo_core.design.tape import Open, Tape

# What stands in a text for an open number: its place on the tape between two private characters.
_TOKEN = re.compile("\ue000(\\d+)\ue001")
_CUT = "<mobo_cut/>"
# Stands for the name of the design.
NAME = "\ue002"
# A macro that takes more ways than this through its conditions is not worth preparing.
_MAX_WAYS = 8


class _Way:
    """One way through a macro's conditions: what stands before, in and after its expansion, and its numbers."""

    def __init__(self, source: Callable[[str], str], call: str, inputs: dict[str, float]) -> None:
        self._tape = Tape(tuple(inputs.values()))
        opened = {name: Open(self._tape, place) for place, name in enumerate(inputs)}
        document = parseString(source(call))
        xacro.process_doc(document, mappings=opened)
        self.head, block, self.tail = document.toprettyxml(indent="  ").split(f"  {_CUT}\n")
        parts = _TOKEN.split(block)
        self._texts, self._places = parts[::2], [int(place) for place in parts[1::2]]

    def fill(self, inputs: tuple[float, ...]) -> str | None:
        """Return the expansion for these numbers, or None if they lead another way."""
        values = self._tape.play(inputs)
        if values is None:
            return None
        parts = [self._texts[0]]
        for place, text in zip(self._places, self._texts[1:], strict=True):
            parts += (str(values[place]), text)
        return "".join(parts)

    def to_dict(self) -> dict[str, object]:
        """Return texts, the places of the numbers between them, the numbers, and what is done to them, as plain data.

        A step is [operation, place, place, place of the result, None] or [operation, place, place, -1, condition].
        """
        steps = [[step.name, step.a, step.b, step.target, step.expected] for step in self._tape.steps]
        return {"texts": self._texts, "places": self._places, "values": self._tape.values, "steps": steps}


class PreparedXacro:
    """Describes designs of one space, in a tenth of a millisecond or so each.

    Each joint macro is expanded once for every place in the arm. The first arm to put two of the expansions side by
    side is also described by xacro as a whole, and the two texts are compared. If they ever differ (edited macros may
    hand on properties to one another, say), xacro describes every arm from then on.

    Args:
        space: gives masses, radius and limits.
    """

    def __init__(self, space: DesignSpace) -> None:
        self._space = space
        self._ways: dict[tuple[Any, ...], list[_Way]] = {}
        self._seen: set[tuple[int, int]] = set()
        self.plain = False  # whether xacro does it all

    def to_urdf(self, design: Design) -> str:
        """Return what :func:`mobo_core.design.to_urdf` returns for ``design``, to the byte; errors likewise."""
        if not self.plain:
            try:
                text, ways = self._put_together(design)
            except Exception:  # whatever a macro does with what is no number
                self.plain = True
                return to_urdf(design, self._space)
            pairs = {(id(a), id(b)) for a, b in zip(ways, ways[1:], strict=False)}
            if pairs <= self._seen:
                return text
            self.plain = text != to_urdf(design, self._space)
            self._seen |= pairs
        return to_urdf(design, self._space) if self.plain else text

    def template(self, designs: Iterable[Design]) -> dict[str, object] | None:
        """Return, as plain data, from what the URDFs of ``designs`` and their like are put together; None if by xacro.

        ``head`` (with :data:`NAME` for the design's) and ``tail`` stand around the blocks. ``blocks`` holds by kind of
        block, place and whether the arm is mounted the ways through it (see ``_Way.to_dict``): the first whose
        conditions hold is the one. Inputs are the first places: height and tilt of the ``mount`` (place 0); offset,
        length and center of a joint by its letter; offset of the ``tool`` (at the last joint's place).
        """
        ends = ("", "")
        for design in designs:
            self.to_urdf(design)
            if self.plain:
                return None
            way = self._put_together(design)[1][-1]
            ends = (way.head, way.tail)
        blocks = {
            f"{kind}:{place}:{int(mounted)}": [way.to_dict() for way in ways]
            for (kind, place, mounted), ways in self._ways.items()
        }
        return {"name": NAME, "head": ends[0], "tail": ends[1], "blocks": blocks}

    def _put_together(self, design: Design) -> tuple[str, list[_Way]]:
        texts, ways = [], []
        offset = 0.0
        mounted = is_mounted(design)
        if mounted:
            text, way = self._block(("mount", 0, True), {"height": design.base_height, "tilt": design.base_tilt})
            texts.append(text)
            ways.append(way)
        centers = centers_of(design, self._space)
        for i, (joint, length, center) in enumerate(zip(design.joints, design.lengths, centers, strict=True), start=1):
            text, way = self._block((joint, i, mounted), {"offset": offset, "length": length, "center": center})
            texts.append(text)
            ways.append(way)
            offset = length
        text, way = self._block(("tool", len(design.joints), mounted), {"offset": offset})
        head = way.head.replace(NAME, design.name)
        return "".join((head, *texts, text, way.tail)), [*ways, way]

    def _block(self, key: tuple[str, int, bool], inputs: dict[str, float]) -> tuple[str, _Way]:
        ways = self._ways.setdefault(key, [])
        numbers = tuple(inputs.values())
        for way in ways:
            text = way.fill(numbers)
            if text is not None:
                return text, way
        if len(ways) == _MAX_WAYS:
            raise ValueError(f"{key} has more than {_MAX_WAYS} ways")
        way = self._expand(*key, inputs)
        ways.append(way)
        text = way.fill(numbers)
        assert text is not None
        return text, way

    def _expand(self, kind: str, index: int, mounted: bool, inputs: dict[str, float]) -> _Way:
        given = {name: f"${{xacro.arg('{name}')}}" for name in inputs}

        def source(call: str) -> str:
            # The tool is there to end the arm, as in every arm.
            rest = "" if kind == "tool" else tool_call(index, "0.0")
            return arm_source(NAME, self._space, [_CUT, call, _CUT, rest])

        if kind == "tool":
            call = tool_call(index, given["offset"])
        elif kind == "mount":
            call = mount_call(given["height"], given["tilt"])
        else:
            offset, length, center = given["offset"], given["length"], given["center"]
            call = joint_call(self._space, kind, index, offset, length, center, mounted=mounted)
        return _Way(source, call, inputs)
