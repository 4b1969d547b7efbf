"""Known arms as the first trials of a study."""

from __future__ import annotations

from pathlib import Path

import pytest
from studies import run_study

from mobo_core.arms.baselines import checked_plan, first_arms, known_twins
from mobo_core.bag.collector import read_study
from mobo_core.coordination.options import OptimizerOptions
from mobo_core.design import DesignSpace
from mobo_core.errors import InputError


def test_twins_lie_in_the_space() -> None:
    """Each is a design of the space, named by its arm; a narrower space holds fewer."""
    space = DesignSpace()
    twins = known_twins(space)
    assert len(twins) > 20 and len({design for _, design in twins}) == len(twins)
    for name, design in twins:
        space.params(design)
        assert name.startswith("twin of ") and sum(design.lengths) == pytest.approx(0.6, abs=1e-9)
    assert any("UR5" in name for name, _ in twins)
    assert 0 < len(known_twins(DesignSpace(max_length=0.25))) < len(twins)
    assert not any("R" in design.joints for _, design in known_twins(DesignSpace(joint_types="YP")))
    assert {len(design.joints) for _, design in known_twins(DesignSpace(n_joints=7))} == {7}


def test_they_are_the_first_trials(tmp_path: Path) -> None:
    """In the bag as commands; killed and resumed it is the same study; no more than there are trials."""
    twins = known_twins(DesignSpace())[:5]
    whole = run_study(tmp_path / "whole", 12, first=twins)
    study = read_study(whole)
    assert [(c.command, c.trial, c.source) for c in study.commands] == [
        ("enqueue", i, name) for i, (name, _) in enumerate(twins)
    ]
    first = [study.candidate_of(trial) for trial in range(5)]
    assert [c.joints for c in first if c] == [design.joints for _, design in twins]
    for candidate, (_, design) in zip(first, twins, strict=True):
        assert candidate is not None and list(candidate.lengths) == pytest.approx(design.lengths, abs=1e-9)
    cut = run_study(tmp_path / "cut", 12, first=twins, kill_after=3)
    again = read_study(run_study(cut, 12, first=twins, resume=True))
    assert len(again.commands) == 5
    assert [(i, t.reach) for i, t in again.trials.items()] == [(i, t.reach) for i, t in study.trials.items()]
    few = read_study(run_study(tmp_path / "few", 3, first=twins))
    assert len(few.trials) == len(few.commands) == 3


def test_a_bag_that_began_otherwise_is_refused(tmp_path: Path) -> None:
    """Named baselines that differ from the bag's are; what is as it was, or not named, is not; nor arms of a user."""
    twins = known_twins(DesignSpace())[:2]
    began = run_study(tmp_path / "began", 6, first=twins, kill_after=3)
    plain = run_study(tmp_path / "plain", 6, first=[("me", twins[0][1])], kill_after=3)
    two = run_study(tmp_path / "two", 6, settings={"sampler": "random", "space": {"n_joints": 2}}, kill_after=3)

    def check(bag: Path, **given: str) -> None:
        assert checked_plan(OptimizerOptions.of({"bag": str(bag), "resume": True, **given})).folder == bag

    for bag, given in ((began, {}), (began, {"baselines": "known"}), (plain, {}), (plain, {"baselines": ""})):
        check(bag, **given)
    check(two, baselines="known")  # there are no such arms
    with pytest.raises(InputError, match="plain: baselines is '' in the bag; expected 'known', as asked for now"):
        check(plain, baselines="known")
    with pytest.raises(InputError, match="baselines is 'known' in the bag; expected ''"):
        check(began, baselines="")
    check(tmp_path / "new", baselines="known")


def test_what_an_optimizer_is_told_of_first() -> None:
    """The twins if it is told of them; where its space holds none it says so."""
    said: list[str] = []
    assert first_arms(OptimizerOptions(), DesignSpace(), said.append) == ()
    assert first_arms(OptimizerOptions(baselines="known"), DesignSpace(), said.append) == known_twins(DesignSpace())
    assert not said
    assert first_arms(OptimizerOptions(baselines="known"), DesignSpace(n_joints=2), said.append) == ()
    assert said == ["no known arm has a twin in the space: none is tried first"]
