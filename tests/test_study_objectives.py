"""Studies of other objectives than reach and torque: run, recorded, resumed, verified, reported."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from studies import mobo, run_study

from mobo_core.bag.collector import read_study
from mobo_core.bag.validity import evaluation_fault, values_of
from mobo_core.errors import InputError
from mobo_core.report.table import study_table
from mobo_core.search.study import StudySettings
from mobo_core.verify.verify import verify

THREE = ("reach", "peak_torque", "mass")
SETTINGS = {
    "objectives": "reach,peak_torque,mass",
    "n_startup_trials": 4,
    "in_flight": 3,
    "spec": {"poses_per_voxel": 2, "ik_mode": "complete"},
}


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study of three objectives, killed once."""
    folder = tmp_path_factory.mktemp("three") / "bag"
    run_study(folder, 10, settings=SETTINGS, engine="kernel", kill_after=6)
    return run_study(folder, 10, settings=SETTINGS, engine="kernel", resume=True)


def test_values_travel_to_the_bag_and_are_verified(bag: Path) -> None:
    """Each trial holds what its evaluation says, which the kernel says again, to the bit."""
    study = read_study(bag)
    assert study.settings.objectives == THREE and study.record["objectives"] == "reach,peak_torque,mass"
    for trial in study.complete_trials():
        evaluation = study.accepted(trial.trial)
        assert evaluation is not None
        assert trial.extra_names == ["peak_torque", "mass"]
        assert values_of(trial, THREE) == values_of(evaluation, THREE)
        assert evaluation.reach > 0 and min(trial.extra_values) > 0
    assert [list(candidate.objectives) for candidate in study.candidates] == [list(THREE)] * len(study.candidates)
    assert mobo("verify", bag, "--workers", 1) == 0


def test_the_same_trials_without_a_kill(bag: Path, tmp_path: Path) -> None:
    """A study that ran through asks for the same arms."""
    other = read_study(run_study(tmp_path / "other", 10, settings=SETTINGS, engine="kernel", evaluators=("one",)))
    arms = {candidate.trial: candidate.params_json for candidate in other.candidates}
    assert {candidate.trial: candidate.params_json for candidate in read_study(bag).candidates} == arms


@pytest.mark.parametrize("name", ["peak_torque", "mass"])
def test_a_changed_value_is_found(bag: Path, name: str) -> None:
    """In the evaluation and its trial, or in the trial alone."""
    study = read_study(bag)
    trial = study.trials[2]
    place = trial.extra_names.index(name)
    trial.extra_values = trial.extra_values.copy()
    trial.extra_values[place] = np.nextafter(trial.extra_values[place], 0.0)
    assert (2, name) in {(fault.trial, fault.field) for fault in verify(study, sample=0).faults}
    evaluation = study.accepted(2)
    assert evaluation is not None
    evaluation.extra_values = trial.extra_values
    assert (2, name) in {(fault.trial, fault.field) for fault in verify(study).faults}


def test_the_front_is_that_of_the_three(bag: Path, tmp_path: Path) -> None:
    """Tables have a column for each, and no arm on the front is dominated in all three."""
    table = study_table(read_study(bag))
    losses = {row.trial: (-row.values[0], row.values[1], row.values[2]) for row in table.complete}
    for trial, loss in losses.items():
        beaten = any(all(a <= b for a, b in zip(o, loss, strict=True)) and o != loss for o in losses.values())
        assert table.rows[trial].on_front is not beaten
    assert 0 < table.hypervolume(10) < 1
    assert mobo("report", bag, "-o", tmp_path / "report") == 0
    with next((tmp_path / "report").rglob("trials.csv")).open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["mass"]) for row in rows] == [row.values[2] for row in table.rows]


def test_an_answer_without_an_objective_is_not_good(bag: Path) -> None:
    """Missing or not finite."""
    study = read_study(bag)
    evaluation = study.evaluations[0]
    assert evaluation_fault(evaluation, study.settings.spec.n_voxels, THREE) == ""
    evaluation.extra_values = np.array([1.0, np.nan])
    assert evaluation_fault(evaluation, study.settings.spec.n_voxels, THREE) == "no finite mass"
    evaluation.extra_names, evaluation.extra_values = [], np.empty(0)
    assert evaluation_fault(evaluation, study.settings.spec.n_voxels, THREE) == "no finite peak_torque"


def test_simulated_answers_have_them_too(tmp_path: Path) -> None:
    """Made up, within their bounds, and two objectives need not be reach and torque."""
    settings = {"objectives": "mass,manipulability", "n_startup_trials": 4}
    bag = run_study(tmp_path / "bag", 8, settings=settings)
    table = study_table(read_study(bag))
    assert len(table.complete) == 8 and 0 < table.hypervolume(8) < 1


@pytest.mark.parametrize(
    ("objectives", "says"),
    [
        ("reach", "two or three distinct names"),
        ("reach,reach", "two or three distinct names"),
        ("reach,torque,mass,axes", "two or three distinct names"),
        ("reach,price", "names of reach, torque, mean_torque, peak_torque, manipulability, mass or axes"),
        (7, "tuple"),
    ],
)
def test_objectives_that_are_none(objectives: object, says: str) -> None:
    """One line that says what was expected."""
    with pytest.raises(InputError, match=f"objectives = .*; expected .*{says}"):
        StudySettings.of({"objectives": objectives})


def test_a_bag_that_does_not_say_means_reach_and_torque() -> None:
    """As all bags did before there was a choice."""
    sample = Path(__file__).parent.parent / "bags/sample/paper_6"
    study = read_study(sample)
    assert "objectives" not in study.record and study.settings.objectives == ("reach", "torque")
