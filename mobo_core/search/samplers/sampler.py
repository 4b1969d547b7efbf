"""What a sampler is to mobo: a name, and a function that makes Optuna's sampler for each trial of a study.

Each trial gets a random stream of its own, seeded from (seed, trial number). So nothing of a random stream needs to
be stored, and trial n is drawn alike whether the study ran through or was resumed before it.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import optuna
from optuna.samplers import BaseSampler

from mobo_core.design import DesignSpace
from mobo_core.evaluation.spec import EvaluationSpec

optuna.logging.set_verbosity(optuna.logging.WARNING)

ForTrial = Callable[[int], BaseSampler]


def trial_seed(seed: int, trial: int) -> int:
    """Return the 32-bit seed of the random stream for one trial."""
    digest = hashlib.sha256(f"mobo sampler {seed} {trial}".encode()).digest()
    return int.from_bytes(digest[:4], "big")


@dataclass(frozen=True)
class Task:
    """What a sampler is made for: the same words as in :class:`~mobo_core.search.study.StudySettings`."""

    space: DesignSpace
    spec: EvaluationSpec
    objectives: tuple[str, ...]
    n_startup_trials: int
    seed: int
    sampler_rules: int = 1

    def seed_of(self, trial: int) -> int:
        """Return the 32-bit seed of the random stream for one trial."""
        return trial_seed(self.seed, trial)


def _fits(space: DesignSpace, objectives: tuple[str, ...]) -> str:
    return ""


@dataclass(frozen=True)
class Sampler:
    """A sampler by name.

    The parameters it draws are those of :meth:`DesignSpace.suggest`, the values it is told those of the study's
    objectives, in their order and directions. What it draws may depend on the task, the trial's number, and the
    trials of the Optuna study it is given, and on nothing else; :mod:`mobo_core.search.contract` tries that.

    Attributes:
        name: in settings.
        summary: a line for people, with the source.
        factory: makes for a task the function from a trial's number to the Optuna sampler that draws it, which may be
            a new one each time or the same.
        stateful: whether it keeps notes of its own, in itself or on the trials it draws: then each trial from a
            record passes through it too. Not needed if all it keeps can be told from the trials.
        unfit: says for a space and objectives why it cannot take them, ``""`` if it can; the words follow its name,
            as in ``mine with sequential lengths: it draws fractions alone``.
        defaults: of settings that are not named, where it has others than mobo: ``in_flight``, ``n_startup_trials``,
            or one of the space, such as ``lengths``.
        rules: the number of its latest algorithm; bags of earlier ones go on by theirs.
        offered: whether help names it. One that is not is for bags that name it: they verify and resume.
    """

    name: str
    summary: str
    factory: Callable[[Task], ForTrial]
    stateful: bool = False
    unfit: Callable[[DesignSpace, tuple[str, ...]], str] = _fits
    defaults: Mapping[str, int | float | str] = field(default_factory=dict)
    rules: int = 1
    offered: bool = True
