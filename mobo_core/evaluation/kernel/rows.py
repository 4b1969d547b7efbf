"""What the generated functions are written with: the rows of ``state``, and loops over the lanes."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

LANES = 16
# Entries of a symmetric 6 x 6 matrix.
MATRIX = tuple((a, b) for a in range(6) for b in range(a + 1))

# What is not a variable of one lane, in the lines of a body.
_SHARED = re.compile(r"state|lane|weight|e_position_max|e_rotation_max|(lower|upper)\d+|math|np|max|abs|if|else")


class Rows:
    """Where each row of LANES numbers is in ``state``: arguments, then what one part of a step leaves to the next.

    ``axis`` and ``origin`` have three rows a joint and three for the tip, which counts as a joint at rest; before
    ``origin`` are three of the base. A joint that slides has its axis in ``slide`` and zeros in ``axis``.
    """

    def __init__(self, n: int) -> None:
        self.end = 0
        self.q, self.target_r, self.target_p, self.errors = (self._next(count) for count in (n, 9, 3, 2))
        self.sin, self.cos, self.frame, self.axis = (self._next(count) for count in (n + 1, n + 1, 9, 3 * n + 3))
        self.base = self._next(3 * n + 6)
        self.origin = self.base + 3
        self.tip = self.origin + 3 * n
        self.jacobian, self.matrix, self.error = (self._next(count) for count in (6 * n, len(MATRIX), 6))
        self.damping, self.slide = self._next(1), self._next(3 * n)

    def _next(self, count: int) -> int:
        first, self.end = self.end, self.end + count
        return first


def at(row: int, before: str = "") -> str:
    """Return the number of this lane in a row, or ``before`` numbers further."""
    return f"state[{before}{row * LANES} + lane]"


def load(names: Iterable[str], first: int) -> Iterator[str]:
    """Give the names the numbers in consecutive rows."""
    yield from (f"{name} = {at(first + k)}" for k, name in enumerate(names))


def store(names: Iterable[str], first: int) -> Iterator[str]:
    """Write the numbers of these names to consecutive rows."""
    yield from (f"{at(first + k)} = {name}" for k, name in enumerate(names))


def indented(body: Iterable[str]) -> list[str]:
    """Return the lines one step further in."""
    return [f"    {line}" for line in body]


def lanes(body: Iterable[str]) -> list[str]:
    """Return a loop over all lanes."""
    return [f"for lane in range({LANES}):", *indented(body)]


def halves(body: Iterable[str]) -> list[str]:
    """Return a loop over all lanes, two at a time, statement by statement.

    The processor then has two independent sequences to choose from, and need not wait for the results of one.
    """
    half = LANES // 2
    lines = []
    for line in body:
        for w in range(2):
            own = re.sub(r"(?<![\w.])[A-Za-z_]\w*", lambda m, w=w: _of_half(m[0], w), line)  # type: ignore[misc]
            lines.append(own.replace("+ lane]", f"+ {half} + lane]") if w else own)
    return [f"for lane in range({half}):", *indented(lines)]


def _of_half(name: str, w: int) -> str:
    return name if _SHARED.fullmatch(name) else f"{name}_{w}"


def function(head: str, body: Iterable[str]) -> str:
    """Return the source of a compiled function."""
    return "\n".join(["@compiled", f"def {head}:", *indented(body)]) + "\n"
