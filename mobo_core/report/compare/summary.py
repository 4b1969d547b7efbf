"""What is kept of a study to compare it with others."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mobo_core.bag.record import StudyRecord
from mobo_core.report.claims.evidence import of_study, sound
from mobo_core.report.row import Row
from mobo_core.report.table import StudyTable, study_table
from mobo_core.report.uncertainty import RESAMPLES, near_front, standard_errors
from mobo_core.search.front import aims_of, hypervolume
from mobo_core.search.study import StudySettings

Interval = tuple[float, float]
COMMON = ("reach", "torque")  # the objectives by which studies are compared, whatever theirs are
_Z = 1.96


@dataclass(frozen=True)
class Best:
    """The arm of the highest reach of a prefix.

    Attributes:
        row: the arm.
        trials: of the prefix.
        half: voxels, half of the 95 % interval of its reach, as other poses would have it.
        known: whether the prefix was searched enough for its best to say something of it.
    """

    row: Row
    trials: int
    half: float
    known: bool


@dataclass(frozen=True)
class Summary:
    """A study, without its messages.

    Attributes:
        label: what it is called here, unlike all others.
        name: of the study.
        settings: of the study.
        table: of its trials.
        volume: hypervolume of reach and torque, and its 95 % interval as other poses would have it.
        prefixes: best arm of each prefix.
        step: voxels that reaches have to differ by to count.
        simulated: whether its values are invented.
    """

    label: str
    name: str
    settings: StudySettings
    table: StudyTable
    volume: float
    volume_interval: Interval
    prefixes: dict[str, Best]
    step: float
    simulated: bool

    @property
    def best(self) -> Row | None:
        """The arm of the highest reach of all."""
        rows = [best.row for best in self.prefixes.values()]
        return min(rows, key=lambda row: (-row.reach, row.torque, row.trial), default=None)

    @cached_property
    def volumes(self) -> list[float]:
        """The hypervolume after each of 50 equal parts of the trials."""
        n = len(self.table.rows)
        return [self.volume_at(round(n * (i + 1) / 50)) for i in range(50)] if n else []

    @cached_property
    def _sound(self) -> list[Row]:
        return [row for row in self.table.complete if sound(row, self.table.n_joints, self.table.n_voxels)]

    def _after(self, n_trials: int) -> float:
        """Return the number of the trial after the first ones."""
        return self.table.rows[n_trials].trial if n_trials < len(self.table.rows) else math.inf

    def volume_at(self, n_trials: int) -> float:
        """Return the hypervolume of the first trials."""
        rows = [(row.reach, row.torque) for row in self._sound if row.trial < self._after(n_trials)]
        return hypervolume(rows, aims_of(COMMON, self.settings.spec))

    @property
    def front(self) -> list[tuple[float, float]]:
        """Reach and torque of the front of these two, above the reach floor, by rising reach."""
        found: list[tuple[float, float]] = []
        for row in sorted(self._sound, key=lambda row: (-row.reach, row.torque)):
            if row.above_floor and (not found or row.torque < found[-1][1]):
                found.append((row.reach, row.torque))
        return found[::-1]


def summary_of(study: StudyRecord, label: str) -> Summary:
    """Return what is kept of a study."""
    table = study_table(study)
    evidence = of_study(study, table)
    rows = {row.trial: row for row in table.complete}
    best = {prefix: rows[members.best.trial] for prefix, members in evidence.prefixes.items()}
    errors = standard_errors(study, list(best.values()))[0]
    prefixes = {
        prefix: Best(best[prefix], members.trials, _Z * float(error) if math.isfinite(error) else math.nan,
                     members.known)
        for (prefix, members), error in zip(evidence.prefixes.items(), errors.tolist(), strict=True)
    }  # fmt: skip
    volume, interval = _volume(study, table)
    engines = {study.settings.engine, *(candidate.engine for candidate in study.candidates[:1])}
    invented = "simulated" in engines
    return Summary(label, study.name, study.settings, table, volume, interval, prefixes, evidence.step, invented)


def _volume(study: StudyRecord, table: StudyTable) -> tuple[float, Interval]:
    """Return the hypervolume, and its interval if other poses were drawn.

    Noise makes some arms better than they are, and the front takes those: so it is the spread of the noisy
    hypervolumes about their own mean that counts.
    """
    aims = aims_of(COMMON, study.settings.spec)
    complete = [row for row in table.complete if sound(row, table.n_joints, table.n_voxels)]
    value = hypervolume([(row.reach, row.torque) for row in complete], aims)
    trials = {row.trial for row in complete}
    near = [row for row in near_front(table) if row.trial in trials]
    if not near:
        return value, (value, value)
    means = np.array([[row.reach, row.torque] for row in near])
    errors = np.nan_to_num(np.array(standard_errors(study, near)).T)
    chance = np.random.default_rng(0)
    drawn = np.array([
        hypervolume((means + errors * chance.standard_normal(means.shape)).tolist(), aims) for _ in range(RESAMPLES)
    ])  # fmt: skip
    low, high = np.percentile(drawn - drawn.mean(), (2.5, 97.5))
    return value, (value + float(low), value + float(high))
