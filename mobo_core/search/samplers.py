"""The samplers by name. Each trial gets a sampler of its own, seeded from (seed, trial number).

So nothing of a random stream needs to be stored, and trial n is drawn alike whether the study ran through
or was resumed before it.
"""

from __future__ import annotations

import hashlib
import math
import warnings
from collections.abc import Callable
from typing import Literal

import optuna
from optuna.samplers import BaseSampler, RandomSampler, TPESampler

from mobo_core.errors import InputError
from mobo_core.settings import choices

SamplerName = Literal["tpe", "paper", "random"]


def trial_seed(seed: int, trial: int) -> int:
    """Return the 32-bit seed of the random stream for one trial."""
    digest = hashlib.sha256(f"mobo sampler {seed} {trial}".encode()).digest()
    return int.from_bytes(digest[:4], "big")


def paper_gamma(n: int) -> int:
    """Return how many of ``n`` trials count as good: Optuna 4.9's default."""
    return min(math.ceil(0.1 * n), 25)


def tenth(n: int) -> int:
    """Return how many of ``n`` trials count as good for ``tpe``: a tenth.

    At most 25, as Optuna 4 has it, can make a study of some thousand trials settle on one structure early.
    """
    return math.ceil(0.1 * n)


def sampler_factory(name: str, seed: int, n_startup_trials: int) -> Callable[[int], BaseSampler]:
    """Return the function that makes the sampler for a trial's number.

    * ``tpe``: multivariate TPE, a tenth of the trials good; trials in flight count as bad ones (constant
      liar), which keeps many in flight apart.
    * ``paper``: multivariate TPE as in Optuna 4.9, without the constant liar; with one trial in flight and
      ``sequential`` lengths it is the paper's search.
    * ``random``: uniform.

    Raises:
        InputError: no such sampler, or ``paper`` under another Optuna than 4.
    """
    if name == "paper" and not optuna.__version__.startswith("4."):
        # Optuna 5 weighs the good trials of several objectives in another way.
        raise InputError(f"Optuna {optuna.__version__}", where="sampler paper", expected="Optuna 4.9")

    def make(trial: int) -> BaseSampler:
        own = trial_seed(seed, trial)
        if name == "random":
            return RandomSampler(seed=own)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
            warnings.simplefilter("ignore", FutureWarning)  # gamma goes away in Optuna 6
            if name == "tpe":
                return TPESampler(
                    n_startup_trials=n_startup_trials, multivariate=True, constant_liar=True, gamma=tenth, seed=own
                )
            return TPESampler(
                n_startup_trials=n_startup_trials, multivariate=True, gamma=paper_gamma, n_ei_candidates=24, seed=own
            )

    if name not in ("tpe", "paper", "random"):
        raise InputError(repr(name), where="sampler", expected=choices(SamplerName))
    return make
