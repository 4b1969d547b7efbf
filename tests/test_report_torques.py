"""Torques of the joints in a report: of which arms, and that they are those of mobo evaluate."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import numpy as np
import pytest
from studies import mobo, mobo_json, run_study

from mobo_core.bag.collector import read_study
from mobo_core.evaluation.evaluate import evaluate
from mobo_core.report.figures.registry import FIGURES
from mobo_core.report.joint_torques import MOST_ARMS, chosen, held_arms
from mobo_core.report.row import Row
from mobo_core.report.table import StudyTable, study_table

SAMPLE = Path(__file__).parents[1] / "bags" / "sample" / "paper_6"


def row(trial: int, joints: str, reach: float, *, on_front: bool = False) -> Row:
    return Row(
        trial=trial, complete=True, joints=joints, sampled_joints=joints, lengths=(0.1,) * 6, reach=reach,
        torque=200.0, on_front=on_front, above_floor=reach >= 7.5, known_as=(), attempt=1, evaluator="e",
        seconds=0.1, reason="",
    )  # fmt: skip


def test_chosen_are_the_front_and_the_best_of_each_other_order() -> None:
    """By falling reach, above the floor; as many as a report has time for, and one at least."""
    rows = (
        row(0, "YPPYPY", 30.0, on_front=True),
        row(1, "YPPYPY", 29.0),
        row(2, "PRRYPY", 20.0),
        row(3, "PRRYPY", 21.0),
        row(4, "RPYPRP", 5.0, on_front=True),
        row(5, "RPPYPY", 28.0),
    )
    table = StudyTable(rows, 6, 75)
    assert [arm.trial for arm in chosen(table, 2250)] == [0, 5, 3]
    assert [arm.trial for arm in chosen(table, 10**9)] == [0]
    many = StudyTable(tuple(row(i, f"{i:06}", 30.0) for i in range(400)), 6, 75)
    assert len(chosen(many, 2250)) == MOST_ARMS
    assert chosen(StudyTable((), 6, 75), 2250) == []


def test_voxels_without_a_reached_pose_may_be_left_out() -> None:
    """Configurations, torques and sums are the same, to the bit, for fewer attempts; of no voxel comes nothing."""
    study = read_study(SAMPLE)
    best = study_table(study).useful_front[0]
    candidate, spec = study.candidate_of(best.trial), study.settings.spec
    assert candidate is not None
    whole = evaluate(candidate.urdf, spec, joint_torques=True, configurations=True)
    part = evaluate(candidate.urdf, spec, joint_torques=True, configurations=True, voxels=whole.voxel_reach > 0)
    assert (part.reach, part.torque, part.joint_torques) == (whole.reach, whole.torque, whole.joint_torques)
    assert whole.configurations is not None and part.configurations is not None
    for name in ("voxel", "pose", "q", "torque"):
        assert np.array_equal(getattr(part.configurations, name), getattr(whole.configurations, name))
    assert 0 < part.attempts < whole.attempts
    none = evaluate(candidate.urdf, spec, joint_torques=True, voxels=np.zeros(spec.n_voxels, bool))
    assert (none.reach, none.attempts, none.not_converged.sum()) == (0.0, 0, 0)


@pytest.mark.slow
def test_report_has_the_torques_that_evaluate_prints(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As joint_torques.csv, exactly, and on the page, rounded; nothing differs from what was recorded."""
    monkeypatch.setattr(FIGURES, "_entries", {"stages": FIGURES["stages"]})  # pictures take longest
    assert mobo("report", SAMPLE, "-o", tmp_path) == 0
    assert f"torques    {tmp_path / 'joint_torques.csv'}" in capsys.readouterr().out
    with (tmp_path / "joint_torques.csv").open(newline="", encoding="utf-8") as file:
        lines = list(csv.DictReader(file))
    trials = list(dict.fromkeys(line["trial"] for line in lines))
    table = study_table(read_study(SAMPLE))
    assert trials[: len(table.useful_front)] == [str(arm.trial) for arm in table.useful_front]
    assert len(lines) == 6 * len(trials)
    found = mobo_json(capsys, "evaluate", SAMPLE, "--trial", trials[0], "--json")
    assert [float(line["p95"]) for line in lines[:6]] == [joint["p95"] for joint in found["joint_torque"]]
    assert float(lines[0]["mean_torque"]) == found["mean_torque"]
    page = (tmp_path / "index.html").read_text(encoding="utf-8").partition("<h2>Torque per joint</h2>")[2]
    cells = re.findall(r"<td[^>]*>([^<]*)</td>", page)[:9]
    joint = found["joint_torque"][1]
    assert cells[0] == trials[0]
    assert cells[4] == f"{joint['mean']:.1f} / {joint['p95']:.1f} / {joint['peak']:.1f}"
    assert "is not what was recorded" not in page


@pytest.mark.slow
def test_arms_that_cannot_be_evaluated_are_left_out_and_invented_values_told(tmp_path: Path) -> None:
    """A URDF that is none costs its own line only; what the simulated engine invented is told on the page."""
    study = read_study(run_study(tmp_path / "bag", 6))
    table = study_table(study)
    first = chosen(table, 2250)[0]
    arms = held_arms(study, table, lambda done, total: None)
    assert first.trial in {arm.row.trial for arm in arms} and not any(arm.same for arm in arms)
    spoilt = study.candidate_of(first.trial)
    assert spoilt is not None
    spoilt.urdf = "<robot>"
    left = held_arms(study, table, lambda done, total: None)
    assert [arm.row.trial for arm in left] == [arm.row.trial for arm in arms if arm.row.trial != first.trial]
    assert mobo("report", tmp_path / "bag", "-o", tmp_path / "out") == 0
    assert "is not what was recorded" in (tmp_path / "out" / "index.html").read_text(encoding="utf-8")
