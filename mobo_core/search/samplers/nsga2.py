"""The sampler ``nsga2``."""

from __future__ import annotations

from optuna.samplers import NSGAIISampler

from mobo_core.search.samplers.sampler import ForTrial, Sampler, Task


def _factory(task: Task) -> ForTrial:
    return lambda trial: NSGAIISampler(seed=task.seed_of(trial))


# It leaves its generation's number on each trial it draws.
NSGA2 = Sampler("nsga2", "Optuna's NSGA-II at its defaults, 50 trials a generation", _factory, stateful=True)
