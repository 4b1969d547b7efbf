"""The sampler ``structured``."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING

from optuna.samplers import BaseSampler

from mobo_core.design import DesignSpace
from mobo_core.search.samplers.sampler import ForTrial, Sampler, Task

if TYPE_CHECKING:
    from mobo_core.search.samplers.structured.sampler import StructuredSampler

MOST_ORDERS = 50_000


@functools.cache
def structured_sampler() -> type[StructuredSampler]:
    """Return the class ``StructuredSampler`` with its functions compiled, once per machine."""

    def load() -> type[StructuredSampler]:
        # Not at the top: who only reads a sampler's name need not wait for compiled functions.
        from mobo_core.search.samplers.structured import warm_up
        from mobo_core.search.samplers.structured.sampler import StructuredSampler

        warm_up.run()
        return StructuredSampler

    from mobo_core.search.samplers.structured import CACHE

    return CACHE.once("the sampler", "sampler", load)


def _factory(task: Task) -> ForTrial:
    # One sampler for all trials: what it keeps is a function of the trials alone.
    sampler = structured_sampler()(task)

    def for_trial(trial: int) -> BaseSampler:
        return sampler

    return for_trial


def _unfit(space: DesignSpace, objectives: tuple[str, ...]) -> str:
    if space.n_orders > MOST_ORDERS:
        return f"with {space.n_orders} joint orders: it keeps an archive of each, and takes {MOST_ORDERS} at most"
    return ""


STRUCTURED = Sampler(
    "structured",
    "every joint order searched by itself, half of the trials for the front of all orders, half so that all orders "
    "are known alike",
    _factory,
    unfit=_unfit,
    rules=2,
)
