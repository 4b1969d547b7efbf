"""COMO-CatCMA with margin for arms, as an Optuna sampler."""

from __future__ import annotations

import warnings
from collections import deque
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import optuna
from optuna import Study
from optuna.distributions import BaseDistribution, CategoricalDistribution, FloatDistribution
from optuna.samplers import BaseSampler, RandomSampler
from optuna.trial import FrozenTrial, TrialState

from mobo_core.design import DesignSpace
from mobo_core.search.front import Aims, aims_of
from mobo_core.search.samplers.sampler import ForTrial, Sampler, Task

if TYPE_CHECKING:
    from cmaes import COMOCatCMAwM


class ComoSampler(BaseSampler):
    """COMO-CatCMA with margin (arXiv 2504.07884) as the library ``cmaes`` has it, with its ten kernels.

    A kernel is a normal distribution over the fractions u1, u2, ... (and, scaled alike, whatever else the space
    searches in a range) times a categorical one for each joint that is searched; all together follow the Pareto
    front. They are updated one after the other: a kernel's solutions, about a dozen, are asked, and only when the
    last of them has its values are there solutions of the next. A trial that comes while there are none is random,
    and its values are not told to the kernels: with one trial in flight there is no such trial, with k in flight
    there are k - 1 to each dozen.

    * A solution needs values. One whose trial failed is told the reference point (no reach, and the torque that ends
      the hypervolume's box), which is no better than any arm on the front.
    * A trial whose parameters are not those drawn for it, since they came from outside, says nothing of the solution
      drawn, which is asked again once that trial is told.

    The kernels have one random stream, from ``seed``: a study that is resumed goes through it again from trial 0.
    Linear algebra is LAPACK's, whose last bits may differ between kinds of processor.

    One sampler serves one study, of (reach, torque in N m) with ``fractions`` for lengths.

    Args:
        space: of the arms; more than one.
        aims: of reach and torque: their bounds scale the values.
        seed: of the kernels and, until :meth:`reseed`, of random trials.
    """

    def __init__(self, space: DesignSpace, aims: Aims, seed: int) -> None:
        from cmaes import COMOCatCMAwM  # not at the top: who has another sampler need not wait for it

        found = _parameters(space)
        self._choices = {name: d.choices for name, d in found.items() if isinstance(d, CategoricalDistribution)}
        self._ranges = {name: (d.low, d.high) for name, d in found.items() if isinstance(d, FloatDistribution)}
        reach, torque = aims
        self._scale = np.array([-reach.bound, torque.bound])
        self._reference = (0.0, 1.0)
        types = [len(choices) for choices in self._choices.values()]
        self._optimizer = COMOCatCMAwM(
            x_space=[[0.0, 1.0]] * len(self._ranges) if self._ranges else None,
            c_space=types if max(types, default=1) > 1 else None,
            reference_point=self._reference,
            seed=seed,
        )
        # By trial number, until the trial is told: a solution and its parameters.
        self._drawn: dict[int, tuple[COMOCatCMAwM.Solution, dict[str, object]]] = {}
        self._again: deque[COMOCatCMAwM.Solution] = deque()
        self.reseed(seed)

    def reseed(self, seed: int) -> None:
        """Begin a new stream for random trials."""
        self._random = RandomSampler(seed=seed)

    def infer_relative_search_space(self, study: Study, trial: FrozenTrial) -> dict[str, BaseDistribution]:
        """Return nothing: all is drawn in :meth:`before_trial`."""
        return {}

    def sample_relative(
        self, study: Study, trial: FrozenTrial, search_space: dict[str, BaseDistribution]
    ) -> dict[str, object]:
        """Return nothing: all is drawn in :meth:`before_trial`."""
        return {}

    def before_trial(self, study: Study, trial: FrozenTrial) -> None:
        """Draw the trial's parameters, if there is a solution to ask."""
        if self._again:
            solution = self._again.popleft()
        elif self._optimizer.ask_queue_size:
            solution = self._optimizer.ask()
        else:
            return
        self._drawn[trial.number] = solution, self._params(solution)

    def sample_independent(
        self, study: Study, trial: FrozenTrial, param_name: str, param_distribution: BaseDistribution
    ) -> object:
        """Return the parameter of the solution drawn, or a random one."""
        if trial.number in self._drawn:
            return self._drawn[trial.number][1][param_name]
        return self._random.sample_independent(study, trial, param_name, param_distribution)

    def after_trial(self, study: Study, trial: FrozenTrial, state: TrialState, values: Sequence[float] | None) -> None:
        """Tell the kernels what became of the solution drawn for the trial."""
        if trial.number not in self._drawn:
            return
        solution, params = self._drawn.pop(trial.number)
        if trial.params != params:
            self._again.append(solution)
            return
        with warnings.catch_warnings(), np.errstate(invalid="ignore"):
            # The library takes a median of nothing while all of a kernel's solutions have failed.
            warnings.filterwarnings("ignore", "Mean of empty slice", RuntimeWarning)
            self._optimizer.tell((solution, self._reference if values is None else values / self._scale))

    def _params(self, solution: COMOCatCMAwM.Solution) -> dict[str, object]:
        """Return the solution as the sampler's parameters of :meth:`DesignSpace.suggest`."""
        params: dict[str, object]
        if solution.c is None:
            params = {name: choices[0] for name, choices in self._choices.items()}
        else:
            # A row for each has as many entries as the joint with the most choices.
            chosen = [int(np.argmax(row)) for row in solution.c]
            params = {name: of[i] for i, (name, of) in zip(chosen, self._choices.items(), strict=True)}
        # The mean of a kernel, which is asked too, may lie outside the bounds.
        fractions = [] if solution.x is None else np.clip(solution.x, 0.0, 1.0)
        for u, (name, (low, high)) in zip(fractions, self._ranges.items(), strict=True):
            params[name] = low + float(u) * (high - low)
        return params


def _parameters(space: DesignSpace) -> dict[str, BaseDistribution]:
    """Return the parameters of a space with fractions, which are the same for all trials."""
    trial = optuna.create_study(sampler=RandomSampler(seed=0)).ask()
    space.suggest(trial)
    return trial.distributions


def _unfit(space: DesignSpace, objectives: tuple[str, ...]) -> str:
    if space.lengths != "fractions":
        return f"with {space.lengths} lengths: it draws fractions alone"
    if all(distribution.single() for distribution in _parameters(space).values()):
        return "in a space of one arm"
    if objectives != ("reach", "torque"):
        return f"for {', '.join(objectives)}: it takes reach, torque alone"
    return ""


def _factory(task: Task) -> ForTrial:
    sampler = ComoSampler(task.space, aims_of(task.objectives, task.spec), task.seed_of(0))

    def for_trial(trial: int) -> BaseSampler:
        sampler.reseed(task.seed_of(trial))
        return sampler

    return for_trial


# Its kernels have one random stream, which a resumed study goes through again. Not offered any more: `structured` is
# ahead of it, takes any number in flight, and gives the same bits everywhere.
COMO = Sampler(
    "como",
    "COMO-CatCMA with margin (arXiv 2504.07884), for fractions and one trial in flight, or few",
    _factory,
    stateful=True,
    unfit=_unfit,
    defaults={"in_flight": 1},
    offered=False,
)
