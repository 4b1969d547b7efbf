"""The search of structures as an Optuna sampler."""

from __future__ import annotations

from collections import deque
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray
from optuna import Study
from optuna.distributions import BaseDistribution
from optuna.samplers import BaseSampler
from optuna.trial import BaseTrial, FrozenTrial, TrialState

from mobo_core.design import Design
from mobo_core.search.front import aims_of
from mobo_core.search.samplers.sampler import Task
from mobo_core.search.samplers.structured.orders import sampled_orders, twins
from mobo_core.search.samplers.structured.search import Search


class StructuredSampler(BaseSampler):
    """Searches the lengths of each joint order by themselves, and shares the trials out among the orders.

    Use it where a study is to say which structures are good, not only which arms. Of the trials half go to the orders
    that may add most to the front of all, half to those that are known least, see
    :class:`~mobo_core.search.samplers.structured.policy.Policy`. Within an order a Gaussian process over the lengths
    (:mod:`~mobo_core.search.samplers.structured.model`) picks from points that are drawn anywhere, taken over from
    other orders, and bred from the order's front the one that may add most to the hypervolume.

    All it keeps follows from the trials. One sampler serves one study.

    Args:
        task: space, spec and objectives of the study, and its seed.
    """

    def __init__(self, task: Task) -> None:
        self._space, self._aims = task.space, aims_of(task.objectives, task.spec)
        self._sampled = sampled_orders(task.space)
        self._names = list(self._sampled)
        self._number = {name: i for i, name in enumerate(self._names)}
        twin = twins(task.space, task.spec, task.objectives)
        self.search = Search(
            task.space,
            len(self._names),
            [self._number[twin[name]] if name in twin else -1 for name in self._names],
            [aim.maximize for aim in self._aims],
            task.n_startup_trials,
            task.seed,
            task.sampler_rules,
        )
        # Trials asked and not told: storage's id, order and point.
        self._open: deque[tuple[int, int, int, NDArray[np.float64]]] = deque()
        self._next = 0
        self._drawn: dict[str, Any] = {}

    def infer_relative_search_space(self, study: Study, trial: FrozenTrial) -> dict[str, BaseDistribution]:
        """Return nothing: all is drawn in :meth:`before_trial`."""
        return {}

    def sample_relative(
        self, study: Study, trial: FrozenTrial, search_space: dict[str, BaseDistribution]
    ) -> dict[str, object]:
        """Return nothing: all is drawn in :meth:`before_trial`."""
        return {}

    def before_trial(self, study: Study, trial: FrozenTrial) -> None:
        """Draw the trial's parameters."""
        self._update(study, trial.number)
        order, point = self.search.next(trial.number)
        n = self._space.n_joints
        wanted, (total, height, tilt, *searched) = point[:n].tolist(), point[n:].tolist()
        lengths = self._space.links.settled(wanted, total)
        own = iter(searched)
        centers = [next(own) if isinstance(each, tuple) else each for each in self._space.centers] if searched else []
        design = Design(self._sampled[self._names[order]], lengths[:n], height, tilt, tuple(centers))
        self._drawn = self._space.params(design)

    def sample_independent(
        self, study: Study, trial: FrozenTrial, param_name: str, param_distribution: BaseDistribution
    ) -> object:
        """Return the parameter as drawn."""
        return self._drawn[param_name]

    def _update(self, study: Study, current: int) -> None:
        """Take in what happened since the last update to all trials but the one that is drawn just now."""
        storage = study._storage
        while self._next < current:
            trial_id = storage.get_trial_id_from_study_id_trial_number(study._study_id, self._next)
            design = self._space.suggest(cast(BaseTrial, _Known(storage.get_trial(trial_id).params)))
            total = self._space.total_of(design)
            centers = zip(design.joint_centers, self._space.centers, strict=False)
            searched = [center for center, allowed in centers if isinstance(allowed, tuple)]
            point = np.array([*design.lengths, total, design.base_height, design.base_tilt, *searched])
            order = self._number[design.joints]
            self.search.asked(self._next, order, point)
            self._open.append((self._next, trial_id, order, point))
            self._next += 1
        while self._open:
            number, trial_id, order, point = self._open[0]
            trial = storage.get_trial(trial_id)
            if not trial.state.is_finished():
                break
            self._open.popleft()
            self.search.told(number, order, point, self._gain(trial))

    def _gain(self, trial: FrozenTrial) -> NDArray[np.float64] | None:
        """Return a trial's values as shares of the hypervolume's box; None if it failed."""
        if trial.state != TrialState.COMPLETE:
            return None
        gains = [aim.gain(value) / aim.bound for aim, value in zip(self._aims, trial.values, strict=True)]
        return np.array([min(max(gain, -1.0), 2.0) for gain in gains])


class _Known:
    """Stands in for a trial whose parameters are known."""

    def __init__(self, params: dict[str, Any]) -> None:
        self._params = params

    def suggest_categorical(self, name: str, choices: object) -> object:
        return self._params[name]

    def suggest_float(self, name: str, low: float, high: float) -> object:
        return self._params[name]
