"""Where an arm stands in an atlas: its point, and how far it is from the front of all and of its own order.

The arm is scaled to the atlas's arms: straightened as long as they are, with their masses and radius, its own offsets
and limits kept, strokes scaled. So what differs is its structure.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mobo_core.arms.real import RealArm
from mobo_core.arms.resample import Interval, Resamples, Score
from mobo_core.atlas.atlas import Atlas, Floats
from mobo_core.design import Design, DesignSpace, to_urdf
from mobo_core.design.numbers import middle
from mobo_core.evaluation.evaluate import evaluate
from mobo_core.evaluation.result import Result
from mobo_core.evaluation.spec import EvaluationSpec

# Gains are measured on poses other than those by which the atlas chose its arms, and on so many times as many.
TIMES_POSES = 4
_LEAST_MM = 1.0
_ROUNDING = 1e-9  # an arm scaled to its own size differs from itself by less

Rows = NDArray[np.int64]


@dataclass(frozen=True)
class Rival:
    """An arm of the atlas that does better, and by how much.

    Attributes:
        row: of the atlas.
        design: the arm.
        reach, torque: share more than the placed arm's.
        moves: lengths that make the placed arm's twin into it; () if it has another order.
    """

    row: int
    design: Design
    reach: Interval
    torque: Interval
    moves: tuple[tuple[float, int, int], ...] = ()


@dataclass(frozen=True)
class Distance:
    """How far an arm is from a front: None where no arm of the front does better.

    Attributes:
        more_reach: the arm of the highest reach of those with no more torque, if it reaches more.
        less_torque: the arm of the least torque of those that reach no less, if it takes less.
        better: number of arms of the atlas that are no worse in both and better in one.
    """

    more_reach: Rival | None
    less_torque: Rival | None
    better: int


@dataclass(frozen=True, eq=False)
class Place:
    """Where an arm stands.

    Attributes:
        arm: as it is, with its order.
        scaled: evaluated as the atlas's arms were.
        twin: its idealised twin likewise; None if the space has arms of another number of joints.
        score: of the scaled arm, on the poses that gains are measured on.
        of_all, of_order: distances; None of an order that the atlas does not hold.
        trials_of_order: that its order got.
        resamples: by which gains are measured.
    """

    arm: RealArm
    scaled: Result
    twin: Result | None
    score: Score
    of_all: Distance
    of_order: Distance | None
    trials_of_order: int
    resamples: Resamples


def other_poses(spec: EvaluationSpec, times: int = TIMES_POSES) -> EvaluationSpec:
    """Return the same question with other poses, so many times as many in each voxel."""
    poses = min(times * spec.poses_per_voxel, 65535)
    return EvaluationSpec.of({**spec.to_dict(), "poses_per_voxel": poses, "seed": (spec.seed + 1) % 2**63})


def space_of(space: DesignSpace, n: int) -> DesignSpace:
    """Return the space whose masses, radius and pinions an arm of ``n`` joints gets: itself, or one of as many."""
    if n == space.n_joints:
        return space
    shared = ("link_radius", "link_density", "max_length", "motor_mass", "joint_limit", "slide_stroke", "slide_radius")
    values = {name: getattr(space, name) for name in shared}
    values = {name: value for name, value in values.items() if not isinstance(value, tuple)}
    return DesignSpace.of({"n_joints": n, **values})


def place(
    arm: RealArm, atlas: Atlas, progress: Callable[[int, int], None] = lambda done, total: None,
    times_poses: int = TIMES_POSES,
) -> Place:  # fmt: skip
    """Return where an arm stands in an atlas.

    Args:
        arm: with its order.
        atlas: some arms, with reach and torque.
        progress: called with (evaluations done, in all).
        times_poses: of the atlas's poses per voxel, for the gains.
    """
    assert arm.order is not None
    spec, space = atlas.spec, atlas.space
    using, total = space_of(space, arm.n), middle(space.total_length)
    urdf = arm.urdf(total, using)
    scaled = evaluate(urdf, spec)
    lengths = arm.order.twin(total)
    own = np.flatnonzero([joints == arm.order.joints for joints in atlas.joints])
    twin = evaluate(to_urdf(Design(arm.order.joints, lengths), using), spec) if arm.n == space.n_joints else None
    resamples = Resamples(other_poses(spec, times_poses))
    progress(2, 7)
    score = resamples.score(urdf)
    everything = np.arange(len(atlas))
    chosen = [better(atlas, rows, scaled) for rows in (everything, own)]
    wanted = sorted({row for pair in chosen for row in pair if row is not None})
    scores = {}
    for done, row in enumerate(wanted, start=3):
        progress(done, 3 + len(wanted))
        scores[row] = resamples.score(to_urdf(atlas.design(row), space))

    def rival(row: int | None) -> Rival | None:
        if row is None:
            return None
        design = atlas.design(row)
        reach, torque = scores[row].relative(score)
        moves = length_moves(lengths, design.lengths) if design.joints == arm.order.joints else ()  # type: ignore[union-attr]
        return Rival(row, design, reach, torque, moves)

    def distance(rows: Rows, pair: tuple[int | None, int | None]) -> Distance:
        reach, torque = atlas.values["reach"][rows], atlas.values["torque"][rows]
        up, down = 1 + _ROUNDING, 1 - _ROUNDING
        no_worse = (reach >= down * scaled.reach) & (torque <= up * scaled.torque)
        more = (reach > up * scaled.reach) | (torque < down * scaled.torque)
        return Distance(rival(pair[0]), rival(pair[1]), int((no_worse & more).sum()))

    progress(1, 1)
    return Place(
        arm, scaled, twin, score,
        distance(everything, chosen[0]),
        distance(own, chosen[1]) if len(own) else None,
        int(atlas.trials_of_order[own[0]]) if len(own) else 0,
        resamples,
    )  # fmt: skip


def better(atlas: Atlas, rows: Rows, result: Result) -> tuple[int | None, int | None]:
    """Return of some rows that of the highest reach at no more torque, and that of the least torque at no less reach.

    None where that is not better than the arm itself.
    """
    reach, torque = atlas.values["reach"], atlas.values["torque"]
    by_reach = _least(rows, torque <= (1 + _ROUNDING) * result.torque, -reach)
    by_torque = _least(rows, reach >= (1 - _ROUNDING) * result.reach, torque)
    return (
        by_reach if by_reach is not None and reach[by_reach] > (1 + _ROUNDING) * result.reach else None,
        by_torque if by_torque is not None and torque[by_torque] < (1 - _ROUNDING) * result.torque else None,
    )


def _least(rows: Rows, may: NDArray[np.bool_], key: Floats) -> int | None:
    fitting = rows[may[rows]]
    return int(fitting[np.argmin(key[fitting])]) if len(fitting) else None


def length_moves(before: Sequence[float], after: Sequence[float]) -> tuple[tuple[float, int, int], ...]:
    """Return what makes some lengths into others of the same sum: (m, from link, to link), links from 1, most first."""
    change = np.array(after) - np.array(before)
    moves: list[tuple[float, int, int]] = []
    while change.max(initial=0.0) > 1e-3 * _LEAST_MM and change.min(initial=0.0) < -1e-3 * _LEAST_MM:
        source, sink = int(change.argmin()), int(change.argmax())
        by = float(min(-change[source], change[sink]))
        change[source] += by
        change[sink] -= by
        moves.append((by, source + 1, sink + 1))
    return tuple(sorted(moves, reverse=True))
