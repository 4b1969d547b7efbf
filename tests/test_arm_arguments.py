"""Arms go round: what tables, page and bags show of an arm, mobo evaluate and mobo export take."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from studies import mobo, mobo_json, run_study

from mobo_core.bag.collector import read_study
from mobo_core.design import Design
from mobo_core.report.lengths import lengths_text

SAMPLE = Path(__file__).parents[1] / "bags" / "sample" / "paper_6"
SHARES = st.lists(st.floats(0, 1), min_size=1, max_size=9).filter(lambda shares: sum(shares) > 0.01)


@given(SHARES, st.one_of(st.just(0.6), st.floats(0.1, 3.0)))
def test_lengths_as_text_still_add_up(shares: list[float], total: float) -> None:
    """Within what mobo evaluate asks, each within a unit of its last digit; four digits do for a length such as 0.6."""
    lengths = [share / math.fsum(shares) * total for share in shares]
    words = lengths_text(lengths).split(",")
    shown = [float(word) for word in words]
    Design("P" * len(shown), tuple(shown)).check_total(math.fsum(lengths))
    digits = {len(word.partition(".")[2]) for word in words}
    assert len(digits) == 1 and (total != 0.6 or digits == {4})
    for length, number in zip(lengths, shown, strict=True):
        assert number >= 0 and abs(number - length) <= 1.001 * 10.0 ** -min(digits)


@pytest.mark.parametrize("lengths", [(), (math.nan, 0.1), (math.inf,), (-0.1, 0.7), (1e300, 1e300)])
def test_lengths_that_a_bag_may_claim_have_some_text(lengths: tuple[float, ...]) -> None:
    """Nothing is raised, whatever they are."""
    assert lengths_text(lengths).count(",") == max(len(lengths) - 1, 0)


@pytest.mark.slow
def test_rows_of_terminal_and_page_can_be_evaluated(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Joints and lengths copied as they stand, from either."""
    assert mobo("report", SAMPLE, "-o", tmp_path) == 0
    page = re.sub("<[^>]*>", " ", (tmp_path / "index.html").read_text(encoding="utf-8").partition("<h2>Settings")[0])
    (row,) = re.findall(r"^ +(51 +[A-Z]{6} .*)$", capsys.readouterr().out.partition("each order")[0], re.MULTILINE)
    for text in (row, page):
        joints, lengths = next(iter(re.findall(r" 51 +([PRY]{6}) .*?((?:\d\.\d+,){5}\d\.\d+)", f" {text}")))
        arm = ["--joints", joints, "--lengths", lengths, "--spec", "paper"]
        found = mobo_json(capsys, "evaluate", "--json", *arm)
        # rounded by up to 0.1 mm: nearly the arm's reach
        assert found["reach"] == pytest.approx(28.33, abs=1.0)


def test_a_trial_is_evaluated_as_recorded(capsys: pytest.CaptureFixture[str]) -> None:
    """By the recorded URDF, tip and spec, to the bit, and says so."""
    told = read_study(SAMPLE).trials[46]
    found = mobo_json(capsys, "evaluate", SAMPLE, "--trial", 46, "--json")
    assert (found["reach"], found["torque"]) == (told.reach, told.torque)
    assert found["trial"] == 46 and found["recorded"] == {"reach": told.reach, "torque": told.torque, "same": True}
    assert mobo("evaluate", SAMPLE, "--trial", 46) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "bag     the same, to the bit"


def test_a_trial_by_another_spec_is_set_beside_the_recorded_values(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """Nothing is said to differ: the question does."""
    (tmp_path / "spec.yaml").write_text("poses_per_voxel: 3\n")
    asked = ("evaluate", SAMPLE, "--trial", 46, "--spec", tmp_path / "spec.yaml")
    assert mobo_json(capsys, *asked, "--json")["recorded"]["same"] is None
    assert mobo(*asked) == 0
    last = capsys.readouterr().out.splitlines()[-1]
    assert last == "bag     reach 19.30 of 75, torque 211.5 N m, recorded with another spec or tip"


def test_a_trial_that_differs_or_failed_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Values of the simulated engine are no evaluation's; of a failed trial there are none."""
    bag = run_study(tmp_path / "bag", 2, rejected={1})
    assert mobo("evaluate", bag, "--trial", 0) == mobo("evaluate", bag, "--trial", 1) == 0
    first, second = (line for line in capsys.readouterr().out.splitlines() if line.startswith("bag "))
    assert first.startswith("bag     DIFFERS: recorded reach ")
    assert second.startswith("bag     trial 1 failed (rejected: ") and second.endswith("nothing to compare with")


def test_the_urdf_of_a_trial_is_exported_byte_for_byte(tmp_path: Path) -> None:
    """Into the file that is named."""
    assert mobo("export", "urdf", SAMPLE, "--trial", 46, "-o", tmp_path / "arm.urdf") == 0
    candidate = read_study(SAMPLE).candidate_of(46)
    assert candidate is not None and (tmp_path / "arm.urdf").read_bytes() == candidate.urdf.encode()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["evaluate", "--trial", "3"], "--trial without a bag; expected BAG --trial N"),
        (["evaluate", SAMPLE], "a bag without --trial; expected BAG --trial N, or a URDF file"),
        (["evaluate", SAMPLE, "--trial", "60"], "no candidate of trial 60"),
        (["evaluate", SAMPLE, "--trial", "3", "--joints", "YPP"], "and --joints; expected one arm"),
        (["evaluate", "x.urdf", "--lengths", "0.6"], "both x.urdf and --lengths"),
        (["evaluate", SAMPLE, "--trial", "3", "--spec", "none"], "none"),
        (["export", "urdf", SAMPLE, "--trial", "60", "-o", "OUT"], "expected one of trials 0 to 59"),
        (["export", "urdf", SAMPLE, "--trial", "6", "--top", "2", "-o", "OUT"], "both --top and --trial"),
        (["export", "urdf", "--trial", "6", "-o", "OUT"], "--trial without a bag"),
    ],
)
def test_arguments_that_do_not_fit_are_refused(
    arguments: list[str], words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """In one line, nothing written."""
    assert mobo(*[tmp_path / "out" if argument == "OUT" else argument for argument in arguments]) == 2
    captured = capsys.readouterr()
    assert words in captured.err and captured.err.count("\n") == 1 and captured.out == ""
    assert not (tmp_path / "out").exists()
