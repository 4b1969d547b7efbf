"""The sampler ``random``."""

from __future__ import annotations

from optuna.samplers import RandomSampler

from mobo_core.search.samplers.sampler import ForTrial, Sampler, Task


def _factory(task: Task) -> ForTrial:
    return lambda trial: RandomSampler(seed=task.seed_of(trial))


RANDOM = Sampler("random", "uniform in each parameter", _factory)
