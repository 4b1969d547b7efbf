"""The searches that compare_samplers.py compares, each a function of (seed, trials, value of an arm).

Outside ones are not mobo's dependencies: pip install pymoo torch
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import optuna
from optuna.samplers import BaseSampler

from mobo_core.design import Design, DesignSpace
from mobo_core.search.samplers.parzen import fast_tpe, paper_gamma, tenth
from mobo_core.search.samplers.sampler import trial_seed
from mobo_core.search.study import OrderedStudy, StudySettings, Told

SPACE = DesignSpace()
# Reach and torque (N m) of an arm.
Value = Callable[[Design], tuple[float, float]]
# Yields each trial's arm and values as it is told.
Trials = Iterator[tuple[Design, tuple[float, float]]]
Method = Callable[[int, int, Value], Trials]
# What the objectives are divided by where a method needs them of one scale: the box of the hypervolume.
_REACH, _TORQUE = 75.0, 750.0


def mobo(varied: dict[str, Any] | None = None, **settings: Any) -> Method:
    """Return a study of mobo's own, by its settings; ``varied`` are those of its TPE that differ from the default."""

    def run(seed: int, n_trials: int, value: Value) -> Trials:
        given = StudySettings.of({**settings, "seed": seed})
        study = _Varied(given, varied) if varied else OrderedStudy(given)
        while len(study.told) < n_trials:
            if len(study.asked) < n_trials and study.may_ask():
                study.ask()
            else:
                design = study.asked[len(study.told)].design
                values = value(design)
                study.tell(Told(len(study.told), values))
                yield design, values

    return run


class _Varied(OrderedStudy):
    """A study with ``tpe`` varied."""

    def __init__(self, settings: StudySettings, varied: dict[str, Any]) -> None:
        super().__init__(settings)
        sampler = fast_tpe()(**{"n_startup_trials": settings.n_startup_trials, "gamma": tenth} | varied)

        def for_trial(trial: int) -> BaseSampler:
            sampler.reseed(trial_seed(settings.seed, trial))
            return sampler

        self._sampler = for_trial


def root(n: int) -> int:
    """Return how many of ``n`` trials count as good: the square root."""
    return math.ceil(math.sqrt(n))


def plain(sampler: Callable[[int], BaseSampler], lengths: str = "fractions") -> Method:
    """Return a plain Optuna study, one trial at a time, by its sampler."""
    space = SPACE.model_copy(update={"lengths": lengths})

    def run(seed: int, n_trials: int, value: Value) -> Trials:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            study = optuna.create_study(directions=["maximize", "minimize"], sampler=sampler(seed))
            for _ in range(n_trials):
                trial = study.ask()
                design = space.suggest(trial)
                values = value(design)
                study.tell(trial, list(values))
                yield design, values

    return run


def _arm(x: Any, types: Any) -> Design:
    """Return the arm of five fractions and six numbers of joint types."""
    params = {f"J{i + 1}": "RPY"[int(t)] for i, t in enumerate(types)}
    return SPACE.design(params | {f"u{i + 1}": float(np.clip(v, 0, 1)) for i, v in enumerate(x)})


def _costs(values: tuple[float, float]) -> list[float]:
    return [-values[0] / _REACH, values[1] / _TORQUE]


def como_cat_cma(seed: int, n_trials: int, value: Value) -> Trials:
    """COMO-CatCMA with margin (cmaes): categorical and continuous, two objectives, ten kernels."""
    from cmaes import COMOCatCMAwM

    optimizer = COMOCatCMAwM(x_space=[[0, 1]] * 5, c_space=[3] * 6, reference_point=[0.0, 1.0], seed=seed)
    done = 0
    while done < n_trials:
        solutions = []
        for solution in optimizer.ask_iter():
            design = _arm(solution.x, np.argmax(solution.c, axis=1))
            values = value(design)
            solutions.append((solution, _costs(values)))
            done += 1
            if done <= n_trials:
                yield design, values
        optimizer.tell(solutions)


def pymoo(name: str) -> Method:
    """Return pymoo's NSGA-II or SMS-EMOA with its mating for mixed variables, 50 arms a generation."""

    def run(seed: int, n_trials: int, value: Value) -> Trials:
        from pymoo.algorithms.moo.nsga2 import NSGA2, RankAndCrowdingSurvival
        from pymoo.algorithms.moo.sms import SMSEMOA
        from pymoo.core.mixed import MixedVariableDuplicateElimination, MixedVariableMating, MixedVariableSampling
        from pymoo.core.problem import Problem
        from pymoo.core.variable import Choice, Real

        variables = {f"t{i}": Choice(options=[0, 1, 2]) for i in range(6)} | {
            f"u{i}": Real(bounds=(0, 1)) for i in range(5)
        }
        unique = MixedVariableDuplicateElimination()
        common: dict[str, Any] = {
            "pop_size": 50,
            "sampling": MixedVariableSampling(),
            "mating": MixedVariableMating(eliminate_duplicates=unique),
            "eliminate_duplicates": unique,
        }
        algorithm = NSGA2(survival=RankAndCrowdingSurvival(), **common) if name == "nsga2" else SMSEMOA(**common)
        problem = Problem(vars=variables, n_obj=2)
        algorithm.setup(problem, termination=("n_eval", n_trials + 50), seed=seed, verbose=False)
        done = 0
        while done < n_trials:
            generation = algorithm.ask()
            costs = []
            for x in generation.get("X"):
                design = _arm([x[f"u{i}"] for i in range(5)], [x[f"t{i}"] for i in range(6)])
                values = value(design)
                costs.append(_costs(values))
                done += 1
                if done <= n_trials:
                    yield design, values
            generation.set("F", np.array(costs))
            algorithm.tell(infills=generation)

    return run


def tpe(**settings: Any) -> Callable[[int], BaseSampler]:
    """Return how Optuna's own TPE is made; 100 start-up trials as in the paper."""
    return lambda seed: optuna.samplers.TPESampler(n_startup_trials=100, seed=seed, **settings)


METHODS: dict[str, Method] = {f"mobo tpe, in_flight {n}": mobo(in_flight=n) for n in (1, 2, 8, 32, 128)} | {
    "mobo structured, in_flight 8": mobo(sampler="structured"),
    "mobo structured, in_flight 128": mobo(sampler="structured", in_flight=128),
    "mobo tpe, sequential": mobo(space={"lengths": "sequential"}),
    "mobo paper": mobo(sampler="paper", in_flight=1, space={"lengths": "sequential"}),
    "mobo random": mobo(sampler="random"),
    "tpe, good: at most 25": mobo({"gamma": paper_gamma}),
    "tpe, good: square root": mobo({"gamma": root}),
    "tpe, good ones equal": mobo({"good_weights": "equal"}),
    "tpe, good ones equal, at most 25": mobo({"good_weights": "equal", "gamma": paper_gamma}),
    "tpe, good ones equal, square root": mobo({"good_weights": "equal", "gamma": root}),
    "tpe, 64 candidates": mobo({"n_ei_candidates": 64}),
    "tpe, 128 candidates": mobo({"n_ei_candidates": 128}),
    "tpe, no liar, in_flight 8": mobo({"constant_liar": False}, in_flight=8),
    "tpe, no liar, in_flight 128": mobo({"constant_liar": False}, in_flight=128),
    "tpe, bandwidths of Optuna 5": mobo({"bandwidth": "neighbours"}),
    "tpe, univariate": mobo({"multivariate": False}),
    "as Optuna's TPE multivariate": mobo({"gamma": paper_gamma, "constant_liar": False}, in_flight=1),
    "as Optuna's TPE univariate": mobo(
        {"gamma": paper_gamma, "constant_liar": False, "multivariate": False}, in_flight=1
    ),
    "Optuna TPE multivariate": plain(tpe(multivariate=True)),
    "Optuna TPE univariate": plain(tpe()),
    "Optuna NSGA-II": plain(lambda seed: optuna.samplers.NSGAIISampler(seed=seed)),
    "Optuna NSGA-III": plain(lambda seed: optuna.samplers.NSGAIIISampler(seed=seed)),
    "Optuna GP": plain(lambda seed: optuna.samplers.GPSampler(seed=seed)),
    "COMO-CatCMAwM": como_cat_cma,
    "pymoo NSGA-II": pymoo("nsga2"),
    "pymoo SMS-EMOA": pymoo("sms"),
}
