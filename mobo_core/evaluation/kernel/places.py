"""Writes ``lane_places``: axes and origins of all joints, and the frame of the tip, at a row of configurations."""

from __future__ import annotations

from collections.abc import Iterator

from mobo_core.evaluation.kernel.arguments import SLIDE, TIP
from mobo_core.evaluation.kernel.rows import LANES, Rows, at, function, indented, lanes
from mobo_core.jit.numerics import COS_TERMS, HALF_PI_PARTS, SIN_TERMS, TWO_OVER_PI


def lane_places_source(n: int) -> str:
    """Return the source of ``lane_places(state, constants)``, arguments as for ``lane_step``."""
    rows = Rows(n)
    body = list(_sines(n))
    body += lanes(
        [f"{at(rows.frame + k)} = {float(k in (0, 4, 8))}" for k in range(9)]
        + [f"{at(rows.base + k)} = 0.0" for k in range(3)]
        + [f"{at(rows.sin + n)} = 0.0", f"{at(rows.cos + n)} = 1.0"]
    )
    body += [f"for i in range({n + 1}):", *indented(_joint(rows))]
    return function("lane_places(state, constants)", body)


def _joint(rows: Rows) -> Iterator[str]:
    yield "kind, length = constants[i, 12], constants[i, 13]"
    yield f"turn, place = {LANES} * i, {3 * LANES} * i"
    for w in range(3):
        yield f"{'elif' if w else 'if'} kind == {w + 1}.0:"
        yield from indented(lanes(_parallel(rows, w)))
    yield f"elif kind == {TIP!r}:"
    yield from indented(lanes(_link(rows)))
    yield "else:"
    yield from (f"    c{k} = constants[i, {k}]" for k in range(12))
    yield f"    if kind == {SLIDE!r}:"
    yield from indented(indented(lanes(_slide(rows))))
    yield "    else:"
    yield from indented(indented(lanes(_any(rows))))


def _sines_of_joint(rows: Rows) -> str:
    return f"s, c = {at(rows.sin, 'turn + ')}, {at(rows.cos, 'turn + ')}"


def _any(rows: Rows) -> Iterator[str]:
    """Move the frame by the placement of a joint, and turn it about its z axis."""
    yield _sines_of_joint(rows)
    for r in range(3):
        frame = [at(rows.frame + 3 * r + k) for k in range(3)]
        yield f"a0, a1, a2 = {', '.join(frame)}"
        yield f"{at(rows.origin + r, 'place + ')} = {at(rows.base + r, 'place + ')} + (a0 * c9 + a1 * c10 + a2 * c11)"
        yield from (f"b{k} = a0 * c{k} + a1 * c{k + 3} + a2 * c{k + 6}" for k in range(3))
        yield f"{at(rows.axis + r, 'place + ')} = b2"
        yield f"{frame[0]} = b0 * c + b1 * s"
        yield f"{frame[1]} = b1 * c - b0 * s"
        yield f"{frame[2]} = b2"


def _slide(rows: Rows) -> Iterator[str]:
    """Move the frame by the placement of a joint, and along its z axis.

    Its row of the Jacobian is not that of a joint that turns: with a zero for its axis, that one is zero.
    """
    yield f"q = {at(rows.q, 'turn + ')}"
    for r in range(3):
        frame = [at(rows.frame + 3 * r + k) for k in range(3)]
        yield f"a0, a1, a2 = {', '.join(frame)}"
        yield from (f"b{k} = a0 * c{k} + a1 * c{k + 3} + a2 * c{k + 6}" for k in range(3))
        before = f"{at(rows.base + r, 'place + ')} + (a0 * c9 + a1 * c10 + a2 * c11)"
        yield f"{at(rows.origin + r, 'place + ')} = {before} + b2 * q"
        yield f"{at(rows.slide + r, 'place + ')} = b2"
        yield f"{at(rows.axis + r, 'place + ')} = 0.0"
        yield from (f"{frame[k]} = b{k}" for k in range(3))


def _parallel(rows: Rows, w: int) -> Iterator[str]:
    """Do as :func:`_any` where frames are parallel at zero: the joint turns about axis ``w``, its link lies along z.

    What is left out are products with 0 and 1, which changes the signs of zeros alone. Nothing divides by them, and
    angles are not zero with a sign unless a limit is, which then gives them its own.
    """
    u, v = (w + 1) % 3, (w + 2) % 3
    yield _sines_of_joint(rows)
    for r in range(3):
        frame = [at(rows.frame + 3 * r + k) for k in range(3)]
        yield f"b{u}, b{v}, b{w} = {frame[u]}, {frame[v]}, {frame[w]}"
        yield f"{at(rows.origin + r, 'place + ')} = {at(rows.base + r, 'place + ')} + b2 * length"
        yield f"{at(rows.axis + r, 'place + ')} = b{w}"
        yield f"{frame[u]} = b{u} * c + b{v} * s"
        yield f"{frame[v]} = b{v} * c - b{u} * s"


def _link(rows: Rows) -> Iterator[str]:
    """Do as :func:`_parallel` for the tip, which does not turn."""
    for r in range(3):
        yield f"b2 = {at(rows.frame + 3 * r + 2)}"
        yield f"{at(rows.origin + r, 'place + ')} = {at(rows.base + r, 'place + ')} + b2 * length"


def _sines(n: int) -> Iterator[str]:
    """Sine and cosine of all angles, four at a time for the reason of :func:`mobo_core.evaluation.kernel.rows.halves`.

    With an odd number of joints the row after them is taken along.
    """
    rows, ways = Rows(n), 4
    size = (n + n % 2) * LANES // ways
    yield f"for k in range({size}):"
    each = [list(_sin_cos(f"state[{w * size} + k]", str(w))) for w in range(ways)]
    yield from indented(line for together in zip(*each, strict=True) for line in together)
    for w in range(ways):
        yield f"    state[{rows.sin * LANES + w * size} + k], state[{rows.cos * LANES + w * size} + k] = s{w}, c{w}"


def _sin_cos(angle: str, x: str) -> Iterator[str]:
    """As :func:`mobo_core.jit.numerics.sin_cos`, without a branch; ``x`` ends the names of its variables."""
    yield f"q{x} = {angle}"
    yield f"h{x} = np.floor(q{x} * {TWO_OVER_PI!r} + 0.5)"
    one, two, three = HALF_PI_PARTS
    yield f"r{x} = ((q{x} - h{x} * {one!r}) - h{x} * {two!r}) - h{x} * {three!r}"
    yield f"t{x} = r{x} * r{x}"
    yield f"p{x}, u{x} = {SIN_TERMS[0]!r}, {COS_TERMS[0]!r} * t{x} + {COS_TERMS[1]!r}"
    for sin_term, cos_term in zip(SIN_TERMS[1:], COS_TERMS[2:], strict=True):
        yield f"p{x} = p{x} * t{x} + {sin_term!r}"
        yield f"u{x} = u{x} * t{x} + {cos_term!r}"
    yield f"p{x}, u{x} = r{x} + r{x} * t{x} * p{x}, 1.0 + t{x} * u{x}"
    yield f"quarter{x} = np.int32(h{x})"
    yield f"s{x}, c{x} = (u{x} if quarter{x} & 1 else p{x}), (p{x} if quarter{x} & 1 else u{x})"
    yield f"s{x}, c{x} = (-s{x} if quarter{x} & 2 else s{x}), (-c{x} if (quarter{x} + 1) & 2 else c{x})"
