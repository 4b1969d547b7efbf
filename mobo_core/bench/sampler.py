"""Speed of the sampler against Optuna's own, and how far their densities differ, on one history in one run."""

from __future__ import annotations

import statistics
import time
import tracemalloc
import warnings
from collections.abc import Callable
from typing import TypedDict

import numpy as np
import optuna
from numpy.typing import NDArray
from optuna.distributions import BaseDistribution
from optuna.samplers import TPESampler
from optuna.samplers._tpe import sampler as stock_tpe
from optuna.trial import FrozenTrial, TrialState, create_trial

from mobo_core.design import Design, DesignSpace
from mobo_core.search.samplers.parzen import fast_tpe, tenth
from mobo_core.search.samplers.sampler import trial_seed
from mobo_core.search.samplers.tpe.estimator import Space
from mobo_core.search.samplers.tpe.sampler import FastTPESampler

_MOBO_RUNS, _STOCK_RUNS = 25, 5
_POINTS = 64


Floats = NDArray[np.float64]


class Row(TypedDict):
    """Figures at one number of trials; see :func:`bench_sampler`."""

    n_trials: int
    ms_mobo: float
    ms_optuna: float
    ratio: float
    ms_draw: float
    bytes_per_trial: float


class SamplerBench(TypedDict):
    """Figures at all numbers of trials; see :func:`bench_sampler`."""

    joints: int
    mode: str
    optuna: str
    rows: list[Row]
    max_density_error: float


def bench_sampler(
    trials: list[int], space: DesignSpace, progress: Callable[[int, int], None] = lambda done, total: None
) -> SamplerBench:
    """Measure ask + tell of mobo's TPE and of Optuna's with equal settings, at each number of finished trials.

    The trials are random designs with made-up values. ``ms_mobo`` and ``ms_optuna`` are medians over some trials
    that both samplers add in turn to the same study. ``ms_draw`` is the part of an ask after the densities are
    fitted, for all parameters of fixed range; ``bytes_per_trial`` what the sampler itself keeps.
    ``max_density_error`` is the largest difference of log densities, good or other trials', and of acquisition
    values at 64 points, half of them random ones, half drawn.
    """
    version_4 = optuna.__version__.startswith("4.")
    rows: list[Row] = []
    error = 0.0
    study, rng = optuna.create_study(directions=["maximize", "minimize"]), np.random.RandomState(1)
    for count, n in enumerate(sorted(trials)):
        _fill(study, space, n)
        tracemalloc.start()
        tpe = fast_tpe()
        mobo = tpe(gamma=tenth) if version_4 else tpe(gamma=tenth, good_weights="equal", bandwidth="neighbours")
        _ask_and_tell(study, mobo, space, rng)
        kept = tracemalloc.get_traced_memory()[0]
        tracemalloc.stop()
        stock = _stock()
        _ask_and_tell(study, stock, space, rng)  # warm-up
        own, theirs = [], []
        for run in range(_MOBO_RUNS):
            mobo.reseed(trial_seed(0, run))
            own.append(_ask_and_tell(study, mobo, space, rng))
            if run % (_MOBO_RUNS // _STOCK_RUNS) == 0:
                theirs.append(_ask_and_tell(study, stock, space, rng))
        row_error, ms_draw = _density_error(study, mobo, stock)
        error = max(error, row_error)
        ms_mobo, ms_optuna = statistics.median(own), statistics.median(theirs)
        rows.append(
            {
                "n_trials": n,
                "ms_mobo": ms_mobo,
                "ms_optuna": ms_optuna,
                "ratio": ms_optuna / ms_mobo,
                "ms_draw": ms_draw,
                "bytes_per_trial": kept / n,
            }
        )
        progress(count + 1, len(trials))
    return {
        "joints": space.n_joints,
        "mode": space.lengths,
        "optuna": optuna.__version__,
        "rows": rows,
        "max_density_error": error,
    }


def _stock() -> TPESampler:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return TPESampler(n_startup_trials=100, multivariate=True, constant_liar=True, gamma=tenth, seed=0)


def _values(design: Design, rng: np.random.RandomState) -> tuple[float, float]:
    """Return values that hang on the design about as reach (of 75 voxels) and torque (N m) do."""
    long, last = design.lengths[1] + design.lengths[2], design.lengths[-1]
    reach = 75.0 * rng.random_sample() * long * (1.0 - last) * (1 + design.joints.count("R")) / (1 + len(design.joints))
    return reach, reach * (4.0 + 6.0 * rng.random_sample() + design.joints.count("P"))


def _fill(study: optuna.Study, space: DesignSpace, n: int) -> None:
    """Add random trials until the study has ``n``."""
    rng = np.random.RandomState(len(study.trials))
    for _ in range(n - len(study.trials)):
        letters = [space.joint_types[rng.randint(len(space.joint_types))] for _ in range(space.n_joints)]
        params: dict[str, str | float] = {f"J{i + 1}": letter for i, letter in enumerate(letters)}
        rest = space.total_ends[1]
        for i in range(space.n_joints - 1):
            share = rng.random_sample()
            longest = min(space.max_length, max(0.0, rest))
            params[f"u{i + 1}" if space.lengths == "fractions" else f"L{i + 1}"] = (
                share if space.lengths == "fractions" else share * longest
            )
            rest -= share * longest
        distributions = space.distributions(params)
        values = _values(space.design(params), rng)
        study.add_trial(create_trial(params=params, distributions=distributions, values=values))


def _ask_and_tell(
    study: optuna.Study, sampler: optuna.samplers.BaseSampler, space: DesignSpace, rng: np.random.RandomState
) -> float:
    """Return the milliseconds that one trial takes to be asked and told."""
    study.sampler = sampler
    began = time.perf_counter()
    trial = study.ask()
    design = space.suggest(trial)
    study.tell(trial, _values(design, rng))
    return 1e3 * (time.perf_counter() - began)


def _density_error(study: optuna.Study, mobo: FastTPESampler, stock: TPESampler) -> tuple[float, float]:
    """Return the largest difference of log densities, and the milliseconds of a draw after the fit."""
    mobo._history.update(study, -1)
    space: dict[str, BaseDistribution] = mobo._history.space
    parts = Space(space)
    good, others = mobo.estimators(space)
    rng = np.random.RandomState(0)
    times = []
    for _ in range(_MOBO_RUNS):
        u = rng.random_sample((1 + len(space), 24))
        began = time.perf_counter()
        x, c = good.draw(u)
        np.argmax(good.log_density(x, c) - others.log_density(x, c))
        times.append(1e3 * (time.perf_counter() - began))
    x, c = good.draw(rng.random_sample((1 + len(space), _POINTS)))
    half = _POINTS // 2
    x[:, :half] = rng.uniform(parts.low[:, None], parts.high[:, None], (len(parts.real), half))
    c[:, :half] = rng.randint(0, parts.choices[:, None], (len(parts.categorical), half))
    own = good.log_density(x, c), others.log_density(x, c)
    points = dict(zip((*parts.real, *parts.categorical), (*x, *c), strict=True))
    theirs = _stock_densities(study, stock, space, {name: points[name] for name in space})
    acquisition = np.abs((own[0] - own[1]) - (theirs[0] - theirs[1])).max()
    differences = (float(np.abs(a - b).max()) for a, b in zip(own, theirs, strict=True))
    return max(*differences, float(acquisition)), statistics.median(times)


def _stock_densities(
    study: optuna.Study, stock: TPESampler, space: dict[str, BaseDistribution], points: dict[str, Floats]
) -> tuple[Floats, Floats]:
    trials: list[FrozenTrial] = study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,))
    more = (False,) if optuna.__version__.startswith("4.") else ()  # no constraints
    good, others = stock_tpe._split_trials(study, trials, tenth(len(trials)), *more)
    return (
        stock._build_parzen_estimator(study, space, good, handle_below=True).log_pdf(points),
        stock._build_parzen_estimator(study, space, others, handle_below=False).log_pdf(points),
    )

