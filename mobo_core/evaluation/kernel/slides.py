"""Writes the part of an IK step that is for joints which slide: their rows of the Jacobian, and what these add.

See :mod:`mobo_core.evaluation.kernel.lanes`. Arms whose joints all turn do without it.
"""

from __future__ import annotations

from collections.abc import Iterator

from mobo_core.evaluation.kernel.arguments import SLIDE
from mobo_core.evaluation.kernel.rows import LANES, MATRIX, Rows, at, function, indented, lanes, load


def lane_slides_source(n: int) -> str:
    """Return the source of ``lane_slides(state, constants, lower, upper, weight)``.

    To come after errors, Jacobian and matrix are written, those of joints that slide with zeros.
    """
    body = [
        f"for i in range({n}):",
        f"    if constants[i, 12] == {SLIDE!r}:",
        f"        place, row, joint = {3 * LANES} * i, {6 * LANES} * i, {LANES} * i",
        "        low, high = lower[i], upper[i]",
        *indented(indented(lanes(_slope(Rows(n))))),
    ]
    return function("lane_slides(state, constants, lower, upper, weight)", body)


def _slope(rows: Rows) -> Iterator[str]:
    """Row i of the Jacobian, the weighed axis, zero where the joint is frozen; and its share of J J^T."""
    yield from load(("ex", "ey", "ez"), rows.error)
    yield from (f"j{r} = weight * {at(rows.slide + r, 'place + ')}" for r in range(3))
    yield f"q = {at(rows.q, 'joint + ')}"
    yield "g = j0 * ex + j1 * ey + j2 * ez"
    yield "frozen = ((q <= low) & (g < 0.0)) | ((q >= high) & (g > 0.0))"
    yield "if frozen: j0 = j1 = j2 = 0.0"
    yield from (f"{at(rows.jacobian + a, 'row + ')} = j{a}" for a in range(3))
    for k, (a, b) in enumerate(MATRIX):
        if a < 3:
            yield f"{at(rows.matrix + k)} = {at(rows.matrix + k)} + j{a} * j{b}"
