"""``mobo bench``: which arms it draws, what it measures, and what it refuses."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from studies import mobo, mobo_json, run_study

from mobo_core.bag.collector import past_study, read_study
from mobo_core.bench import measure
from mobo_core.bench.groups import GROUPS, Arm, arms_of, arms_of_group, sample_of_study
from mobo_core.bench.random_arms import KINDS, draws
from mobo_core.commands.cli import main
from mobo_core.design import Design, DesignSpace
from mobo_core.evaluation import EvaluationSpec

ARM = "YPPYPY:0.05,0.25,0.2,0.05,0,0.05"
# Two voxels that ARM reaches.
FEW: dict[str, Any] = {
    "workspace_min": [0.1, 0.1, 0.1], "workspace_max": [0.3, 0.2, 0.2], "voxel_size": 0.1, "poses_per_voxel": 16,
}  # fmt: skip


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study of 12 trials in a space unlike the default, one of which failed."""
    space = {"n_joints": 4, "joint_limit": 1.0, "total_length": [0.4, 0.8], "base_height": [0.0, 0.3]}
    settings = {"sampler": "random", "space": space}
    return run_study(tmp_path_factory.mktemp("bags") / "b", 12, settings=settings, rejected=[5])


@pytest.fixture
def few(tmp_path: Path) -> Path:
    """The spec FEW in a file."""
    path = tmp_path / "few.yaml"
    path.write_text("\n".join(f"{name}: {value}" for name, value in FEW.items()), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--design", "YPPPPPPPPPPPP:" + ",".join(["0.05"] * 13)], "design YPPPPPPPPPPPP: n_joints = 13; expected"),
        (["--design", "YPR:0,0,0"], "design YPR: total_length = 0.0; expected"),
        (["--design", "YPR:0.1"], "1 lengths for 3 joints"),
        (["--design", "YPR"], "--design: 'YPR'; expected NAME:l1,l2"),
        (["--group", "nowhere"], "no group or file 'nowhere'; expected visited6"),
        (["--group", __file__], "not JSON"),
        (["--from", "nowhere"], "nowhere: no such bag"),
        (["--sample", "3"], "--sample: without a bag"),
        (["--spec", "nowhere"], "no preset or file 'nowhere'"),
        (["--attempts", "-1"], "--attempts: -1; expected 0 to"),
        (["--reference-poses", "31"], "--reference-poses: 31; expected 0 to the spec's 30"),
    ],
)
def test_bad_input(arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Bad input is told in one line, with exit code 2, before anything is measured."""
    assert main(["bench", "evaluate", "--design", "YPR:0.2,0.2,0.2", *arguments]) == 2
    out, err = capsys.readouterr()
    assert words in err and err.count("\n") == 1 and not out


def test_a_sample_larger_than_the_study(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """More arms than trials told with values are refused in one line; nothing is written."""
    assert mobo("bench", "evaluate", "--from", bag, "--sample", 12) == 2
    assert mobo("bench", "designs", bag, "--sample", 12, "-o", bag.parent / "out.json") == 2
    out, err = capsys.readouterr()
    assert err.count("12 designs; expected 1 to the 11 trials told") == 2 == err.count("\n") and not out
    assert not (bag.parent / "out.json").exists()


def test_a_sample_is_uniform_over_the_trials(bag: Path) -> None:
    """Over many seeds each trial told with values comes as often as any other; one seed always gives the same."""
    study = past_study(bag)
    counts = Counter(d.number for seed in range(500) for d in sample_of_study(study, 4, seed).parts[0].designs)
    assert set(counts) == set(range(12)) - {5}
    expected = 500 * 4 / 11
    assert sum((count - expected) ** 2 / expected for count in counts.values()) < 29.6  # 0.1 % of chi^2(10) are larger
    assert sample_of_study(study, 4, 7) == sample_of_study(study, 4, 7) != sample_of_study(study, 4, 8)


def test_arms_of_a_bag_are_those_it_sent_out(bag: Path, tmp_path: Path) -> None:
    """URDF for URDF, to the byte, by way of a file of designs too."""
    assert mobo("bench", "designs", bag, "--sample", 11, "-o", tmp_path / "b.json") == 0
    from_file, from_bag = arms_of_group(str(tmp_path / "b.json")), arms_of("b", sample_of_study(past_study(bag), 11, 0))
    study = read_study(bag)
    sent = [study.candidate_of(number) for number in range(12) if number != 5]
    assert [arm.urdf for arm in from_file] == [arm.urdf for arm in from_bag] == [c.urdf for c in sent if c]
    assert {arm.group for arm in from_file} == {"b"}


def test_groups_are_as_help_says() -> None:
    """Their sizes; the random ones are draws of the rule, by the numbers that the list gives."""
    assert {name: len(arms_of_group(name)) for name in GROUPS} == dict(zip(GROUPS, (32, 32, 40, 13), strict=True))
    assert [{len(arm.design.joints) for arm in arms_of_group(f"visited{n}")} for n in (6, 7)] == [{6}, {7}]
    random = arms_of_group("random")
    assert [len(arm.design.joints) for arm in random] == [n for n, _ in KINDS for _ in range(10)]
    for k, (n, limit) in enumerate(KINDS):
        space = DesignSpace(n_joints=n, joint_limit=limit)
        drawn = [design for design, _ in zip(draws(space, 0), range(60), strict=False)]
        places = [drawn.index(arm.design) for arm in random[10 * k : 10 * k + 10]]
        assert places == sorted(places) and all(arm.space == space for arm in random[10 * k : 10 * k + 10])


def test_random_arms_follow_their_rule() -> None:
    """A quarter of the links is zero, the lengths add up, and every order comes up."""
    space = DesignSpace(n_joints=3)
    arms = [design for design, _ in zip(draws(space, 0), range(1500), strict=False)]
    lengths = np.array([design.lengths for design in arms])
    assert np.allclose(lengths.sum(axis=1), 0.6) and lengths.min() == 0.0
    zero = (lengths == 0).mean()
    assert abs(zero - (0.25 - 0.25**3) / (1 - 0.25**3)) < 0.02  # all three are drawn again if all are zero
    orders = Counter(design.joints for design in arms)
    assert len(orders) == space.n_orders and max(orders.values()) < 1.6 * min(orders.values())


def test_figures(few: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A group's figures follow from its arms', each spec is compared with the first, and every arm is counted once."""
    arguments = ["--design", ARM, "--design", "RPYPRP:0,0,0.3,0.3,0,0", "--spec", str(few), "--ik", "paper", "--ik",
                 "complete", "--attempts", "30", "--reference-poses", "1", "--torque",
                 "--json"]  # fmt: skip
    paper = mobo_json(capsys, "bench", "evaluate", *arguments)
    (complete,) = paper["others"]
    assert paper["spec"].endswith(" paper") and complete["spec"].endswith(" complete")
    for bench in (paper, complete):
        rows, group = bench["designs"], bench["groups"]["given"]
        assert [row["name"] for row in rows] == ["YPPYPY", "RPYPRP"]
        for row in rows:
            assert row["recall"] == row["found"] / (row["found"] + row["missed"])
            assert row["found"] + row["missed"] >= 16 * row["reach_exhaustive"]  # the union holds both
            assert row["ms"] * 1e3 == pytest.approx(row["us_per_pose"] * 32) and row["ratio_reference"] > 1
        assert group["mean_ms"] == pytest.approx(np.mean([row["ms"] for row in rows]))
        assert group["found"] == sum(row["found"] for row in rows)
        assert group["recall"] == group["found"] / (group["found"] + group["missed"])
        assert group["mean_ratio"] == pytest.approx(np.mean([row["ratio_reference"] for row in rows]))
        assert group["speedup"] == pytest.approx(paper["groups"]["given"]["mean_ms"] / group["mean_ms"])
    assert paper["designs"][0]["missed"] >= complete["designs"][0]["missed"]


def test_what_is_left_out(few: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Without exhaustive search and reference engine the table holds neither, and with rows a line for the arm."""
    assert mobo("bench", "evaluate", "--design", ARM, "--spec", few, "--attempts", 0, "--reference-poses", 0,
                "--rows") == 0  # fmt: skip
    out = capsys.readouterr().out
    assert "ms a candidate, mean" in out and "given     YPPYPY" in out
    assert "recall over" not in out and "times the reference, mean" not in out and "torque to" not in out


def test_the_exhaustive_search_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Asked again it gives the same without searching; for other attempts it searches."""
    monkeypatch.setenv("MOBO_CACHE", str(tmp_path))
    urdf, spec = Arm.of("", Design("YPPYPY", (0.0, 0.3, 0.3, 0.0, 0.0, 0.0))).urdf, EvaluationSpec(**FEW)
    first = measure.ExhaustiveSearch(20).reached(urdf, spec)
    assert first.shape == (2, 16) and first.any()
    monkeypatch.setattr(measure, "measure", None)
    assert (measure.ExhaustiveSearch(20).reached(urdf, spec) == first).all()
    with pytest.raises(TypeError):
        measure.ExhaustiveSearch(21).reached(urdf, spec)


def test_the_ratio_of_torques_finds_a_bias_and_nothing_else() -> None:
    """It comes out with its error: a bias of 3 %, and the noise of starts, which the error is as large as."""
    rng = np.random.default_rng(0)
    true = rng.uniform(1, 20, (50, 30))
    times, off = np.full(true.shape, 8), []
    for _ in range(200):
        own = 1.03 * true * (1 + 0.2 * rng.standard_normal(true.shape))
        blind = true * (1 + 0.2 / 8**0.5 * rng.standard_normal(true.shape))
        reached = rng.random(true.shape) < 0.9
        ratio, error = measure.torque_ratio(measure.Measured(reached, own, 0, 0, 0.0), times, blind)
        off.append((ratio - 1.03) / error)
    assert abs(np.mean(off)) < 0.25 and 0.85 < np.std(off) < 1.15


def test_blind_restarts_have_the_same_targets_and_other_starts() -> None:
    """An arm that hardly has a choice takes the same torque for a pose, whichever the starts."""
    spec = EvaluationSpec(**FEW)
    chain = measure.chain_of(Arm.of("", Design("YPPYPY", (0.05, 0.25, 0.2, 0.05, 0.0, 0.05))).urdf, spec)
    own = measure.measure(chain, spec)
    times, blind = measure.blind_restarts(chain, spec)
    both = own.reached & (times > 0)
    assert both.sum() > 10 and np.median(np.abs(own.torque[both] / blind[both] - 1)) < 0.05
    assert set(times[both].astype(int).ravel()) != {8}
