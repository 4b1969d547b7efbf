"""What every sampler has to keep, for the author of one to try it: trials that are a function of the settings.

In a test file of a distribution whose sampler is called ``mine``::

    @pytest.mark.parametrize("settings", contract.cases("mine"), ids=contract.label)
    @pytest.mark.parametrize("check", contract.CHECKS)
    def test_contract(check, settings):
        check(settings)
"""

from __future__ import annotations

import hashlib
import itertools
import json
import random
from collections.abc import Callable, Sequence

from optuna.distributions import CategoricalDistribution, FloatDistribution

from mobo_core.design import Design, DesignSpace
from mobo_core.search.samplers.registry import SAMPLERS
from mobo_core.search.study import Asked, OrderedStudy, StudySettings, Told

TRIALS = 30

Value = Callable[[int, Design], tuple[float, ...] | None]


def cases(sampler: str) -> list[StudySettings]:
    """Return settings to try a sampler with, as far as it takes them.

    Both ways of lengths with one, some and many trials in flight; and three objectives.

    Raises:
        InputError: no such sampler.
    """
    unfit, settings = SAMPLERS.of(sampler).unfit, []
    two, three = ("reach", "torque"), ("reach", "torque", "mass")
    ways = itertools.product(("fractions", "sequential"), (1, 3, 8), (two,))
    for lengths, in_flight, objectives in (*ways, ("fractions", 3, three)):
        space = DesignSpace.of({"n_joints": 4, "lengths": lengths, "max_length": 0.25})
        given = {"space": space, "objectives": objectives, "sampler": sampler}
        if not unfit(space, objectives):
            settings.append(StudySettings.of({**given, "in_flight": in_flight, "n_startup_trials": 8}))
    return settings


def label(settings: StudySettings) -> str:
    """Return what tells a case from the others."""
    return f"{settings.sampler}-{settings.space.lengths}-{settings.in_flight}-{len(settings.objectives)}"


def score(design: Design) -> tuple[float, float]:
    """Return values of a design, made up: long middle links reach far, rolls are light."""
    reach = 10 * design.lengths[1] + 5 * design.lengths[2] + design.joints.count("P")
    return reach, 3.0 - design.joints.count("R") + 4 * design.lengths[0]


def value_of(number: int, design: Design) -> tuple[float, ...] | None:
    """Return :func:`score` of a trial, or None for about one in six, which fails."""
    digest = hashlib.sha256(f"{number} {design}".encode()).digest()
    return None if digest[0] < 43 else score(design)


def run(
    settings: StudySettings, trials: int = TRIALS, eager: float = 0.5, seed: int = 0, value: Value = value_of
) -> list[Asked]:
    """Run a study in which the next step is to ask, if that may be, with probability ``eager``, else to tell."""
    return go_on(OrderedStudy(settings), trials, eager, seed, value)


def go_on(
    study: OrderedStudy, trials: int = TRIALS, eager: float = 0.5, seed: int = 0, value: Value = value_of
) -> list[Asked]:
    """Go on with a study up to ``trials``, as :func:`run` does."""
    chance = random.Random(seed)
    while len(study.asked) < trials:
        may_tell = len(study.told) < len(study.asked)
        if study.may_ask() and (not may_tell or chance.random() < eager):
            study.ask()
        else:
            tell_next(study, value)
    return list(study.asked)


def tell_next(study: OrderedStudy, value: Value = value_of) -> None:
    """Tell the next trial its value."""
    number = len(study.told)
    design = study.asked[number].design
    if (values := value(number, design)) is not None:
        values = (*values, design.lengths[-1])[: len(study.settings.objectives)]
    study.tell(Told(number, values))


def resumed(settings: StudySettings, asked: Sequence[Asked], told: int) -> OrderedStudy:
    """Rebuild a study from what a record of it holds: parameters as JSON, and values."""
    study = OrderedStudy(settings)
    for past in asked:
        while not study.may_ask():
            tell_next(study)
        assert study.recall(json.loads(json.dumps(past.params))) == past
    while len(study.told) < told:
        tell_next(study)
    return study


def check_timing(settings: StudySettings) -> None:
    """The designs are the same whether all answers come at once, one by one, as late as can be, or anyhow."""
    expected = run(settings, eager=1.0)  # tell only what must be told
    assert [asked.number for asked in expected] == list(range(TRIALS))
    assert run(settings, eager=0.0) == expected  # tell all that can be told
    assert run(settings, eager=0.6, seed=1) == expected
    assert len({asked.design for asked in expected}) > TRIALS / 2


def check_resume(settings: StudySettings) -> None:
    """Rebuilt from a record at any point, a study asks for the same designs as one that ran through."""
    expected = run(settings)
    chance = random.Random(2)
    for asked in sorted({0, 1, 8, TRIALS - 1, chance.randrange(2, TRIALS), chance.randrange(9, TRIALS)}):
        told = chance.randint(max(0, asked - settings.in_flight), asked)
        study = resumed(settings, expected[:asked], told)
        assert go_on(study, min(TRIALS, asked + 6)) == expected[: min(TRIALS, asked + 6)], (asked, told)


def check_parameters(settings: StudySettings) -> None:
    """All that is asked lies in the space, and the parameters alone give the design."""
    space = settings.space
    for asked in run(settings):
        assert space.design(asked.params) == asked.design
        assert space.params(asked.design).keys() == asked.params.keys()
        for name, distribution in space.distributions(asked.params).items():
            if isinstance(distribution, CategoricalDistribution):
                assert asked.params[name] in distribution.choices
            else:
                assert isinstance(distribution, FloatDistribution)
                assert distribution.low <= float(asked.params[name]) <= distribution.high


def check_seed(settings: StudySettings) -> None:
    """Another seed gives other trials."""
    other = StudySettings.of(settings.to_dict() | {"seed": settings.seed + 1})
    assert [asked.params for asked in run(other)] != [asked.params for asked in run(settings)]


CHECKS = (check_timing, check_resume, check_parameters, check_seed)
