"""Has the sampler draw a few trials, so that its functions are compiled, or loaded from the cache."""

from __future__ import annotations

import optuna

from mobo_core.search.samplers.tpe.sampler import FastTPESampler


def run() -> None:
    """Run two tiny studies, one for each kind of bandwidth."""
    for multivariate in (True, False):
        sampler = FastTPESampler(n_startup_trials=2, gamma=lambda n: 1, multivariate=multivariate, seed=0)
        study = optuna.create_study(directions=["maximize", "minimize"], sampler=sampler)
        for number in range(4):
            trial = study.ask()
            trial.suggest_categorical("joint", ("R", "P", "Y"))
            # The second one's range changes, so that it is drawn by itself.
            lengths = trial.suggest_float("first", 0.0, 1.0), trial.suggest_float("second", 0.0, 1.0 + number)
            study.tell(trial, lengths)
