"""What Optuna's own multivariate TPE makes of a made-up history of two objectives, as JSON.

    python tests/optuna_golden.py > tests/data/optuna_5.0.0.json

Needs Optuna alone, of any version from 4.9: so the figures of a version that mobo is not installed with can be kept.
"""

from __future__ import annotations

import json
import math
import warnings
from typing import Any

import numpy as np
import optuna
from optuna.distributions import BaseDistribution, CategoricalDistribution, FloatDistribution
from optuna.samplers import TPESampler
from optuna.samplers._tpe import sampler as tpe

SPACE: dict[str, BaseDistribution] = {
    "J1": CategoricalDistribution(("R", "P", "Y")),
    "J2": CategoricalDistribution(("R", "P", "Y")),
    "J3": CategoricalDistribution(("R", "P")),
    "u1": FloatDistribution(0.0, 1.0),
    "u2": FloatDistribution(-0.2, 0.3),
}
TRIALS, STARTUP, POINTS = 90, 30, 40


def values(number: int, params: dict[str, Any]) -> tuple[float, float]:
    """Return two objectives with ties: they are rounded, so that some trials are equal in one or both."""
    a = 3.0 * math.sin(5.0 * params["u1"]) + (params["J1"] == "P") + 2.0 * params["u2"]
    b = 4.0 * params["u1"] ** 2 + (params["J2"] != "R") + abs(params["u2"])
    return round(a, 1), round(b, 1)


def run_study(sampler_of: Any, in_flight: int = 3) -> tuple[optuna.Study, list[dict[str, Any]]]:
    """Run a study with some trials in flight and some failed; ``sampler_of(number)`` gives each trial's sampler."""
    study = optuna.create_study(directions=["maximize", "minimize"])
    trials: list[optuna.Trial] = []
    for number in range(TRIALS):
        if number >= in_flight:
            told = trials[number - in_flight]
            if told.number % 11 == 5:
                study.tell(told, state=optuna.trial.TrialState.FAIL)
            else:
                study.tell(told, values(told.number, told.params))
        study.sampler = sampler_of(number)
        trial = study.ask()
        for name, distribution in SPACE.items():
            trial._suggest(name, distribution)
        trials.append(trial)
    return study, [trial.params for trial in trials]


def points() -> dict[str, Any]:
    """Return points to take densities at, in Optuna's internal representation."""
    rng = np.random.RandomState(5)
    found: dict[str, Any] = {}
    for name, d in SPACE.items():
        if isinstance(d, CategoricalDistribution):
            found[name] = rng.randint(0, len(d.choices), POINTS).astype(float)
        elif isinstance(d, FloatDistribution):
            found[name] = rng.uniform(d.low, d.high, POINTS)
    return found


def densities(
    study: optuna.Study, sampler: TPESampler, space: dict[str, BaseDistribution], at: dict[str, Any]
) -> dict[str, Any]:
    """Return the good trials, their weights, and the log densities of good and other trials, as ``sampler`` has them.

    The trials in flight count as bad ones.
    """
    states = (optuna.trial.TrialState.COMPLETE, optuna.trial.TrialState.RUNNING)
    trials = [trial for trial in study.get_trials(deepcopy=False) if trial.state in states]
    n = sum(trial.state == optuna.trial.TrialState.COMPLETE for trial in trials)
    if sampler._gamma is None:
        sampler._gamma = lambda x: math.ceil(0.1 * x)  # what Optuna 5 sets on first use
    version_4 = optuna.__version__.startswith("4.")
    more = (False,) if version_4 else ()  # no constraints
    good, others = tpe._split_trials(study, trials, sampler._gamma(n), *more)
    weights = (
        tpe._calculate_weights_below_for_multi_objective(study, good, None) if version_4 else np.ones(len(good))
    )
    below = sampler._build_parzen_estimator(study, space, good, handle_below=True)
    above = sampler._build_parzen_estimator(study, space, others, handle_below=False)
    return {
        "good": [trial.number for trial in good],
        "weights": [float(w) for w in weights],
        "log_good": below.log_pdf(at).tolist(),
        "log_others": above.log_pdf(at).tolist(),
    }


def stock(seed: int | None = None) -> TPESampler:
    """Return Optuna's sampler at its own defaults, but for what mobo's shares with it."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return TPESampler(n_startup_trials=STARTUP, multivariate=True, constant_liar=True, seed=seed)


def main() -> None:
    """Print the figures."""
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    study, drawn = run_study(stock)
    found = {"optuna": optuna.__version__, "drawn": drawn, **densities(study, stock(), SPACE, points())}
    print(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
