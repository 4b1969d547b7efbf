"""Samplers of other distributions, from the settings to a verified bag."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from distributions import install
from studies import mobo, run_study

from mobo_core.coordination.options import OptimizerOptions, StudyOptions
from mobo_core.coordination.parameters import parameters
from mobo_core.errors import InputError
from mobo_core.search import contract
from mobo_core.search.samplers.registry import SAMPLERS
from mobo_core.search.study import StudySettings

SOURCE = """
from optuna.samplers import RandomSampler
from mobo_core.search.samplers.sampler import Sampler


class Odd(RandomSampler):
    def __init__(self, seed, number):
        super().__init__(seed=seed)
        self._number = number

    def sample_independent(self, study, trial, name, distribution):
        if name == "J1":
            return distribution.choices[self._number % len(distribution.choices)]
        return super().sample_independent(study, trial, name, distribution)


ODD = Sampler(
    "odd", "random, but for the first joint, which takes turns",
    lambda task: lambda trial: Odd(task.seed_of(trial), trial),
    unfit=lambda space, objectives: "in a space of 12 joints: unlucky" if space.n_joints == 12 else "",
    defaults={"in_flight": 2, "lengths": "sequential"},
)
CALLS = []
FORGETFUL = Sampler("forgetful", "breaks the contract",
                    lambda task: lambda trial: (CALLS.append(trial), RandomSampler(seed=len(CALLS)))[1])
"""


@pytest.fixture(autouse=True)
def others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A distribution with a good sampler and one that breaks the contract."""
    folder = tmp_path / "others"
    folder.mkdir()
    install(folder, monkeypatch, SAMPLERS, "odd_sampler", SOURCE, odd="ODD", forgetful="FORGETFUL")


def test_a_sampler_of_another_distribution(tmp_path: Path) -> None:
    """A study with it keeps the contract, runs, is killed and resumed, and verified."""
    for settings in contract.cases("odd"):
        for check in contract.CHECKS:
            check(settings)
    quick = {"sampler": "odd", "in_flight": 3, "spec": {"poses_per_voxel": 1}}
    bag = run_study(tmp_path / "bag", 8, settings=quick, engine="kernel", kill_after=4)
    run_study(bag, 8, settings=quick, engine="kernel", resume=True)
    assert mobo("verify", bag, "--workers", 1) == 0


@pytest.mark.parametrize("check", [contract.check_timing, contract.check_resume])
def test_the_contract_finds_who_breaks_it(check: Callable[[StudySettings], None]) -> None:
    """A sampler whose trials hang on how often it was asked does not pass."""
    with pytest.raises(AssertionError):
        check(contract.cases("forgetful")[0])


def test_its_defaults_and_refusals() -> None:
    """What it brings holds where nothing is named; a space it cannot take is refused in a line."""
    settings = OptimizerOptions.of({"sampler": "odd"}).settings()
    assert (settings.in_flight, settings.space.lengths) == (2, "sequential")
    settings = OptimizerOptions.of({"sampler": "odd", "in_flight": 8, "lengths": "fractions"}).settings()
    assert (settings.in_flight, settings.space.lengths) == (8, "fractions")
    with pytest.raises(InputError, match="another than odd in a space of 12 joints: unlucky$"):
        OptimizerOptions.of({"sampler": "odd", "n_joints": 12}).settings()


@pytest.mark.parametrize("options", [OptimizerOptions, StudyOptions])
def test_it_is_in_the_help(options: type[OptimizerOptions]) -> None:
    """With what it brings."""
    texts = {parameter.name: parameter.description for parameter in parameters(options)}
    expected = " nsga2, structured, random, forgetful or odd (in_flight 2, lengths sequential); "
    assert expected in texts["sampler"]
