"""The outcome of the paper's studies that docs/paper/ keeps: small bags of the best arms, and tables of all trials."""

from __future__ import annotations

from pathlib import Path

import pytest
from studies import mobo

from mobo_core.bag.collector import read_study

PAPER = Path(__file__).parents[1] / "docs" / "paper"
BEST = sorted(PAPER.glob("*_best"))

pytestmark = pytest.mark.skipif(not BEST, reason="no checkout")


@pytest.mark.slow
def test_the_best_arms_verify(capsys: pytest.CaptureFixture[str]) -> None:
    """Those of six joints: every URDF and design made again, a hundred of them evaluated, to the bit."""
    assert mobo("verify", PAPER / "tpe6_best", "--sample", 100) == 0
    assert capsys.readouterr().out.startswith("good: ")


@pytest.mark.parametrize("bag", BEST, ids=lambda bag: bag.name)
def test_they_are_the_best_of_the_table(bag: Path) -> None:
    """A study of its front and of the best arm of each order gave them the values that the long study did."""
    parquet = pytest.importorskip("pyarrow.parquet")
    rows = parquet.read_table(bag.with_name(bag.name.removesuffix("_best") + ".parquet")).to_pylist()
    rows = [row for row in rows if row["state"] == "COMPLETE"]
    best = {row["joints"]: 0.0 for row in rows}
    for row in rows:
        best[row["joints"]] = max(best[row["joints"]], row["reach"])
    front = {(row["joints"], row["reach"], row["torque"]) for row in rows if row["on_front"] and row["above_floor"]}
    study = read_study(bag)
    found = {
        (candidate.joints, trial.reach, trial.torque)
        for number, trial in study.trials.items()
        if (candidate := study.candidate_of(number)) is not None
    }
    assert front <= found and {(joints, reach) for joints, reach, _ in found} >= set(best.items())
    assert len(found) == len(front | {arm for arm in found if arm[1] == best[arm[0]]})
    assert sum(file.stat().st_size for file in bag.iterdir()) < 3_000_000
    assert all(file.stat().st_size < 3_000_000 for file in PAPER.glob("*.parquet"))
