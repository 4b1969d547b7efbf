"""Writes the innermost functions of the kernel: one IK step for a row of poses at once, as straight-line code.

A loop over poses ("lanes") whose body has no branch, no inner loop and no array but one is what LLVM turns into
vector instructions throughout. Loops over joints would prevent that, so the body is written out here for a
given number of joints: some 1,000 assignments to local variables, never read by people. It is the same
algorithm as :mod:`mobo_core.evaluation.reference`, and gives the same bits whatever the width of the vectors,
because each lane is computed on its own and nothing is reordered.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from mobo_core.evaluation.kernel.configuration import DAMPING_FLOOR, DAMPING_GAIN, HALF_TURN, MAX_STEP
from mobo_core.jit.numerics import COS_TERMS, HALF_PI_PARTS, SIN_TERMS, TWO_OVER_PI

LANES = 16

_AXES = "xyz"
_ERROR = ("ex", "ey", "ez", "sx", "sy", "sz")


def lane_step_source(n: int) -> str:
    """Return the source of ``lane_step(state, constants, lower, upper, weight, e_position_max, e_rotation_max)``.

    ``state`` is flat, its rows of LANES numbers being: n joint angles (rad); 9 of the target's rotation, row
    by row, and 3 of its position (m); the squared norms of the errors of position and orientation, which the
    step writes. ``constants`` (n + 1, 12) holds rotation and position of each joint in the one before, and
    of the tip in the last. ``weight`` is what an error of 1 m counts against one of 1 rad. Angles of lanes
    within both tolerances stay as they are.
    """
    limits = [f"lower{i}, upper{i} = lower[{i}], upper[{i}]" for i in range(n)]
    head = "lane_step(state, constants, lower, upper, weight, e_position_max, e_rotation_max)"
    return _function(head, n, limits, _body(n))


def lane_forward_source(n: int) -> str:
    """Return the source of ``lane_forward(state, constants)``: where the tip is at a row of configurations.

    ``state`` and ``constants`` as for ``lane_step``; the tip's rotation and position go where that has the
    target's.
    """
    lines = [f"q{i} = {_row(i)}" for i in range(n)] + list(_forward(n))
    lines += [f"{_row(n + 3 * r + c)} = b{r}{c}" for r in range(3) for c in range(3)]
    lines += [f"{_row(n + 9 + r)} = {axis}" for r, axis in enumerate(_AXES)]
    return _function("lane_forward(state, constants)", n, [], lines)


def lane_jacobian_source(n: int) -> str:
    """Return the source of ``lane_jacobian(state, constants, weight, out)``, which tests hold against Pinocchio.

    ``out`` gets n * 6 rows of LANES numbers: the Jacobian of the tip as ``lane_step`` has it.
    """
    lines = [f"q{i} = {_row(i)}" for i in range(n)] + list(_forward(n))
    for i in range(n):
        lines += _jacobian_row(i)
        lines += [f"out[{(6 * i + a) * LANES} + lane] = j{i}{a}" for a in range(6)]
    return _function("lane_jacobian(state, constants, weight, out)", n, [], lines)


def _function(head: str, n: int, before: list[str], body: Iterable[str]) -> str:
    constants = [f"c{i}_{k} = constants[{i}, {k}]" for i in range(n + 1) for k in range(12)]
    loop = [f"for lane in range({LANES}):", *(f"    {line}" for line in body)]
    return "\n".join([f"def {head}:", *(f"    {line}" for line in (*constants, *before, *loop))]) + "\n"


def _row(row: int) -> str:
    return f"state[{row * LANES} + lane]"


def _body(n: int) -> Iterator[str]:
    for i in range(n):
        yield f"q{i} = {_row(i)}"
    yield from _forward(n)
    yield from _errors(n)
    for i in range(n):
        yield from _jacobian_row(i)
        yield from _freeze(i)
    yield from _solve(n)
    yield from _move(n)


def _forward(n: int) -> Iterator[str]:
    """Rotation a.. and origin x, y, z of each joint; b.. before the joint turns, at last of the tip."""
    for i in range(n + 1):
        if i == 0:
            yield "x, y, z = c0_9, c0_10, c0_11"
            yield from (f"b{r}{c} = c0_{3 * r + c}" for r in range(3) for c in range(3))
        else:
            for r, axis in enumerate(_AXES):
                yield f"{axis} = {axis} + (a{r}0 * c{i}_9 + a{r}1 * c{i}_10 + a{r}2 * c{i}_11)"
            for r in range(3):
                for c in range(3):
                    yield f"b{r}{c} = a{r}0 * c{i}_{c} + a{r}1 * c{i}_{3 + c} + a{r}2 * c{i}_{6 + c}"
        if i == n:
            return
        yield from _sin_cos(f"q{i}")
        for r in range(3):
            yield f"a{r}0, a{r}1, a{r}2 = b{r}0 * c + b{r}1 * s, b{r}1 * c - b{r}0 * s, b{r}2"
        yield f"zx{i}, zy{i}, zz{i}, ox{i}, oy{i}, oz{i} = a02, a12, a22, x, y, z"


def _sin_cos(angle: str) -> Iterator[str]:
    """As :func:`mobo_core.jit.numerics.sin_cos`, without a branch."""
    yield f"k = math.floor({angle} * {TWO_OVER_PI!r} + 0.5)"
    one, two, three = HALF_PI_PARTS
    yield f"r = (({angle} - k * {one!r}) - k * {two!r}) - k * {three!r}"
    yield "t = r * r"
    for name, terms in (("p", SIN_TERMS), ("u", COS_TERMS)):
        yield f"{name} = {terms[0]!r}"
        yield from (f"{name} = {name} * t + {term!r}" for term in terms[1:])
    yield "p, u = r + r * t * p, 1.0 + t * u"
    yield "quarter = np.int32(k)"
    yield "s, c = (u if quarter & 1 else p), (p if quarter & 1 else u)"
    yield "s, c = (-s if quarter & 2 else s), (-c if (quarter + 1) & 2 else c)"


def _errors(n: int) -> Iterator[str]:
    for r in range(3):
        yield from (f"t{r}{c} = {_row(n + 3 * r + c)}" for c in range(3))
        yield f"e{_AXES[r]} = {_row(n + 9 + r)} - {_AXES[r]}"
    for r, axis in enumerate(_AXES):
        u, v = (r + 1) % 3, (r + 2) % 3
        yield f"s{axis} = " + " + ".join(f"(b{u}{c} * t{v}{c} - b{v}{c} * t{u}{c})" for c in range(3))
    yield "trace = " + " + ".join(f"(b0{c} * t0{c} + b1{c} * t1{c} + b2{c} * t2{c})" for c in range(3))
    yield "g = 1.0 + trace"
    yield f"f = 1.0 / math.sqrt(g if g > {HALF_TURN!r} else {HALF_TURN!r})"
    yield "sx, sy, sz = f * sx, f * sy, f * sz"
    yield "e_position = ex * ex + ey * ey + ez * ez"
    yield f"e_rotation = (sx * sx + sy * sy + sz * sz) if g > {HALF_TURN!r} else 3.0 - trace"
    yield "ex, ey, ez = weight * ex, weight * ey, weight * ez"
    yield f"{_row(n + 12)} = e_position"
    yield f"{_row(n + 13)} = e_rotation"


def _jacobian_row(i: int) -> Iterator[str]:
    """Row i of the Jacobian of the tip: axis x (tip - origin), weighed, and axis."""
    yield f"dx, dy, dz = x - ox{i}, y - oy{i}, z - oz{i}"
    for r, axis in enumerate(_AXES):
        u, v = _AXES[(r + 1) % 3], _AXES[(r + 2) % 3]
        yield f"j{i}{r} = weight * (z{u}{i} * d{v} - z{v}{i} * d{u})"
        yield f"j{i}{r + 3} = z{axis}{i}"


def _freeze(i: int) -> Iterator[str]:
    """Make row i zero if the joint is at a limit which the gradient pushes it against."""
    yield "g = " + " + ".join(f"j{i}{a} * {e}" for a, e in enumerate(_ERROR))
    yield f"frozen = (q{i} <= lower{i} and g < 0.0) or (q{i} >= upper{i} and g > 0.0)"
    yield "free = 0.0 if frozen else 1.0"
    yield from (f"j{i}{a} = j{i}{a} * free" for a in range(6))


def _solve(n: int) -> Iterator[str]:
    """Solve (J J^T + damping I) y = error by Cholesky's method."""
    yield f"damping = {DAMPING_FLOOR!r} + {DAMPING_GAIN!r} * (weight * weight * e_position + e_rotation)"
    for a in range(6):
        for b in range(a + 1):
            yield f"m{a}{b} = " + " + ".join(f"j{i}{a} * j{i}{b}" for i in range(n))
        yield f"m{a}{a} = m{a}{a} + damping"
    for b in range(6):
        yield from (f"m{b}{b} = m{b}{b} - m{b}{k} * m{b}{k}" for k in range(b))
        yield f"v{b} = 1.0 / math.sqrt(m{b}{b})"
        for a in range(b + 1, 6):
            yield from (f"m{a}{b} = m{a}{b} - m{a}{k} * m{b}{k}" for k in range(b))
            yield f"m{a}{b} = m{a}{b} * v{b}"
    for a in range(6):
        yield f"y{a} = ({_ERROR[a]}{''.join(f' - m{a}{k} * y{k}' for k in range(a))}) * v{a}"
    for a in range(5, -1, -1):
        yield f"y{a} = (y{a}{''.join(f' - m{k}{a} * y{k}' for k in range(a + 1, 6))}) * v{a}"


def _move(n: int) -> Iterator[str]:
    yield f"largest = {MAX_STEP!r}"
    for i in range(n):
        yield f"d{i} = " + " + ".join(f"j{i}{a} * y{a}" for a in range(6))
        yield f"largest = max(largest, abs(d{i}))"
    yield "there = e_position <= e_position_max and e_rotation <= e_rotation_max"
    yield f"scale = 0.0 if there else {MAX_STEP!r} / largest"
    for i in range(n):
        yield f"v = q{i} + scale * d{i}"
        yield f"v = v if v > lower{i} else lower{i}"
        yield f"{_row(i)} = v if v < upper{i} else upper{i}"
