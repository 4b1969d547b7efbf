"""The trials of an Optuna study as arrays, kept up to date as trials begin and end."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from optuna import Study
from optuna.distributions import BaseDistribution, FloatDistribution
from optuna.study import StudyDirection
from optuna.trial import FrozenTrial, TrialState

from mobo_core.jit.normal import CENTRAL
from mobo_core.search.samplers.tpe import compiled, density
from mobo_core.search.samplers.tpe.estimator import Space
from mobo_core.search.samplers.tpe.ranking import insert_sorted

_NONE, _TOLD, _PENDING = 0, 1, 2


@compiled
def gather(values: np.ndarray, rows: np.ndarray, columns: np.ndarray, out: np.ndarray) -> None:
    """Copy ``values[columns][:, rows]`` into the first columns of ``out``."""
    for j in range(columns.size):
        column, into = values[columns[j]], out[j]
        for i in range(rows.size):
            into[i] = column[rows[i]]


@compiled
def insert_ascending(ascending: np.ndarray, numbers: np.ndarray, count: int, value: float, number: int) -> None:
    """Insert a value into the first ``count`` of ``ascending``, and beside it the number of its trial."""
    place = np.searchsorted(ascending[:count], value)
    for i in range(count, place, -1):
        ascending[i], numbers[i] = ascending[i - 1], numbers[i - 1]
    ascending[place], numbers[place] = value, number


class _Column:
    """The values of one real parameter in ascending order, and the numbers of their trials."""

    def __init__(self) -> None:
        self._ascending, self._numbers = np.empty(0), np.empty(0, np.int32)
        self._count = 0

    def add(self, value: float, number: int) -> None:
        """Take in another trial."""
        if self._count == len(self._ascending):
            more = self._count + 64
            self._ascending = np.concatenate([self._ascending, np.empty(more)])
            self._numbers = np.concatenate([self._numbers, np.empty(more, np.int32)])
        insert_ascending(self._ascending, self._numbers, self._count, value, number)
        self._count += 1

    def lies_in(self, low: float, high: float) -> bool:
        """Return whether all values lie within bounds."""
        return not self._count or bool(low <= self._ascending[0] and self._ascending[self._count - 1] <= high)

    def multiply_volumes(self, low: float, high: float, sigma: float, volume: NDArray[np.float64]) -> None:
        """Multiply this parameter's part of :func:`density.volumes` into ``volume``, by trial number."""
        ascending, numbers = self._ascending[: self._count], self._numbers[: self._count]
        density.multiply_volumes(ascending, numbers, low, high, sigma, CENTRAL, volume)


class History:
    """What a sampler needs of the trials of one study of two objectives.

    Only trials that were not finished at the last look are looked at again, so that an update costs as much as
    there are trials in flight, however many are finished.

    Attributes:
        columns: parameter -> its row in ``values``.
        values: parameters in Optuna's internal representation, shape (parameters, capacity), by trial number; NaN
            where a trial has no such parameter.
        loss: the objectives, to be minimised, shape (capacity, 2).
        order: numbers of the complete trials, sorted by loss; the first ``count`` entries hold.
        count: number of complete trials.
        space: distributions that all complete trials share, by name in alphabetical order.
        changes: grows with every change of what is known of any trial.
        odd: whether a trial was pruned or has a value that is not finite: then these arrays do not tell all.
    """

    def __init__(self) -> None:
        self.columns: dict[str, int] = {}
        self.values = np.empty((0, 0))
        self.loss, self.order = np.empty((0, 2)), np.empty(0, np.int64)
        self.count = self.changes = 0
        self.odd = False
        self._state = np.empty(0, np.int8)
        self._space: dict[str, BaseDistribution] | None = None
        self._gaps: set[str] = set()  # parameters that some trial lacks
        self._real: dict[str, _Column] = {}
        self._open: dict[int, tuple[int, int]] = {}  # number -> (trial id, parameters known)
        self._next = 0

    @property
    def space(self) -> dict[str, BaseDistribution]:
        """The distributions that all complete trials share."""
        return dict(sorted((self._space or {}).items()))

    def update(self, study: Study, current: int) -> None:
        """Take in what happened since the last update to all trials but the one that is drawn just now."""
        storage, study_id = study._storage, study._study_id
        while True:
            try:
                trial_id = storage.get_trial_id_from_study_id_trial_number(study_id, self._next)
            except KeyError:
                break
            self._open[self._next] = (trial_id, -1)
            self._next += 1
        if self._next > len(self._state):
            self._grow(2 * self._next + 64)
        for number, (trial_id, known) in list(self._open.items()):
            if number == current:
                continue
            trial = storage.get_trial(trial_id)
            if trial.state.is_finished():
                self.changes += 1
                del self._open[number]
                self._finish(study, trial)
            elif len(trial.params) != known:
                self.changes += 1
                self._set_row(trial)
                self._state[number] = _PENDING
                self._open[number] = (trial_id, len(trial.params))

    def rows(self, *, pending: bool) -> NDArray[np.int64]:
        """Return the numbers of the complete trials, and of the pending ones if asked for, in ascending order."""
        state = self._state[: self._next]
        return np.flatnonzero(state != _NONE if pending else state == _TOLD)

    def codes(self, rows: NDArray[np.int64], space: Space) -> NDArray[np.int16]:
        """Return some trials' choices, shape (categorical parameters, rows + 1): the last column is free."""
        out = np.empty((len(space.categorical), len(rows) + 1), np.int16)
        self._gather(rows, space.categorical, out)
        return out

    def reals(self, rows: NDArray[np.int64], space: Space) -> NDArray[np.float64]:
        """Return some trials' real values as :class:`~mobo_core.search.samplers.tpe.estimator.Estimator` has them."""
        lead = max(0, density.WIDTH - len(space.real))
        out = np.empty((lead + len(space.real), len(rows) + 1))
        out[:lead] = 0.0
        self._gather(rows, space.real, out[lead:])
        return out

    def _gather(self, rows: NDArray[np.int64], names: list[str], out: NDArray[Any]) -> None:
        if len(rows):
            gather(self.values, rows, np.array([self.columns[name] for name in names], np.int64), out)

    def volumes(
        self, rows: NDArray[np.int64], space: Space, sigma: NDArray[np.float64]
    ) -> NDArray[np.float64] | None:
        """Return :func:`density.volumes` of some trials for these bandwidths, one for each real parameter, or None.

        They are taken of all trials, in the order of their values: not worth it for a few of them, and only right
        if all values lie within the bounds.
        """
        if 4 * len(rows) < self.count or not len(rows):
            return None
        columns = [self._real[name] for name in space.real]
        bounds = list(zip(space.low.tolist(), space.high.tolist(), strict=True))
        if not all(column.lies_in(*ends) for column, ends in zip(columns, bounds, strict=True)):
            return None
        volume = np.ones(self._next)
        for column, ends, one in zip(columns, bounds, sigma.tolist(), strict=True):
            column.multiply_volumes(*ends, one, volume)
        return volume[rows]

    def with_all(self, rows: NDArray[np.int64], names: list[str]) -> NDArray[np.int64]:
        """Return those of some trials that have all of some parameters."""
        if any(name not in self.columns for name in names):
            return rows[:0]
        gaps = [self.columns[name] for name in names if name in self._gaps]
        return rows[~np.isnan(self.values[gaps][:, rows]).any(axis=0)] if gaps else rows

    def _finish(self, study: Study, trial: FrozenTrial) -> None:
        number = trial.number
        self._state[number] = _NONE
        if trial.state == TrialState.PRUNED:
            self.odd = True
        if trial.state != TrialState.COMPLETE:
            return
        self._set_row(trial)
        sign = [-1.0 if d == StudyDirection.MAXIMIZE else 1.0 for d in study.directions]
        self.loss[number] = np.multiply(trial.values, sign)
        if not np.isfinite(self.loss[number]).all():
            self.odd = True
            return
        self._state[number] = _TOLD
        insert_sorted(self.order, self.count, self.loss, number)
        self.count += 1
        if self._space is None:
            self._space = dict(trial.distributions)
        elif self._space:
            theirs = trial.distributions
            self._space = {name: own for name, own in self._space.items() if theirs.get(name) == own}

    def _set_row(self, trial: FrozenTrial) -> None:
        for name in trial.params:
            if name not in self.columns:
                if trial.number and (self._state[: trial.number] != _NONE).any():
                    self._gaps.add(name)
                self.columns[name] = len(self.columns)
                self.values = np.vstack([self.values, np.full((1, self.values.shape[1]), np.nan)])
        self._gaps.update(self.columns.keys() - trial.params.keys())
        number = trial.number
        for name, value in trial.params.items():
            row, distribution = self.values[self.columns[name]], trial.distributions[name]
            new = np.isnan(row[number])
            row[number] = distribution.to_internal_repr(value)
            if new and isinstance(distribution, FloatDistribution):
                self._real.setdefault(name, _Column()).add(row[number], number)

    def _grow(self, capacity: int) -> None:
        old = len(self._state)
        self.values = np.hstack([self.values, np.full((len(self.values), capacity - old), np.nan)])
        self.loss = np.vstack([self.loss, np.empty((capacity - old, 2))])
        self.order = np.concatenate([self.order, np.empty(capacity - old, np.int64)])
        self._state = np.concatenate([self._state, np.zeros(capacity - old, np.int8)])
