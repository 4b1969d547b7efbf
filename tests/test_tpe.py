"""The fast TPE sampler: Optuna's mathematics of versions 4.9 and 5.0, and what goes to the stock sampler."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import os
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import optuna
import optuna_golden as golden
import pytest
from hypothesis import given
from hypothesis import strategies as st
from optuna.distributions import BaseDistribution, CategoricalDistribution, FloatDistribution
from optuna.samplers._tpe import parzen_estimator
from optuna.samplers._tpe import sampler as stock_tpe
from optuna.trial import FrozenTrial, TrialState, create_trial

from mobo_core.design import DesignSpace
from mobo_core.search.samplers.parzen import paper_gamma, tenth
from mobo_core.search.samplers.sampler import trial_seed
from mobo_core.search.samplers.tpe import density
from mobo_core.search.samplers.tpe.estimator import Estimator, Space
from mobo_core.search.samplers.tpe.ranking import good_trials, hypervolume_weights, insert_sorted
from mobo_core.search.samplers.tpe.sampler import FastTPESampler, recent

DATA = Path(__file__).parent / "data"
# What each version of Optuna does by default.
RULES: dict[str, dict[str, Any]] = {
    "4.9.0": {"gamma": paper_gamma, "good_weights": "hypervolume", "bandwidth": "scott"},
    "5.0.0": {"gamma": tenth, "good_weights": "equal", "bandwidth": "neighbours"},
}


@pytest.mark.parametrize("version", RULES)
def test_draws_what_optuna_draws(version: str) -> None:
    """Trial by trial, with some in flight and some failed, the parameters are those of that version's sampler."""
    expected = json.loads((DATA / f"optuna_{version}.json").read_text())
    sampler = FastTPESampler(n_startup_trials=golden.STARTUP, **RULES[version])

    def sampler_of(number: int) -> FastTPESampler:
        sampler.reseed(number)
        return sampler

    _, drawn = golden.run_study(sampler_of)
    for found, should in zip(drawn, expected["drawn"], strict=True):
        assert [found[name] for name in ("J1", "J2", "J3")] == [should[name] for name in ("J1", "J2", "J3")]
        assert [found[name] for name in ("u1", "u2")] == pytest.approx(
            [should[name] for name in ("u1", "u2")], abs=1e-9
        )


@pytest.mark.parametrize("version", RULES)
def test_split_weights_and_densities_are_optunas(version: str) -> None:
    """On one history the good trials, their weights and both densities are those of that version."""
    expected = json.loads((DATA / f"optuna_{version}.json").read_text())
    study = optuna.create_study(directions=["maximize", "minimize"])
    for number, params in enumerate(expected["drawn"]):
        state, values = TrialState.COMPLETE, golden.values(number, params)
        if number >= golden.TRIALS - 3:
            state, values = TrialState.RUNNING, None
        elif number % 11 == 5:
            state, values = TrialState.FAIL, None
        study.add_trial(create_trial(state=state, values=values, params=params, distributions=golden.SPACE))
    sampler = FastTPESampler(n_startup_trials=golden.STARTUP, **RULES[version])
    sampler._history.update(study, -1)
    good, weight, _ = sampler._split()
    assert good.tolist() == expected["good"]
    np.testing.assert_allclose(weight[good], expected["weights"], rtol=0, atol=1e-9)
    assert sampler._history.space == golden.SPACE
    x, c = as_arrays(golden.SPACE, golden.points())
    for estimator, name in zip(sampler.estimators(golden.SPACE), ("log_good", "log_others"), strict=True):
        np.testing.assert_allclose(estimator.log_density(x, c), expected[name], rtol=0, atol=1e-9)


def as_arrays(space: dict[str, BaseDistribution], points: dict[str, Any]) -> tuple[Any, Any]:
    """Return points as an estimator takes them: (real values, choices)."""
    parts = Space(space)
    n = len(next(iter(points.values())))
    pick = [
        np.array([points[name] for name in names]).reshape(len(names), n) for names in (parts.real, parts.categorical)
    ]
    return pick[0], pick[1]


def version_of_installed() -> str:
    return next((version for version in RULES if optuna.__version__.startswith(version[:2])), "4.9.0")


def test_golden_figures_are_those_of_the_installed_optuna() -> None:
    """The kept figures of the installed version are what it gives today."""
    version = version_of_installed()
    study, drawn = golden.run_study(golden.stock)
    expected = json.loads((DATA / f"optuna_{version}.json").read_text())
    for found, should in zip(drawn, expected["drawn"], strict=True):
        assert found == pytest.approx(should, abs=1e-9)
    again = golden.densities(study, golden.stock(), golden.SPACE, golden.points())
    assert again["good"] == expected["good"]
    np.testing.assert_allclose(again["log_others"], expected["log_others"], rtol=0, atol=1e-9)


losses = st.lists(st.tuples(st.integers(-4, 4), st.integers(-4, 4)), min_size=1, max_size=40)
real_losses = st.lists(st.tuples(st.floats(-50, 50), st.floats(0, 500)), min_size=1, max_size=40)


@given(losses | real_losses, st.integers(0, 40))
def test_split_with_ties_is_optunas(points: list[tuple[float, float]], n_good: int) -> None:
    """Whatever the losses, equal ones among them, the good trials and their weights are Optuna's."""
    loss = np.array(points, float)
    order, n = np.empty(len(loss), np.int64), len(loss)
    for i in range(n):
        insert_sorted(order, i, loss, i)
    assert [tuple(loss[i]) for i in order] == sorted(tuple(row) for row in loss)
    study = optuna.create_study(directions=["minimize", "minimize"])
    trials = [create_trial(values=list(row)) for row in loss]
    for number, trial in enumerate(trials):
        trial.number = number
    stock_tpe._solve_hssp_with_cache.cache_clear()
    expected, _ = stock_tpe._split_complete_trials_multi_objective(trials, study, min(n_good, n))
    good = np.zeros(n, bool)
    good_trials(order, n, loss, min(n_good, n), good)
    assert sorted(np.flatnonzero(good).tolist()) == sorted(trial.number for trial in expected)
    if expected and optuna.__version__.startswith("4."):
        weight = np.zeros(n)
        hypervolume_weights(order, n, loss, good, weight)
        should = stock_tpe._calculate_weights_below_for_multi_objective(study, expected, None)
        # Optuna takes differences of whole hypervolumes: a contribution far below them drowns in rounding.
        np.testing.assert_allclose(weight[[trial.number for trial in expected]], should, rtol=0, atol=1e-7)


def optunas_estimator(
    space: dict[str, BaseDistribution], observed: dict[str, Any], weight: Any, *, neighbours: bool
) -> Any:
    parameters = stock_tpe._ParzenEstimatorParameters(
        prior_weight=1.0, consider_magic_clip=True, consider_endpoints=False, weights=recent,
        multivariate=not neighbours, **({"categorical_distance_func": {}} if version_of_installed() == "4.9.0" else {}),
    )  # fmt: skip
    return parzen_estimator._ParzenEstimator(observed, space, parameters, weight)


def own_estimator(
    space: dict[str, BaseDistribution], observed: dict[str, Any], weight: Any, bandwidth: Any
) -> Estimator:
    parts, n = Space(space), len(weight)
    columns = [
        np.array([observed[name] for name in names]).reshape(len(names), n)
        for names in (parts.categorical, parts.real)
    ]
    codes, mu = (np.hstack([rows, np.zeros((len(rows), 1))]) for rows in columns)
    mu = np.vstack([np.zeros((max(0, density.WIDTH - len(mu)), n + 1)), mu])
    return Estimator(parts, codes.astype(np.int16), mu, weight, bandwidth)


@pytest.mark.slow
@given(
    st.integers(0, 60), st.integers(0, 3), st.integers(0, 3), st.sampled_from(["scott", "neighbours"]),
    st.integers(0, 2**31), st.floats(0.0, 1.0),
)  # fmt: skip
def test_densities_are_optunas(n: int, cats: int, reals: int, bandwidth: Any, seed: int, outside: float) -> None:
    """Densities equal Optuna's to 1e-9, values outside the bounds of today and bounds far apart among them."""
    if not cats + reals or (bandwidth == "scott" and version_of_installed() != "4.9.0"):
        return
    rng = np.random.RandomState(seed)
    space: dict[str, BaseDistribution] = {
        f"c{i}": CategoricalDistribution(("R", "P", "Y")[: i + 1]) for i in range(cats)
    }
    for i in range(reals):
        low = rng.uniform(-5, 5)
        space[f"r{i}"] = FloatDistribution(low, low + 10.0 ** rng.uniform(-3, 2))
    observed, at = {}, {}
    for name, d in space.items():
        if isinstance(d, CategoricalDistribution):
            observed[name] = rng.randint(0, len(d.choices), n).astype(float)
            at[name] = rng.randint(0, len(d.choices), 9).astype(float)
        elif isinstance(d, FloatDistribution):
            wide = 1.0 + 3.0 * outside
            observed[name] = d.low + (d.high - d.low) * rng.uniform(1.0 - wide, wide, n)
            at[name] = rng.uniform(d.low, d.high, 9)
    weight = rng.uniform(1e-12, 2.0, n)
    ours = own_estimator(space, observed, weight, bandwidth)
    theirs = optunas_estimator(space, observed, weight.copy(), neighbours=bandwidth == "neighbours")
    x, c = as_arrays(space, at)
    np.testing.assert_allclose(ours.log_density(x, c), theirs.log_pdf(at), rtol=0, atol=1e-9)
    # And from the same random numbers the same points.
    drawn = theirs.sample(np.random.RandomState(seed), 24)
    x, c = ours.draw(np.random.RandomState(seed).random_sample((1 + len(space), 24)))
    parts = Space(space)
    for i, name in enumerate(parts.categorical):
        assert c[i].tolist() == drawn[name].tolist()
    for i, name in enumerate(parts.real):
        np.testing.assert_allclose(x[i], drawn[name], rtol=0, atol=1e-9 * (1 + parts.high[i] - parts.low[i]))


def score(params: dict[str, Any]) -> tuple[float, float]:
    a = sum(value for value in params.values() if isinstance(value, float))
    return math.sin(7 * a), abs(a - 0.3) + sum(value == "P" for value in params.values())


def drawn_by(sampler: Any, space: dict[str, BaseDistribution], directions: list[str], trials: int = 25) -> list[Any]:
    study = optuna.create_study(directions=directions, sampler=sampler)
    for number in range(trials):
        trial = study.ask()
        for name, distribution in space.items():
            trial._suggest(name, distribution)
        if number == 12 and len(directions) == 1:
            study.tell(trial, state=TrialState.PRUNED)
        else:
            study.tell(trial, score(trial.params)[: len(directions)])
    return [trial.params for trial in study.trials]


@pytest.mark.parametrize(
    ("space", "directions"),
    [
        ({"x": FloatDistribution(0, 1), "k": CategoricalDistribution(("R", "P"))}, ["maximize"]),
        ({"x": FloatDistribution(0, 1, step=0.25), "k": CategoricalDistribution(("R", "P"))}, ["maximize", "minimize"]),
        ({"x": FloatDistribution(1e-3, 1, log=True)}, ["minimize", "minimize"]),
        ({"i": optuna.distributions.IntDistribution(0, 9)}, ["minimize", "maximize"]),
    ],
)
def test_what_it_does_not_know_goes_to_the_stock_sampler(
    space: dict[str, BaseDistribution], directions: list[str]
) -> None:
    """Other numbers of objectives, pruned trials, steps, logarithms and integers give what Optuna's sampler gives."""
    given = {"n_startup_trials": 8, "gamma": paper_gamma, "multivariate": True, "constant_liar": False, "seed": 3}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        expected = drawn_by(stock_tpe.TPESampler(**given), space, directions)
        assert drawn_by(FastTPESampler(**given), space, directions) == expected  # type: ignore[arg-type]


@pytest.mark.skipif(version_of_installed() != "4.9.0", reason="Optuna 5 has other rules")
@pytest.mark.parametrize("multivariate", [True, False])
def test_in_any_study(multivariate: bool) -> None:
    """With conditional parameters, other names later, and parameters of one choice it draws what Optuna draws."""

    def run(sampler_of: Any) -> list[dict[str, Any]]:
        study = optuna.create_study(directions=["minimize", "maximize"])
        for number in range(60):
            study.sampler = sampler_of(number)
            trial = study.ask()
            kind = trial.suggest_categorical("kind", ("a", "b"))
            trial.suggest_float("x", 0.0, 1.0)
            trial.suggest_float("one", 2.0, 2.0)
            trial.suggest_float(f"only_{kind}", -1.0, 1.0 if number % 2 else 1.5)
            if number > 20:
                trial.suggest_float("late", 0.0, 3.0)
            study.tell(trial, score({k: round(v, 2) if k != "kind" else v for k, v in trial.params.items()}))
        return [trial.params for trial in study.trials]

    ours = FastTPESampler(n_startup_trials=10, gamma=paper_gamma, multivariate=multivariate, constant_liar=False)

    def own(number: int) -> FastTPESampler:
        ours.reseed(number)
        return ours

    def theirs(number: int) -> optuna.samplers.TPESampler:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return optuna.samplers.TPESampler(n_startup_trials=10, multivariate=multivariate, seed=number)

    for found, should in zip(run(own), run(theirs), strict=True):
        assert found["kind"] == should["kind"]
        assert found == pytest.approx(should, abs=1e-9)


@pytest.mark.skipif(version_of_installed() != "4.9.0", reason="Optuna 5 has other rules")
@pytest.mark.parametrize("directions", list(itertools.product(("maximize", "minimize"), repeat=2)))
def test_any_directions(directions: tuple[str, str]) -> None:
    """Whichever way is better in each objective, also where values are negative, it draws what Optuna draws."""
    space = {"x": FloatDistribution(-1, 1), "k": CategoricalDistribution(("R", "P"))}
    given = {"n_startup_trials": 8, "gamma": paper_gamma, "multivariate": True, "constant_liar": False, "seed": 3}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        expected = drawn_by(stock_tpe.TPESampler(**given), space, list(directions))
        found = drawn_by(FastTPESampler(**given), space, list(directions))  # type: ignore[arg-type]
    assert [params["k"] for params in found] == [params["k"] for params in expected]
    assert [params["x"] for params in found] == pytest.approx([params["x"] for params in expected], abs=1e-9)


def test_several_threads() -> None:
    """Trials asked and told by several threads at once are drawn without harm."""
    sampler = FastTPESampler(n_startup_trials=5, gamma=tenth, seed=1)
    study = optuna.create_study(directions=["maximize", "minimize"], sampler=sampler)

    def objective(trial: optuna.Trial) -> tuple[float, float]:
        trial.suggest_categorical("k", ("R", "P"))
        trial.suggest_float("x", 0.0, 1.0)
        return score(trial.params)

    study.optimize(objective, n_trials=60, n_jobs=4)
    assert len([trial for trial in study.trials if trial.state == TrialState.COMPLETE]) == 60


def test_history_looks_at_each_finished_trial_once() -> None:
    """An update costs as much as there are trials in flight: finished ones are not fetched again."""
    sampler = FastTPESampler(n_startup_trials=5, gamma=tenth)
    study = optuna.create_study(directions=["maximize", "minimize"], sampler=sampler)
    space = DesignSpace()
    for number in range(40):
        sampler.reseed(trial_seed(0, number))
        trial = study.ask()
        design = space.suggest(trial)
        study.tell(trial, (design.lengths[0], design.lengths[1]))
    fetched: list[int] = []
    storage = study._storage
    fetch = storage.get_trial

    def counted(trial_id: int) -> FrozenTrial:
        fetched.append(trial_id)
        return fetch(trial_id)

    storage.get_trial = counted  # type: ignore[method-assign]
    sampler._history.update(study, -1)
    sampler._history.update(study, -1)
    assert len(fetched) <= 1
    assert sampler._history.count == 40


def fingerprint() -> str:
    """Return a hash of all bits of two studies' parameters."""
    drawn = []
    for rules in RULES.values():
        sampler = FastTPESampler(n_startup_trials=golden.STARTUP, **rules)

        def sampler_of(number: int, sampler: FastTPESampler = sampler) -> FastTPESampler:
            sampler.reseed(number)
            return sampler

        drawn += golden.run_study(sampler_of)[1]
    return hashlib.sha256(repr(drawn).encode()).hexdigest()


@pytest.mark.slow
def test_bits_of_the_plainest_processor(tmp_path: Path) -> None:
    """What is drawn with functions compiled for the plainest of processors is, to the bit, what is drawn here."""
    plainest = {"NUMBA_CPU_NAME": "x86-64-v2", "NPY_DISABLE_CPU_FEATURES": "AVX512F", "MOBO_CACHE": str(tmp_path)}
    command = [sys.executable, "-c", "import test_tpe; print(test_tpe.fingerprint())"]
    run = subprocess.run(
        command, env={**os.environ, **plainest}, cwd=Path(__file__).parent, capture_output=True, text=True
    )
    assert run.returncode == 0, run.stderr
    assert run.stdout.strip() == fingerprint()
