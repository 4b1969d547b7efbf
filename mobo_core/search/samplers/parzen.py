"""The samplers ``tpe``, ``tpe_univariate`` and ``paper``: tree-structured Parzen estimators.

Two objectives of any directions are modelled by mobo's own FastTPESampler. Three go to Optuna's TPESampler with
the same settings, which is slower, and whose last bits may differ between kinds of processor.
"""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING

from optuna.samplers import BaseSampler

from mobo_core.search.samplers.sampler import ForTrial, Sampler, Task

if TYPE_CHECKING:
    from mobo_core.search.samplers.tpe.sampler import FastTPESampler


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


def _factory(task: Task, *, paper: bool = False, multivariate: bool = True) -> ForTrial:
    # One sampler for all trials: what it keeps is a function of the trials alone.
    sampler = fast_tpe()(
        n_startup_trials=task.n_startup_trials,
        gamma=paper_gamma if paper else tenth,
        constant_liar=not paper,
        multivariate=multivariate,
    )

    def for_trial(trial: int) -> BaseSampler:
        sampler.reseed(task.seed_of(trial))
        return sampler

    return for_trial


TPE = Sampler(
    "tpe",
    "multivariate TPE, a tenth of the trials good; trials in flight count as bad ones (constant liar), which keeps "
    "many in flight apart",
    _factory,
)
TPE_UNIVARIATE = Sampler(
    "tpe_univariate", "as tpe, each parameter by itself", functools.partial(_factory, multivariate=False)
)
PAPER = Sampler(
    "paper",
    "multivariate TPE as in Optuna 4.9, without the constant liar: with one trial in flight and sequential lengths it "
    "is the search of Kawaharazuka et al., Advanced Robotics 2025",
    functools.partial(_factory, paper=True),
    defaults={"in_flight": 1, "lengths": "sequential"},
)
