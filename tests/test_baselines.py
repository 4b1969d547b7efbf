"""Known arms, and those of a table, as the first trials of a study."""

from __future__ import annotations

from pathlib import Path

import pytest
from studies import mobo, run_study

from mobo_core.arms.baselines import checked_plan, first_arms
from mobo_core.arms.table import table_arms
from mobo_core.arms.twins import known_twins
from mobo_core.bag.collector import read_study
from mobo_core.coordination.options import OptimizerOptions
from mobo_core.design import DesignSpace
from mobo_core.errors import InputError
from mobo_core.report.table import study_table

LENGTHS = "length_1,length_2,length_3,length_4,length_5,length_6"


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
    table = run_study(tmp_path / "table", 6, first=[("arms.csv, row 1", twins[0][1])], kill_after=3)
    check(table, baselines="elsewhere/arms.csv")
    with pytest.raises(InputError, match=r"baselines is 'arms.csv' in the bag; expected 'known'"):
        check(table, baselines="known")
    with pytest.raises(InputError, match="plain: baselines is '' in the bag; expected 'known', as asked for now"):
        check(plain, baselines="known")
    with pytest.raises(InputError, match="baselines is 'known' in the bag; expected ''"):
        check(began, baselines="")
    check(tmp_path / "new", baselines="known")


def test_what_an_optimizer_is_told_of_first() -> None:
    """The twins if it is told of them; where its space holds none it says so."""
    said: list[str] = []
    assert first_arms("", DesignSpace(), said.append) == ()
    assert first_arms("known", DesignSpace(), said.append) == known_twins(DesignSpace())
    assert not said
    assert first_arms("known", DesignSpace(n_joints=2), said.append) == ()
    assert said == ["no known arm has a twin in the space: none is tried first"]


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_arms_of_an_earlier_study_are_the_first_trials(tmp_path: Path, suffix: str) -> None:
    """Its front and the best arm of each order, in order, worth what they were worth there."""
    if suffix == ".parquet":
        pytest.importorskip("pyarrow")
    earlier, file = run_study(tmp_path / "earlier", 20), tmp_path / f"best{suffix}"
    assert mobo("export", "table", earlier, "--best", "-o", file) == 0
    arms = table_arms(file, DesignSpace())
    table = study_table(read_study(earlier))
    best = {
        order: max(r.reach for r in table.complete if r.joints == order) for order in {r.joints for r in table.rows}
    }
    again = read_study(run_study(tmp_path / "again", len(arms) + 2, first=arms))
    assert [c.source for c in again.commands] == [f"best{suffix}, row {i + 1}" for i in range(len(arms))]
    reached = [again.trials[i].reach for i in range(len(arms))]
    assert reached == sorted(reached, reverse=True)
    rows = study_table(again).rows[: len(arms)]
    assert {row.joints: row.reach for row in reversed(rows)} == pytest.approx(best, abs=0.1)
    assert {(row.joints, row.reach) for row in table.useful_front} <= {(row.joints, row.reach) for row in rows}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("joints,length_1\nPRRYPY,0.6\n", "no column length_6; expected joints and length_1 to length_6"),
        (f"order,{LENGTHS}\nPRRYPY,0.1,0.1,0.1,0.1,0.1,0.1\n", "no column joints"),
        (f"joints,{LENGTHS}\nPRRYPY,0.1,0.1,0.1,0.1,0.1\n", "row 1: lengths"),
        (f"joints,{LENGTHS}\nPRRYPY,0.1,0.1,0.1,0.1,0.1,nan\n", "row 1: "),
        (f"joints,{LENGTHS}\nPRRYPY,0.1,0.1,0.1,0.1,0.1,0.1\nPRXYPY,0.1,0.1,0.1,0.1,0.1,0.1\n", "row 2: "),
        (f"joints,{LENGTHS}\nPRRYPY,0.1,0.1,0.1,0.1,0.1,0.2\n", "row 1: "),
        ("\0\n", "no column joints"),
        ("\xff", "expected a CSV or Parquet file"),
    ],
)
def test_a_table_that_holds_no_arms_is_refused(tmp_path: Path, text: str, said: str) -> None:
    """In a line that says where."""
    file = tmp_path / "arms.csv"
    file.write_bytes(text.encode("latin-1"))
    with pytest.raises(InputError) as error:
        first_arms(str(file), DesignSpace())
    assert str(error.value).startswith(str(file)) and said in str(error.value)


def test_no_table_is_refused(tmp_path: Path) -> None:
    """A folder, a file that is not there, no Parquet."""
    (tmp_path / "no.parquet").write_bytes(b"PAR1nothing")
    for name in ("", "absent.csv", "no.parquet"):
        with pytest.raises(InputError):
            first_arms(str(tmp_path / name), DesignSpace())
