"""A study as a table: one row for each trial told, and which of them are on the Pareto front."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

from mobo_core.arms.catalogue import known_arms
from mobo_core.bag.record import StudyRecord
from mobo_core.bag.validity import values_of
from mobo_core.evaluation.objectives import OBJECTIVES
from mobo_core.frames import data_frame
from mobo_core.messages import Trial
from mobo_core.report.columns import Columns, table_columns
from mobo_core.report.row import Row, rank
from mobo_core.search.front import Aims, RunningFront, hypervolume, pareto_front

if TYPE_CHECKING:
    from pandas import DataFrame

# An arm that reaches nothing takes no torque, and no arm dominates it: the raw front always runs down to
# zero reach. The part worth looking at begins at this share of the voxels.
REACH_FLOOR_SHARE = 0.1


@dataclass(frozen=True, repr=False)
class StudyTable:
    """The trials of a study.

    Attributes:
        rows: one a trial told, by number.
        n_joints: of the space.
        n_voxels: of the spec; no arm's reach is higher.
        aims: of the objectives.
    """

    rows: tuple[Row, ...]
    n_joints: int
    n_voxels: int
    aims: Aims = ()

    @property
    def floor(self) -> float:
        """The reach below which an arm is of no use, a tenth of the voxels."""
        return REACH_FLOOR_SHARE * self.n_voxels

    @cached_property
    def complete(self) -> list[Row]:
        """The trials that have values, by number."""
        return [row for row in self.rows if row.complete]

    @cached_property
    def further(self) -> dict[str, str]:
        """The study's objectives beyond reach and torque: name -> heading with unit; none if no trial is complete."""
        names = [name for row in self.complete[:1] for name, _ in row.extra]
        return {name: f"{name} [{OBJECTIVES[name].unit}]" if name in OBJECTIVES else name for name in names}

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

        If reach is an objective, leaving out the arms below the floor first changes nothing above it: what dominates
        an arm reaches at least as much.
        """
        return [row for row in self.front if row.above_floor]

    def hypervolume(self, n_trials: int) -> float:
        """Return the hypervolume of the first trials told, failed ones counted."""
        return hypervolume([row.values for row in self.rows[:n_trials] if row.complete], self.aims)

    def __repr__(self) -> str:
        best = f", best reach {self.front[0].reach:.2f} of {self.n_voxels}" if self.front else ""
        return (
            f"<StudyTable: {len(self.rows)} trials of {self.n_joints} joints, {len(self.failed)} failed, "
            f"{len(self.front)} on the front{best}>"
        )

    def to_dict(self) -> Columns:
        """Return column -> values, a value a trial, as in ``trials.csv``; what a failed trial lacks is None."""
        return table_columns(self.rows, self.n_joints)

    def to_pandas(self) -> DataFrame:
        """Return :meth:`to_dict` as a data frame, a row a trial.

        Raises:
            InputError: pandas is not installed.
        """
        return data_frame(self.to_dict(), "trial")


def study_table(study: StudyRecord) -> StudyTable:
    """Return the table of a study."""
    numbers = sorted(study.trials)
    trials = [study.trials[number] for number in numbers]
    settings = study.settings
    values: dict[int, tuple[float, ...]] = {}
    for trial in trials:
        found = values_of(trial, settings.objectives)
        # A record of the bag may claim anything: values that are not numbers count as none.
        if trial.state == Trial.COMPLETE and all(map(math.isfinite, (trial.reach, trial.torque, *found))):
            values[trial.trial] = found
    complete = list(values)
    on_front = {complete[i] for i in pareto_front(list(values.values()), settings.aims)}
    n_voxels = settings.spec.n_voxels
    floor = REACH_FLOOR_SHARE * n_voxels
    rows = [_row(study, trial, values.get(trial.trial, ()), trial.trial in on_front, floor) for trial in trials]
    return StudyTable(tuple(rows), settings.space.n_joints, n_voxels, settings.aims)


def _row(study: StudyRecord, told: Trial, values: tuple[float, ...], on_front: bool, floor: float) -> Row:
    complete, objectives = bool(values), study.settings.objectives
    number = told.trial
    candidate, evaluation = study.candidate_of(number), study.accepted(number)
    joints = candidate.joints if candidate is not None else ""
    return Row(
        trial=number,
        complete=complete,
        joints=joints,
        sampled_joints=candidate.sampled_joints if candidate is not None else "",
        lengths=tuple(float(length) for length in candidate.lengths) if candidate is not None else (),
        reach=told.reach if complete else math.nan,
        torque=told.torque if complete else math.nan,
        on_front=on_front,
        above_floor=complete and bool(told.reach >= floor),
        known_as=tuple(known_arms(joints)),
        attempt=told.attempt,
        evaluator=told.evaluator,
        seconds=evaluation.seconds if evaluation is not None else math.nan,
        reason=told.reason,
        values=values,
        extra=tuple(pair for pair in zip(objectives, values, strict=False) if pair[0] not in ("reach", "torque")),
    )


def running_hypervolume(table: StudyTable, steps: int = 100) -> tuple[Sequence[int], Sequence[float]]:
    """Return (trials told so far, hypervolume of those) at up to ``steps`` points, the last trial included."""
    n = len(table.rows)
    counts = sorted({max(1, round(n * (i + 1) / steps)) for i in range(steps)}) if n else []
    front, volumes = RunningFront(table.aims), []
    for first, last in pairwise([0, *counts]):
        for row in table.rows[first:last]:
            if row.complete:
                front.add(row.values)
        volumes.append(front.hypervolume)
    return counts, volumes
