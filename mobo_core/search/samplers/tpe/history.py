"""The trials of an Optuna study as arrays, kept up to date as trials begin and end."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from optuna import Study
from optuna.distributions import BaseDistribution
from optuna.study import StudyDirection
from optuna.trial import FrozenTrial, TrialState

from mobo_core.search.samplers.tpe import compiled
from mobo_core.search.samplers.tpe.ranking import insert_sorted

_NONE, _TOLD, _PENDING = 0, 1, 2


@compiled
def gather(values: np.ndarray, rows: np.ndarray, columns: np.ndarray, out: np.ndarray) -> None:
    """Copy ``values[columns][:, rows]``, turned round, into the first rows of ``out``."""
    for j in range(columns.size):
        column = values[columns[j]]
        for i in range(rows.size):
            out[i, j] = column[rows[i]]


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

    def gathered(self, rows: NDArray[np.int64], names: list[str]) -> NDArray[np.float64]:
        """Return the values of some parameters for some trials, shape (rows + 1, names): the last row is free."""
        out = np.empty((len(rows) + 1, len(names)))
        if len(rows):
            gather(self.values, rows, np.array([self.columns[name] for name in names], np.int64), out)
        return out

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
        self.values[:, number] = np.nan
        for name, value in trial.params.items():
            self.values[self.columns[name], number] = trial.distributions[name].to_internal_repr(value)

    def _grow(self, capacity: int) -> None:
        old = len(self._state)
        self.values = np.hstack([self.values, np.full((len(self.values), capacity - old), np.nan)])
        self.loss = np.vstack([self.loss, np.empty((capacity - old, 2))])
        self.order = np.concatenate([self.order, np.empty(capacity - old, np.int64)])
        self._state = np.concatenate([self._state, np.zeros(capacity - old, np.int8)])
