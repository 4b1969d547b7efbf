"""The samplers by name, and those of other distributions by the entry points ``mobo.samplers``."""

from __future__ import annotations

from mobo_core.registry import Registry
from mobo_core.search.samplers.by_order import STRUCTURED
from mobo_core.search.samplers.como import COMO
from mobo_core.search.samplers.nsga2 import NSGA2
from mobo_core.search.samplers.parzen import PAPER, TPE, TPE_UNIVARIATE
from mobo_core.search.samplers.sampler import Sampler
from mobo_core.search.samplers.uniform import RANDOM

SAMPLERS = Registry("sampler", "mobo.samplers", Sampler, (TPE, TPE_UNIVARIATE, PAPER, NSGA2, COMO, STRUCTURED, RANDOM))
# What studies search with where no sampler is named. The field's own default stays as older bags mean it.
DEFAULT_SAMPLER = STRUCTURED.name


def sampler_names() -> str:
    """Return the names offered to people, each with what it sets unless told otherwise: ``paper (in_flight 1)``."""
    *others, last = (
        sampler.name + (f" ({', '.join(f'{k} {v}' for k, v in sampler.defaults.items())})" if sampler.defaults else "")
        for sampler in SAMPLERS.values()
        if sampler.offered
    )
    return f"{', '.join(others)} or {last}"
