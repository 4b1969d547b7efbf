"""Which links may touch, as an SRDF says (``disable_collisions``), or as neighbours."""

from __future__ import annotations

from pathlib import Path

from mobo_core.arms.packages import MAX_ROBOT_BYTES
from mobo_core.errors import InputError
from mobo_core.evaluation.urdf_xml import parse

Pairs = set[frozenset[str]]


def read_srdf(path: str, links: list[str]) -> Pairs:
    """Return the pairs of ``links`` between which an SRDF disables collisions.

    Raises:
        InputError: it cannot be read, or is no SRDF of a robot that has any of these links.
    """
    where = f"--srdf {path}"
    try:
        with Path(path).open("rb") as file:
            data = file.read(MAX_ROBOT_BYTES + 1)
    except OSError as error:
        raise InputError(error.strerror or str(error), where=where, expected="an SRDF file") from None
    if len(data) > MAX_ROBOT_BYTES:
        raise InputError(f"more than {MAX_ROBOT_BYTES} bytes", where=where, expected="an SRDF file")
    try:
        root = parse(data)
    except InputError as error:
        raise InputError(error.what, where=where, expected="an SRDF robot") from None
    if root.tag != "robot":
        raise InputError(f"root element <{root.tag[:40]}>", where=where, expected="<robot>")
    found = [(e.get("link1", ""), e.get("link2", "")) for e in root.findall("disable_collisions")]
    known = set(links)
    pairs = {frozenset(pair) for pair in found if known.issuperset(pair)}
    if not pairs:
        what = f"{len(found)} pairs of links, none of them of this robot"
        raise InputError(what, where=where, expected="disable_collisions of this robot's links")
    return pairs
