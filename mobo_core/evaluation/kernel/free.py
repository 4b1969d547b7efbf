"""Writes the middle of an IK step for poses whose orientation counts in part or not at all.

See :mod:`mobo_core.evaluation.kernel.orientation`. It stands beside that for whole poses, which it leaves as it is, and
has loops over joints where that is written out: slower by a little, and compiled in a fraction of the time.
"""

from __future__ import annotations

from collections.abc import Iterator

from mobo_core.evaluation.kernel.configuration import DAMPING_FLOOR, DAMPING_GAIN, HALF_TURN
from mobo_core.evaluation.kernel.orientation import FREE_ROLL
from mobo_core.evaluation.kernel.rows import LANES, MATRIX, Rows, at, function, indented, lanes, load, store

_AXES = "xyz"
_ERROR = ("ex", "ey", "ez", "sx", "sy", "sz")


def lane_linearise_free_source(n: int) -> str:
    """Return the source of ``lane_linearise_free(state, lower, upper, weight, orientation)``.

    It writes errors, damping, Jacobian and matrix as ``lane_linearise`` does (see
    :mod:`mobo_core.evaluation.kernel.lanes`).
    """
    rows = Rows(n)
    body = [
        f"turn = 1.0 if orientation == {FREE_ROLL} else 0.0",
        *lanes(_errors(rows)),
        f"for i in range({n}):",
        *indented(
            [f"place, row, joint = {3 * LANES} * i, {6 * LANES} * i, {LANES} * i", "low, high = lower[i], upper[i]"]
        ),
        *indented(lanes(_slope(rows))),
    ]
    return function("lane_linearise_free(state, lower, upper, weight, orientation)", body)


def _errors(rows: Rows) -> Iterator[str]:
    yield from load(_AXES, rows.tip)
    yield f"b0, b1, b2 = {', '.join(at(rows.frame + 3 * r + 2) for r in range(3))}"
    yield f"t0, t1, t2 = {', '.join(at(rows.target_r + 3 * r + 2) for r in range(3))}"
    yield from (f"e{axis} = {at(rows.target_p + r)} - {axis}" for r, axis in enumerate(_AXES))
    yield "sx, sy, sz = b1 * t2 - b2 * t1, b2 * t0 - b0 * t2, b0 * t1 - b1 * t0"
    yield "cosine = b0 * t0 + b1 * t1 + b2 * t2"
    yield "g = 1.0 + cosine"
    yield f"f = turn * math.sqrt(2.0 / (g if g > {HALF_TURN!r} else {HALF_TURN!r}))"
    yield "sx, sy, sz = f * sx, f * sy, f * sz"
    yield "e_position = ex * ex + ey * ey + ez * ez"
    yield f"e_rotation = (sx * sx + sy * sy + sz * sz) if g > {HALF_TURN!r} else turn * (2.0 - 2.0 * cosine)"
    yield f"damping = {DAMPING_FLOOR!r} + {DAMPING_GAIN!r} * (weight * weight * e_position + e_rotation)"
    yield "ex, ey, ez = weight * ex, weight * ey, weight * ez"
    yield from store(("e_position", "e_rotation"), rows.errors)
    yield from store([*_ERROR, "damping"], rows.error)
    yield from store(("damping" if a == b else "0.0" for a, b in MATRIX), rows.matrix)


def _slope(rows: Rows) -> Iterator[str]:
    """Row i of the Jacobian, zero where the joint is frozen, and its share of J J^T."""
    yield from load(_AXES, rows.tip)
    yield from load(_ERROR, rows.error)
    yield f"b0, b1, b2 = {', '.join(at(rows.frame + 3 * r + 2) for r in range(3))}"
    yield f"z0, z1, z2 = {', '.join(at(rows.axis + r, 'place + ') for r in range(3))}"
    yield from (f"d{r} = {axis} - {at(rows.origin + r, 'place + ')}" for r, axis in enumerate(_AXES))
    yield "along = z0 * b0 + z1 * b1 + z2 * b2"
    for r in range(3):
        u, v = (r + 1) % 3, (r + 2) % 3
        yield f"j{r} = weight * (z{u} * d{v} - z{v} * d{u})"
        yield f"j{r + 3} = turn * (z{r} - along * b{r})"
    yield f"q = {at(rows.q, 'joint + ')}"
    yield "g = " + " + ".join(f"j{a} * {e}" for a, e in enumerate(_ERROR))
    yield "frozen = ((q <= low) & (g < 0.0)) | ((q >= high) & (g > 0.0))"
    yield f"if frozen: {' = '.join(f'j{a}' for a in range(6))} = 0.0"
    yield from (f"{at(rows.jacobian + a, 'row + ')} = j{a}" for a in range(6))
    yield from (f"{at(rows.matrix + k)} = {at(rows.matrix + k)} + j{a} * j{b}" for k, (a, b) in enumerate(MATRIX))
