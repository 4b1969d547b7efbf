"""The ordered study: the same trials whatever the order of answers, and after any resume."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import warnings
from collections.abc import Callable
from typing import Any

import optuna
import pytest

from mobo_core.design import Design, DesignSpace
from mobo_core.errors import InputError
from mobo_core.evaluation import EvaluationSpec
from mobo_core.search import contract
from mobo_core.search.contract import TRIALS, go_on, resumed, run, score, tell_next, value_of
from mobo_core.search.samplers.parzen import paper_gamma, tenth
from mobo_core.search.samplers.registry import SAMPLERS
from mobo_core.search.samplers.sampler import trial_seed
from mobo_core.search.study import Asked, OrderedStudy, StudySettings, Told

BUILT_IN = [sampler.name for sampler in SAMPLERS.built_in]


def settings_of(sampler: str = "tpe", lengths: str = "fractions", in_flight: int = 3, **values: Any) -> StudySettings:
    space = {"n_joints": 4, "lengths": lengths, "max_length": 0.25}
    given = {"space": space, "sampler": sampler, "in_flight": in_flight, "n_startup_trials": 8, **values}
    return StudySettings.of(given)


@pytest.mark.parametrize("settings", [c for name in BUILT_IN for c in contract.cases(name)], ids=contract.label)
@pytest.mark.parametrize("check", contract.CHECKS)
def test_contract(check: Callable[[StudySettings], None], settings: StudySettings) -> None:
    """Every sampler keeps the contract, in every way of lengths and number in flight that it takes."""
    check(settings)


def test_the_contract_is_tried_on_all() -> None:
    """All samplers take all cases, but for como, which refuses sequential lengths."""
    counts = {name: len(contract.cases(name)) for name in BUILT_IN}
    assert counts == dict.fromkeys(BUILT_IN, 7) | {"como": 3}


def test_resumed_twice() -> None:
    """A study resumed from a resumed one's record goes on the same way, though it recalled some and asked others."""
    settings = settings_of("tpe", "fractions", 3)
    expected = run(settings)
    study = resumed(settings, expected[:12], 10)
    study = resumed(settings, go_on(study, 20), 18)
    assert go_on(study) == expected


@pytest.mark.parametrize("at", [49, 75, 120])
def test_generations_survive_resume(at: int) -> None:
    """NSGA-II keeps its generations of 50 trials on resume, with some in flight and some enqueued from outside."""
    settings = settings_of("nsga2", in_flight=3)
    given = {"J1": "Y", "J2": "P", "J3": "P", "J4": "R", "u1": 0.5, "u2": 0.25, "u3": 1.0}
    study = OrderedStudy(settings)
    while len(study.asked) < 130:
        if study.may_ask():
            study.recall(given) if len(study.asked) in (30, 80) else study.ask()
        else:
            tell_next(study)
    expected = list(study.asked)
    assert len({asked.design for asked in expected[60:]} - {asked.design for asked in run(settings_of("random"), 130)})
    again = resumed(settings, expected[:at], at - 2)
    while len(again.asked) < 130:
        if again.may_ask():
            again.recall(given) if len(again.asked) == 80 else again.ask()
        else:
            tell_next(again)
    assert again.asked == expected


def test_more_trials_extend_a_study() -> None:
    """The first trials of a longer study are those of a shorter one."""
    settings = settings_of()
    assert run(settings, 40)[:TRIALS] == run(settings, TRIALS)


def smooth(number: int, design: Design) -> tuple[float, float] | None:
    """Score a design as :func:`value_of`, with failures that hang on the number alone, not on a length's last bit."""
    return None if number % 7 == 3 else score(design)


def plain_optuna(settings: StudySettings, sampler: Callable[[int], optuna.samplers.BaseSampler]) -> list[Design]:
    """Run a study in Optuna's own words: one sampler a trial, each told in_flight trials later."""
    study = optuna.create_study(directions=["maximize", "minimize"])
    trials: list[optuna.Trial] = []
    designs: list[Design] = []
    for n in range(TRIALS):
        if n >= settings.in_flight:
            past = n - settings.in_flight
            values = smooth(past, designs[past])
            if values is None:
                study.tell(trials[past], state=optuna.trial.TrialState.FAIL)
            else:
                study.tell(trials[past], values)
        study.sampler = sampler(n)
        trials.append(study.ask())
        designs.append(settings.space.suggest(trials[-1]))
    return designs


def same(designs: list[Design], others: list[Design]) -> bool:
    """Return whether designs are equal but for rounding: the samplers' arithmetic is mobo's own."""
    return [d.sampled_joints for d in designs] == [d.sampled_joints for d in others] and all(
        abs(length - other) < 1e-12
        for d, o in zip(designs, others, strict=True)
        for length, other in zip(d.lengths, o.lengths, strict=True)
    )


@pytest.mark.skipif(not optuna.__version__.startswith("4."), reason="Optuna 5 has other rules")
@pytest.mark.parametrize("lengths", ["fractions", "sequential"])
@pytest.mark.parametrize("in_flight", [1, 3])
def test_paper_sampler_is_optunas_multivariate_tpe(lengths: str, in_flight: int) -> None:
    """With one trial in flight ``paper`` is a plain loop of Optuna's multivariate TPE; with more, a lagging one."""
    settings = settings_of("paper", lengths, in_flight, seed=5)

    def tpe(n: int) -> optuna.samplers.BaseSampler:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return optuna.samplers.TPESampler(n_startup_trials=8, multivariate=True, seed=trial_seed(5, n))

    assert same([asked.design for asked in run(settings, value=smooth)], plain_optuna(settings, tpe))


@pytest.mark.skipif(not optuna.__version__.startswith("4."), reason="Optuna 5 has other rules")
def test_tpe_sampler_counts_pending_trials_as_bad() -> None:
    """``tpe`` is a lagging loop of Optuna's multivariate TPE with the constant liar, and so not ``paper``."""
    settings = settings_of("tpe", seed=5)

    def tpe(n: int) -> optuna.samplers.BaseSampler:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            seed = trial_seed(5, n)
            return optuna.samplers.TPESampler(n_startup_trials=8, multivariate=True, constant_liar=True, seed=seed)

    designs = [asked.design for asked in run(settings, value=smooth)]
    assert same(designs, plain_optuna(settings, tpe))
    paper = [asked.design for asked in run(settings_of("paper", seed=5), value=smooth)]
    assert designs[:8] == paper[:8]
    assert designs != paper


def test_random_sampler_is_optunas() -> None:
    """``random`` draws each trial from Optuna's random sampler, whatever the values."""
    settings = settings_of("random", seed=5)
    designs = [asked.design for asked in run(settings)]
    assert designs == plain_optuna(settings, lambda n: optuna.samplers.RandomSampler(seed=trial_seed(5, n)))
    assert [asked.design for asked in run(settings, value=lambda *_: (0.0, 0.0))] == designs


@pytest.mark.parametrize("in_flight", [1, 3, 8])
def test_a_trial_sees_no_more_than_it_may(in_flight: int) -> None:
    """A changed value of trial k changes no trial before k + in_flight, and some later one."""
    settings = settings_of("tpe", in_flight=in_flight)
    expected = run(settings, eager=0.0)
    k = 12

    def other(number: int, design: Design) -> tuple[float, float] | None:
        return (100.0, -100.0) if number == k else value_of(number, design)

    changed = run(settings, eager=0.0, value=other)
    assert changed[: k + in_flight] == expected[: k + in_flight]
    assert changed[k + in_flight :] != expected[k + in_flight :]


@pytest.mark.parametrize("change", [{"seed": 1}, {"in_flight": 4}, {"n_startup_trials": 12}, {"sampler": "paper"}])
def test_what_trials_depend_on(change: dict[str, Any]) -> None:
    """Another seed, number in flight, start-up or sampler gives other trials; the spec says nothing of designs."""
    settings = settings_of()
    expected = [asked.params for asked in run(settings)]
    other = StudySettings.of(settings.to_dict() | change)
    assert [asked.params for asked in run(other)] != expected
    same = StudySettings.of(settings.to_dict() | {"spec": {"seed": 9}})
    assert [asked.params for asked in run(same)] == expected


def test_parameters_name_the_design() -> None:
    """What is asked for holds the sampler's parameters, from which the space rebuilds the design."""
    settings = settings_of(lengths="sequential")
    for asked in run(settings, 12):
        assert settings.space.design(asked.params) == asked.design
        assert list(asked.params) == ["J1", "J2", "J3", "J4", "L1", "L2", "L3"]


def test_asking_out_of_turn() -> None:
    """No trial may be asked before the one in_flight ahead of it is told."""
    study = OrderedStudy(settings_of("random", in_flight=2))
    assert study.may_ask()
    first = study.ask()
    study.ask()
    assert not study.may_ask()
    with pytest.raises(ValueError, match="trial 2 asked before trial 0 is told"):
        study.ask()
    with pytest.raises(ValueError, match="trial 2 asked before trial 0 is told"):
        study.recall(first.params)
    assert len(study.asked) == 2
    tell_next(study)
    assert study.may_ask()
    assert study.ask().number == 2


def test_telling_out_of_turn() -> None:
    """Trials are told in order, each once, and none before it is asked."""
    study = OrderedStudy(settings_of("random", in_flight=3))
    with pytest.raises(ValueError, match="trial 0 told"):
        study.tell(Told(0, (1.0, 1.0)))
    study.ask()
    study.ask()
    with pytest.raises(ValueError, match="trial 1 told, but it is the turn of trial 0"):
        study.tell(Told(1, (1.0, 1.0)))
    study.tell(Told(0, None))
    with pytest.raises(ValueError, match="trial 0 told, but it is the turn of trial 1"):
        study.tell(Told(0, (1.0, 1.0)))
    assert study.told == [Told(0, None)]


def test_all_trials_fail() -> None:
    """A study of nothing but failures goes on, drawing as it does before any value is known."""
    settings = settings_of("tpe")
    designs = run(settings, value=lambda *_: None)
    assert len(designs) == TRIALS
    assert go_on(resumed_failing(settings, designs[:20]), value=lambda *_: None) == designs


def resumed_failing(settings: StudySettings, asked: list[Asked]) -> OrderedStudy:
    study = OrderedStudy(settings)
    for past in asked:
        while not study.may_ask():
            study.tell(Told(len(study.told), None))
        study.recall(past.params)
    return study


def test_first_difference() -> None:
    """The first setting that differs is named, with both values; equal settings have none."""
    settings = settings_of()
    assert settings.first_difference(settings_of()) is None
    assert settings.first_difference(StudySettings.of(json.loads(settings.to_json()))) is None
    for change, expected in (
        ({"seed": 1}, ("seed", 0, 1)),
        ({"in_flight": 1}, ("in_flight", 3, 1)),
        ({"sampler": "paper", "seed": 1}, ("sampler", "tpe", "paper")),
        ({"space": {"n_joints": 4, "max_length": 0.2}}, ("space.max_length", 0.25, 0.2)),
        ({"spec": {"voxel_size": 0.1}}, ("spec.voxel_size", 0.2, 0.1)),
        ({"spec": {"gravity": (0, 0, -1)}}, ("spec.gravity", [0.0, 0.0, -9.81], [0.0, 0.0, -1.0])),
    ):
        assert settings.first_difference(StudySettings.of(settings.to_dict() | change)) == expected


def test_settings_survive_json() -> None:
    """Settings come back equal from their canonical text, floats to the bit."""
    space = DesignSpace(total_length=0.1 + 0.2, joint_limit=4.71238898038469)
    settings = StudySettings(space=space, spec=EvaluationSpec(seed=2**63 - 1), seed=2**62 + 1)
    assert StudySettings.of(json.loads(settings.to_json())) == settings


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"sampler": "magic"}, ("sampler = 'magic'", "'tpe'", "'paper'", "'random'")),
        ({"in_flight": 0}, ("in_flight = 0", "1")),
        ({"n_startup_trials": 0}, ("n_startup_trials = 0",)),
        ({"seed": -1}, ("seed = -1",)),
        ({"space": {"n_joints": 0}}, ("space.n_joints = 0",)),
        ({"spec": {"voxel_size": 0}}, ("spec.voxel_size = 0",)),
        ({"trials": 100}, ("unknown field 'trials'",)),
        ({"space": {"arms": 6}}, ("unknown field 'space.arms'",)),
    ],
)
def test_bad_settings(values: dict[str, Any], words: tuple[str, ...]) -> None:
    """Settings that make no sense are refused in one line with the field, however deep, and its value."""
    with pytest.raises(InputError) as error:
        StudySettings.of(values)
    assert "\n" not in str(error.value)
    for word in words:
        assert word in str(error.value)


def test_trial_seeds() -> None:
    """A trial's seed is the head of a SHA-256 of study seed and number: known, and never twice alike in a study."""
    assert trial_seed(0, 0) == int(hashlib.sha256(b"mobo sampler 0 0").hexdigest()[:8], 16)
    seeds = {trial_seed(seed, trial) for seed in range(3) for trial in range(1000)}
    assert len(seeds) == 3000
    assert trial_seed(1, 11) != trial_seed(11, 1)
    assert all(0 <= seed < 2**32 for seed in seeds)


def test_how_many_trials_are_good() -> None:
    """A tenth of the trials, rounded up, count as good: for the paper's sampler at most 25 of them."""
    counts = (0, 1, 10, 11, 100, 249, 250, 251, 10_000)
    assert [paper_gamma(n) for n in counts] == [0, 1, 1, 2, 10, 25, 25, 25, 25]
    assert [tenth(n) for n in counts] == [0, 1, 1, 2, 10, 25, 25, 26, 1000]


def test_unknown_sampler() -> None:
    """A sampler that does not exist is refused with the names of those that do."""
    names = "tpe, tpe_univariate, paper, nsga2, como, structured or random"
    with pytest.raises(InputError, match=f"sampler: 'magic'; expected {names}"):
        SAMPLERS.of("magic")


def test_asked_and_told_are_values() -> None:
    """What was asked and told cannot be changed afterwards."""
    with pytest.raises(dataclasses.FrozenInstanceError):
        Told(0, None).number = 1  # type: ignore[misc]
