"""A study as a table: one row for each trial told, and which of them are on the Pareto front."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from mobo_core.bag.record import StudyRecord
from mobo_core.design.catalogue import known_arms
from mobo_core.messages import message_type
from mobo_core.search.front import hypervolume, pareto_front

# An arm that reaches nothing takes no torque, and no arm dominates it: the raw front always runs down to
# zero reach. The part worth looking at begins at this share of the voxels.
REACH_FLOOR_SHARE = 0.1


@dataclass(frozen=True)
class Row:
    """One trial that was told.

    Attributes:
        trial: its number.
        complete: whether it has values.
        joints: joint order as built, such as ``YPPYPY``; "" if the bag lost its candidate.
        sampled_joints: joint order as drawn.
        lengths: m, one a joint.
        reach: sum over the voxels of the share of poses reached; NaN if it failed.
        torque: N m, sum over the voxels of the mean norm of the gravity torque; NaN if it failed.
        on_front: whether no other trial reaches at least as much with at most as much torque.
        above_floor: whether its reach is that of a useful arm, see :data:`REACH_FLOOR_SHARE`.
        known_as: names of the known arms of this joint order.
        attempt: which sending of it was answered.
        evaluator: who answered.
        seconds: s, wall time of the evaluation.
        reason: why it failed, else "".
    """

    trial: int
    complete: bool
    joints: str
    sampled_joints: str
    lengths: tuple[float, ...]
    reach: float
    torque: float
    on_front: bool
    above_floor: bool
    known_as: tuple[str, ...]
    attempt: int
    evaluator: str
    seconds: float
    reason: str

    @property
    def state(self) -> str:
        """``COMPLETE`` or ``FAIL``."""
        return "COMPLETE" if self.complete else "FAIL"


@dataclass(frozen=True)
class StudyTable:
    """The trials of a study.

    Attributes:
        rows: one a trial told, by number.
        n_joints: of the space.
        n_voxels: of the spec; no arm's reach is higher.
    """

    rows: tuple[Row, ...]
    n_joints: int
    n_voxels: int

    @property
    def floor(self) -> float:
        """The reach below which an arm is of no use, a tenth of the voxels."""
        return REACH_FLOOR_SHARE * self.n_voxels

    @cached_property
    def complete(self) -> list[Row]:
        """The trials that have values, by number."""
        return [row for row in self.rows if row.complete]

    @cached_property
    def failed(self) -> list[Row]:
        """The trials that failed, by number."""
        return [row for row in self.rows if not row.complete]

    @cached_property
    def front(self) -> list[Row]:
        """The raw Pareto front by falling reach, arms of hardly any reach included."""
        return sorted((row for row in self.complete if row.on_front), key=rank)

    @property
    def useful_front(self) -> list[Row]:
        """The Pareto front above the reach floor, by falling reach.

        It is a part of the raw front: what dominates an arm reaches at least as much, so that leaving out
        the arms below the floor first changes nothing above it.
        """
        return [row for row in self.front if row.above_floor]


def rank(row: Row) -> tuple[float, float, int]:
    """Return what rows are sorted by to have the highest reach first; of equals the least torque."""
    return (-row.reach, row.torque, row.trial)


def study_table(study: StudyRecord) -> StudyTable:
    """Return the table of a study."""
    complete_state = message_type("Trial").COMPLETE
    numbers = sorted(study.trials)
    trials = [study.trials[number] for number in numbers]
    # A record of the bag may claim anything: values that are not numbers count as none.
    valued = [
        trial
        for trial in trials
        if trial.state == complete_state and math.isfinite(trial.reach) and math.isfinite(trial.torque)
    ]
    front = pareto_front([trial.reach for trial in valued], [trial.torque for trial in valued])
    on_front = {int(valued[i].trial) for i in front}
    complete = {int(trial.trial) for trial in valued}
    n_voxels = study.settings.spec.n_voxels
    rows = [
        _row(study, trial, int(trial.trial) in complete, int(trial.trial) in on_front, REACH_FLOOR_SHARE * n_voxels)
        for trial in trials
    ]
    return StudyTable(tuple(rows), study.settings.space.n_joints, n_voxels)


def _row(study: StudyRecord, told: Any, complete: bool, on_front: bool, floor: float) -> Row:
    number = int(told.trial)
    candidate, evaluation = study.candidate_of(number), study.accepted(number)
    joints = str(candidate.joints) if candidate is not None else ""
    return Row(
        trial=number,
        complete=complete,
        joints=joints,
        sampled_joints=str(candidate.sampled_joints) if candidate is not None else "",
        lengths=tuple(float(length) for length in candidate.lengths) if candidate is not None else (),
        reach=float(told.reach) if complete else math.nan,
        torque=float(told.torque) if complete else math.nan,
        on_front=on_front,
        above_floor=complete and bool(told.reach >= floor),
        known_as=tuple(known_arms(joints)),
        attempt=int(told.attempt),
        evaluator=str(told.evaluator),
        seconds=float(evaluation.seconds) if evaluation is not None else math.nan,
        reason=str(told.reason),
    )


def running_hypervolume(table: StudyTable, steps: int = 100) -> tuple[Sequence[int], Sequence[float]]:
    """Return (trials told so far, hypervolume of those) at up to ``steps`` points, the last trial included."""
    n = len(table.rows)
    counts = sorted({max(1, round(n * (i + 1) / steps)) for i in range(steps)}) if n else []
    volumes = []
    for count in counts:
        told = [row for row in table.rows[:count] if row.complete]
        reach, torque = [row.reach for row in told], [row.torque for row in told]
        volumes.append(hypervolume(reach, torque, table.n_voxels))
    return counts, volumes
