"""The samplers by name. Each trial gets a random stream of its own, seeded from (seed, trial number).

So nothing of a random stream needs to be stored, and trial n is drawn alike whether the study ran through
or was resumed before it. (``como`` has one stream, which a resumed study goes through again.)
"""

from __future__ import annotations

import functools
import hashlib
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Literal, get_args

import optuna
from optuna.samplers import BaseSampler, NSGAIISampler, RandomSampler

from mobo_core.design import DesignSpace
from mobo_core.errors import InputError
from mobo_core.settings import choices

if TYPE_CHECKING:
    from mobo_core.search.samplers.como import ComoSampler
    from mobo_core.search.samplers.tpe.sampler import FastTPESampler

optuna.logging.set_verbosity(optuna.logging.WARNING)

SamplerName = Literal["tpe", "tpe_univariate", "paper", "nsga2", "como", "random"]
# Samplers that leave notes on the trials they draw, or keep their own: a trial from a record has to pass through
# them too.
LEAVE_NOTES = ("nsga2", "como")


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


@functools.cache
def fast_tpe() -> type[FastTPESampler]:
    """Return the class ``FastTPESampler`` with its functions compiled, once per machine."""

    def load() -> type[FastTPESampler]:
        # Not at the top: who only reads a sampler's name need not wait for compiled functions.
        from mobo_core.search.samplers.tpe import warm_up
        from mobo_core.search.samplers.tpe.sampler import FastTPESampler

        warm_up.run()
        return FastTPESampler

    from mobo_core.search.samplers.tpe import CACHE

    return CACHE.once("the sampler", "sampler", load)


def sampler_factory(
    name: str, seed: int, n_startup_trials: int, space: DesignSpace, n_voxels: int
) -> Callable[[int], BaseSampler]:
    """Return the function that makes the sampler for a trial's number, in a study of (reach, torque in N m).

    * ``tpe``: multivariate TPE, a tenth of the trials good; trials in flight count as bad ones (constant
      liar), which keeps many in flight apart.
    * ``tpe_univariate``: the same, each parameter by itself.
    * ``paper``: multivariate TPE as in Optuna 4.9, without the constant liar; with one trial in flight and
      ``sequential`` lengths it is the paper's search.
    * ``nsga2``: Optuna's NSGA-II at its defaults, 50 trials a generation.
    * ``como``: COMO-CatCMA with margin, for ``fractions`` and one trial in flight, or few.
    * ``random``: uniform.

    Raises:
        InputError: no such sampler.
    """
    if name == "random":
        return lambda trial: RandomSampler(seed=trial_seed(seed, trial))
    if name == "nsga2":
        return lambda trial: NSGAIISampler(seed=trial_seed(seed, trial))
    if name not in get_args(SamplerName):
        raise InputError(repr(name), where="sampler", expected=choices(SamplerName))
    # One sampler for all trials: what it keeps is a function of the trials alone.
    if name == "como":
        from mobo_core.search.samplers.como import ComoSampler  # not at the top: who has another needs no cmaes

        sampler: ComoSampler | FastTPESampler = ComoSampler(space, n_voxels, trial_seed(seed, 0))
    else:
        sampler = fast_tpe()(
            n_startup_trials=n_startup_trials,
            gamma=paper_gamma if name == "paper" else tenth,
            constant_liar=name != "paper",
            multivariate=name != "tpe_univariate",
        )

    def for_trial(trial: int) -> BaseSampler:
        sampler.reseed(trial_seed(seed, trial))
        return sampler

    return for_trial
