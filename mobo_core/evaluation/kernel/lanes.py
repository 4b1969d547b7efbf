"""Writes the innermost functions of the kernel: one IK step for a row of poses at once, as straight-line code.

Loops over poses ("lanes") whose body has no branch, no inner loop and no array but one are what LLVM turns into
vector instructions throughout. Loops over joints would prevent that, so bodies are written out here for a
given number of joints: some 1,000 assignments to local variables, never read by people. It is the same
algorithm as :mod:`mobo_core.evaluation.reference`, and gives the same bits whatever the width of the vectors,
because each lane is computed on its own and nothing is reordered.

A processor looks ahead a few hundred instructions, less than a step of one vector has. So a step is several short
loops, each over all lanes, whose iterations it can overlap; what they leave to each other are rows of ``state``.
"""

from __future__ import annotations

from collections.abc import Iterator

from mobo_core.evaluation.kernel.arguments import SLIDES
from mobo_core.evaluation.kernel.configuration import DAMPING_FLOOR, DAMPING_GAIN, HALF_TURN, MAX_STEP
from mobo_core.evaluation.kernel.free import lane_linearise_free_source
from mobo_core.evaluation.kernel.orientation import FULL
from mobo_core.evaluation.kernel.places import lane_places_source
from mobo_core.evaluation.kernel.rows import LANES, MATRIX, Rows, at, function, halves, lanes, load, store
from mobo_core.evaluation.kernel.slides import lane_slides_source

STEP_ARGUMENTS = "state, constants, lower, upper, weight, orientation, e_position_max, e_rotation_max"
_AXES = "xyz"
_ERROR = ("ex", "ey", "ez", "sx", "sy", "sz")
_FRAME = [f"b{r}{c}" for r in range(3) for c in range(3)]
_JACOBIAN = [f"j{a}" for a in range(6)]
_ENTRIES = [f"m{a}{b}" for a, b in MATRIX]


def state_size(n: int) -> int:
    """Return how many numbers ``state`` has for ``n`` joints."""
    return Rows(n).end * LANES


def lane_step_source(n: int) -> str:
    """Return the source of ``lane_step``, whose arguments are STEP_ARGUMENTS.

    ``state`` is flat, :func:`state_size` numbers, best at a multiple of 64 bytes. Its rows of LANES numbers are: n
    joint angles (rad; m where they slide); 9 of the target's rotation, row by row, and 3 of its position (m); the
    squared norms of the errors of position and orientation, which the step writes; then work space. ``constants`` are
    those of :func:`mobo_core.evaluation.kernel.arguments.lane_constants`. ``weight`` is what an error of 1 m counts
    against one of 1 rad, ``orientation`` what of a pose's counts
    (:mod:`mobo_core.evaluation.kernel.orientation`). Angles of lanes within both tolerances stay as they are.
    """
    rows = Rows(n)
    limits = [f"lower{i}, upper{i} = lower[{i}], upper[{i}]" for i in range(n)]
    linearise = [*limits, *lanes(_errors(rows)), *halves(_slopes(rows, n)), *lanes(_matrix(rows, n))]
    step = [
        "lane_places(state, constants)",
        f"if orientation == {FULL}: lane_linearise(state, lower, upper, weight)",
        "else: lane_linearise_free(state, lower, upper, weight, orientation)",
        f"if constants[{n}, 12] == {SLIDES!r}: lane_slides(state, constants, lower, upper, weight)",
        "lane_move(state, lower, upper, e_position_max, e_rotation_max)",
    ]
    functions = (
        lane_places_source(n),
        function("lane_linearise(state, lower, upper, weight)", linearise),
        lane_linearise_free_source(n),
        lane_slides_source(n),
        function(step[-1], [*limits, *halves(_solve(rows)), *halves(_move(rows, n))]),
        function(f"lane_step({STEP_ARGUMENTS})", step),
    )
    return "\n\n".join(functions)


def lane_forward_source(n: int) -> str:
    """Return the source of ``lane_forward(state, constants)``: where the tip is at a row of configurations.

    ``state`` and ``constants`` as for ``lane_step``, whose source is to come before; the tip's rotation and position
    go where that has the target's.
    """
    rows = Rows(n)
    copy = [*_tip(rows), *store([*_FRAME, *_AXES], rows.target_r)]
    return function("lane_forward(state, constants)", ["lane_places(state, constants)", *lanes(copy)])


def lane_jacobian_source(n: int) -> str:
    """Return the source of ``lane_jacobian(state, constants, weight, out)``, which tests hold against Pinocchio.

    ``out`` gets n * 6 rows of LANES numbers: the Jacobian of the tip as ``lane_step`` has it, whose source is to come
    before; of joints that turn.
    """
    rows = Rows(n)
    lines = list(_tip(rows))
    for i in range(n):
        lines += _jacobian_row(rows, i)
        lines += [f"out[{(6 * i + a) * LANES} + lane] = j{a}" for a in range(6)]
    return function("lane_jacobian(state, constants, weight, out)", ["lane_places(state, constants)", *lanes(lines)])


def _tip(rows: Rows) -> Iterator[str]:
    yield from load(_FRAME, rows.frame)
    yield from load(_AXES, rows.tip)


def _slopes(rows: Rows, n: int) -> Iterator[str]:
    """Jacobian J."""
    yield from load(_AXES, rows.tip)
    yield from load(_ERROR, rows.error)
    for i in range(n):
        yield from _jacobian_row(rows, i)
        yield from _freeze(rows, i)
        yield from store(_JACOBIAN, rows.jacobian + 6 * i)


def _matrix(rows: Rows, n: int) -> Iterator[str]:
    """J J^T + damping I."""
    for i in range(n):
        yield from load(_JACOBIAN, rows.jacobian + 6 * i)
        for a, b in MATRIX:
            yield f"m{a}{b} = " + (f"m{a}{b} + " if i else "") + f"j{a} * j{b}"
    yield from load(["damping"], rows.damping)
    yield from (f"m{a}{a} = m{a}{a} + damping" for a in range(6))
    yield from store(_ENTRIES, rows.matrix)


def _errors(rows: Rows) -> Iterator[str]:
    yield from _tip(rows)
    yield from load((f"t{r}{c}" for r in range(3) for c in range(3)), rows.target_r)
    yield from (f"e{axis} = {at(rows.target_p + r)} - {axis}" for r, axis in enumerate(_AXES))
    for r, axis in enumerate(_AXES):
        u, v = (r + 1) % 3, (r + 2) % 3
        yield f"s{axis} = " + " + ".join(f"(b{u}{c} * t{v}{c} - b{v}{c} * t{u}{c})" for c in range(3))
    yield "trace = " + " + ".join(f"(b0{c} * t0{c} + b1{c} * t1{c} + b2{c} * t2{c})" for c in range(3))
    yield "g = 1.0 + trace"
    yield f"f = 1.0 / math.sqrt(g if g > {HALF_TURN!r} else {HALF_TURN!r})"
    yield "sx, sy, sz = f * sx, f * sy, f * sz"
    yield "e_position = ex * ex + ey * ey + ez * ez"
    yield f"e_rotation = (sx * sx + sy * sy + sz * sz) if g > {HALF_TURN!r} else 3.0 - trace"
    yield f"damping = {DAMPING_FLOOR!r} + {DAMPING_GAIN!r} * (weight * weight * e_position + e_rotation)"
    yield "ex, ey, ez = weight * ex, weight * ey, weight * ez"
    yield from store(("e_position", "e_rotation"), rows.errors)
    yield from store([*_ERROR, "damping"], rows.error)


def _jacobian_row(rows: Rows, i: int) -> Iterator[str]:
    """Row i of the Jacobian of the tip: axis x (tip - origin), weighed, and axis."""
    yield from load((f"z{axis}" for axis in _AXES), rows.axis + 3 * i)
    yield from (f"d{axis} = {axis} - {at(rows.origin + 3 * i + r)}" for r, axis in enumerate(_AXES))
    for r, axis in enumerate(_AXES):
        u, v = _AXES[(r + 1) % 3], _AXES[(r + 2) % 3]
        yield f"j{r} = weight * (z{u} * d{v} - z{v} * d{u})"
        yield f"j{r + 3} = z{axis}"


def _freeze(rows: Rows, i: int) -> Iterator[str]:
    """Make row i zero if the joint is at a limit which the gradient pushes it against."""
    yield f"q = {at(rows.q + i)}"
    yield "g = " + " + ".join(f"j{a} * {e}" for a, e in enumerate(_ERROR))
    yield f"frozen = ((q <= lower{i}) & (g < 0.0)) | ((q >= upper{i}) & (g > 0.0))"
    yield f"if frozen: {' = '.join(f'j{a}' for a in range(6))} = 0.0"


def _solve(rows: Rows) -> Iterator[str]:
    """Solve (J J^T + damping I) y = error by Cholesky's method."""
    yield from load(_ENTRIES, rows.matrix)
    yield from load(_ERROR, rows.error)
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
    yield from store((f"y{a}" for a in range(6)), rows.error)


def _move(rows: Rows, n: int) -> Iterator[str]:
    yield from load((f"y{a}" for a in range(6)), rows.error)
    yield from load(("e_position", "e_rotation"), rows.errors)
    yield f"largest = {MAX_STEP!r}"
    for i in range(n):
        yield f"d{i} = " + " + ".join(f"{at(rows.jacobian + 6 * i + a)} * y{a}" for a in range(6))
        yield f"largest = max(largest, abs(d{i}))"
    yield "there = (e_position <= e_position_max) & (e_rotation <= e_rotation_max)"
    yield f"scale = 0.0 if there else {MAX_STEP!r} / largest"
    for i in range(n):
        yield f"v = {at(rows.q + i)} + scale * d{i}"
        yield f"v = v if v > lower{i} else lower{i}"
        yield f"{at(rows.q + i)} = v if v < upper{i} else upper{i}"
