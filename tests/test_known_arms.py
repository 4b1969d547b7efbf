"""Real arms in sampling pictures: their twins, evaluated as a study's arms were, marked and named."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

import pytest
from arms import small_spec
from matplotlib.figure import Figure
from studies import mobo, run_study

from mobo_core.arms.catalogue import find_arm
from mobo_core.arms.twins import twins_in
from mobo_core.bag.collector import read_study
from mobo_core.design import Design, DesignSpace, to_urdf
from mobo_core.evaluation.evaluate import evaluate
from mobo_core.report.figures.known_marks import known_labels, mark_known
from mobo_core.report.figures.sampling import sampling_figure
from mobo_core.report.known import KnownArm, known_arms_in, known_arms_of, known_columns
from mobo_core.report.table import study_table

SAMPLE = Path(__file__).parents[1] / "bags" / "sample"
SPEC = small_spec(poses_per_voxel=2, ik_mode="complete", rules=2, iterations=12)


def test_they_are_the_twins_as_evaluated() -> None:
    """Every arm whose twin lies in the space is there once, with the twin's values; hollow where masses are unknown."""
    space = DesignSpace(n_joints=7)
    arms = known_arms_in(space, SPEC, ("axes",))
    names = [name for arm in arms for name in arm.names]
    assert sorted(names) == sorted(arm.name for twin in twins_in(space) for arm in twin.arms)
    panda = next(arm for arm in arms if "Panda" in arm.names)
    found = evaluate(to_urdf(Design(panda.joints, panda.lengths), space), SPEC, objectives=("axes",))
    assert (panda.reach, panda.torque, dict(panda.extra)) == (found.reach, found.torque, found.extra)
    for arm in arms:
        assert arm.estimated == all("masses" in find_arm(name).estimated for name in arm.names)
    columns = known_columns(arms)
    assert set(columns["masses"]) == {"source", "estimated"} and columns["length_7"][0] == arms[0].lengths[6]
    assert columns["axes"][0] == dict(arms[0].extra)["axes"]
    assert known_columns(()) == {"arms": [], "joints": [], "reach": [], "torque": [], "masses": []}


def test_no_more_than_a_few_seconds() -> None:
    """Of a large question as many as may be, those that the paper names first; of one that is too large none."""
    few = known_arms_in(DesignSpace(), SPEC.model_copy(update={"poses_per_voxel": 400_000 // 12 // 3}))
    assert len(few) == 3 and any(find_arm(name).paper for name in few[0].names)
    assert known_arms_in(DesignSpace(), small_spec(poses_per_voxel=40_000)) == ()


def test_marks_and_names() -> None:
    """A diamond each, hollow where it is estimated; what stands together has one label, with no more names than fit."""
    axes = Figure().add_subplot()
    axes.set(xlim=(0, 75), ylim=(0, 500))
    at = (("A", "B"), 10.0, 100.0), (("C",), 10.5, 101.0), (("D",), 60.0, 400.0)
    arms = [KnownArm(names, "YPPYPY", (0.1,) * 6, reach, torque, (), names == ("D",)) for names, reach, torque in at]
    handles = mark_known(axes, arms)
    assert [handle.get_label() for handle in handles] == ["real arm, as its twin  (3)", "likewise, masses unknown  (1)"]
    solid, hollow = axes.collections
    assert (len(solid.get_offsets()), len(hollow.get_offsets())) == (2, 1)
    assert hollow.get_facecolor()[0].tolist() == [1, 1, 1, 1] != solid.get_facecolor()[0].tolist()
    assert [label.text for label in known_labels(axes, arms)] == ["A, B +1", "D"]


def test_the_report_shows_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """In picture, table and page; the same for all three."""
    study = read_study(SAMPLE / "mobo_7")
    table = study_table(study)
    arms = known_arms_of(study, table)
    figure = sampling_figure(table, "sample", arms)
    texts = " ".join(text.get_text() for text in figure.axes[0].texts)
    assert all(name in texts for name in ("Panda", "Gen3", "xArm 7"))
    # All marks are inside.
    (left, right), (low, high) = figure.axes[0].get_xlim(), figure.axes[0].get_ylim()
    assert all(left < arm.reach < right and low < arm.torque < high for arm in arms)
    assert mobo("report", SAMPLE / "mobo_7", "-o", tmp_path) == 0
    with (tmp_path / "known_arms.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["reach"]) for row in rows] == [arm.reach for arm in arms]
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    found = re.search(r'id="data-sampling">(.*?)</script>', page)
    assert found is not None
    told = json.loads(found[1])
    assert [tuple(one["names"]) for one in told] == [arm.names for arm in arms]
    assert told[0]["values"]["torque"] == arms[0].torque and told[0]["values"]["length_7"] == arms[0].lengths[6]


def test_invented_values_are_not_held_against_them(tmp_path: Path) -> None:
    """A study of the simulated engine shows none, and names the best of each known order as ever."""
    study = read_study(run_study(tmp_path / "bag", 30, settings={"sampler": "random", "space": {"joint_types": "YP"}}))
    table = study_table(study)
    assert known_arms_of(study, table) == ()
    texts = [text.get_text() for text in sampling_figure(table, "simulated").axes[0].texts]
    assert any(row.known_as for row in table.complete) == any("\n" in text for text in texts)
