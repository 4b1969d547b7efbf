"""What the joints of a study's best arms have to hold: these arms are evaluated again for it."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Collection, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from mobo_core.bag.record import StudyRecord
from mobo_core.errors import MoboError
from mobo_core.evaluation.result import Result
from mobo_core.report.columns import Cell, Columns
from mobo_core.report.row import Row, rank
from mobo_core.report.table import StudyTable

# Arms evaluated again at most, and poses tried for them in all (some 6 s on one core); one arm in any case.
MOST_ARMS = 300
_MOST_POSES = 700_000


@dataclass(frozen=True)
class HeldArm:
    """An arm evaluated again.

    Attributes:
        row: the trial.
        result: with the torque of each joint, and the configurations.
        same: whether reach and torque are those recorded, to the bit, over the voxels in which any pose was reached;
            not if the answer was invented.
    """

    row: Row
    result: Result
    same: bool


def chosen(table: StudyTable, n_poses: int, pinned: Collection[int] = ()) -> list[Row]:
    """Return which arms to evaluate again: the front above the reach floor, then the best of each other order.

    Args:
        table: the trials.
        n_poses: that one evaluation tries.
        pinned: trials that come before all of these.
    """
    best: dict[str, Row] = {}
    for row in sorted(table.complete, key=rank):
        best.setdefault(row.joints, row)
    front = table.useful_front
    shown = {row.joints for row in front}
    rows = front + [row for joints, row in best.items() if row.above_floor and joints not in shown]
    first = [row for row in table.complete if row.trial in pinned]
    rows = first + [row for row in rows if row.trial not in pinned]
    return rows[: max(1, min(MOST_ARMS, _MOST_POSES // n_poses))]


def held_arms(
    study: StudyRecord, table: StudyTable, progress: Callable[[int, int], None], pinned: Collection[int] = ()
) -> list[HeldArm]:
    """Return the arms of :func:`chosen`, evaluated; those that cannot be, such as of a damaged bag, are left out.

    Args:
        study: as read from its bag.
        table: its trials.
        progress: called with (arms done, arms in all).
        pinned: trials to evaluate whatever they are worth.
    """
    spec = study.settings.spec
    rows = chosen(table, spec.n_voxels * spec.poses_per_voxel, pinned)
    found = []
    # An arm a thread: parts of one arm would leave the kernel's lanes empty at their ends.
    with ThreadPoolExecutor(min(4, os.cpu_count() or 1)) as pool:
        for done, arm in enumerate(pool.map(lambda row: _held(study, row), rows)):
            progress(done, len(rows))
            found += [arm] if arm is not None else []
    progress(len(rows), len(rows))
    return found


def _held(study: StudyRecord, row: Row) -> HeldArm | None:
    from mobo_core.evaluation.evaluate import evaluate

    candidate, answer = study.candidate_of(row.trial), study.accepted(row.trial)
    if candidate is None:
        return None
    # Poses that were not reached cost the most, and have nothing to hold.
    reached = answer.voxel_reach > 0 if answer is not None else None
    try:
        result = evaluate(
            candidate.urdf, study.settings.spec, tip=candidate.tip, joint_torques=True, configurations=True,
            voxels=reached,
        )  # fmt: skip
    except MoboError:
        return None
    return HeldArm(row, result, (result.reach, result.torque) == (row.reach, row.torque))


def torque_columns(arms: Iterable[HeldArm]) -> Columns:
    """Return a row for each joint of each arm; torques in N m."""
    columns: Columns = {name: [] for name in ("trial", "joints", "mean_torque", "joint", "mean", "p95", "peak")}
    for arm in arms:
        for joint in arm.result.joint_torques or ():
            cells: dict[str, Cell] = {
                "trial": arm.row.trial, "joints": arm.row.joints, "mean_torque": _number(arm.result.mean_torque),
                **joint.to_dict(),
            }  # fmt: skip
            for name, column in columns.items():
                column.append(cells[name])
    return columns


def torque_rows(arms: Iterable[HeldArm]) -> list[list[str]]:
    """Return the cells of the page's table: trial, joints, torque per reached voxel, then each joint's three."""
    rows = []
    for arm in arms:
        cells = [
            "-" if math.isnan(joint.peak) else f"{joint.mean:.1f} / {joint.p95:.1f} / {joint.peak:.1f}"
            for joint in arm.result.joint_torques or ()
        ]
        mean = arm.result.mean_torque
        rows.append([str(arm.row.trial), arm.row.joints, "-" if math.isnan(mean) else f"{mean:.2f}", *cells])
    return rows


def _number(value: float) -> float | None:
    return None if math.isnan(value) else value
