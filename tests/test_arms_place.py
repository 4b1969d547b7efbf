"""Where an arm stands: the scaled arm, distances to fronts, changes and their intervals."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from arms import small_spec
from hypothesis import given, settings
from hypothesis import strategies as st
from studies import mobo, mobo_json

from mobo_core.arms.place import better, length_moves, place
from mobo_core.arms.resample import Resamples
from mobo_core.arms.straight import arm_of_chain, leaning, limited, longer
from mobo_core.arms.what_if import alterations, what_if
from mobo_core.atlas.file import packaged, read_atlas, write_atlas
from mobo_core.design import Design, DesignSpace, to_urdf
from mobo_core.evaluation.chain import Chain, chain_from_urdf
from mobo_core.evaluation.evaluate import evaluate
from mobo_core.report.figures.known_marks import Placed
from mobo_core.report.figures.sampling import sampling_figure
from mobo_core.report.placing import table_of_atlas
from mobo_core.report.table import StudyTable
from mobo_core.search.front import hypervolume

LENGTHS = (0.05, 0.2, 0.15, 0.1, 0.04, 0.06)
DESIGN = Design("YPPYPY", LENGTHS)
SPACE = DesignSpace()
ARM = arm_of_chain(chain_from_urdf(to_urdf(DESIGN, SPACE)), "made")


def _tip(chain: Chain) -> np.ndarray:
    at, turned = np.zeros(3), np.eye(3)
    for placed, step in zip(chain.placement_r, chain.placement_p, strict=True):
        at, turned = at + turned @ step, turned @ placed
    return at + turned @ chain.tip_p


def test_a_design_scaled_to_itself_is_itself() -> None:
    """Lengths, masses and their centres; and each link changed is the design with that link changed."""
    assert ARM.order is not None and ARM.order.joints == DESIGN.joints
    for link in range(6):
        lengths = list(LENGTHS)
        lengths[link] += 0.01
        made = chain_from_urdf(longer(ARM, link, 0.01).urdf(0.6, SPACE))
        wanted = chain_from_urdf(to_urdf(Design("YPPYPY", tuple(lengths)), SPACE))
        assert _tip(made) == pytest.approx([0, 0, 0.61], abs=1e-9)
        assert made.mass == pytest.approx(wanted.mass) and made.reach_radius == pytest.approx(0.61)
        assert np.linalg.norm(made.com, axis=1) == pytest.approx(np.linalg.norm(wanted.com, axis=1), abs=1e-9)


def test_other_changes_change_what_they_say() -> None:
    """Limits, a mass at a joint's origin, a base that leans towards x or y."""
    chain, base = chain_from_urdf(ARM.urdf(0.6, SPACE)), ARM.urdf(0.6, SPACE)
    wider = chain_from_urdf(limited(ARM, 2, -3.0, 2.0).urdf(0.6, SPACE))
    assert (wider.lower[2], wider.upper[2]) == (-3.0, 2.0) and wider.lower[1] == chain.lower[1]
    heavier = chain_from_urdf(ARM.urdf(0.6, SPACE, {3: 0.1}))
    assert heavier.mass - chain.mass == pytest.approx([0, 0, 0, 0.1, 0, 0])
    assert heavier.mass[3] * heavier.com[3] == pytest.approx(chain.mass[3] * chain.com[3])
    leant = _tip(chain_from_urdf(leaning(ARM, (0.0, 1.0, 0.0), math.radians(10)).urdf(0.6, SPACE)))
    assert leant == pytest.approx([0.6 * math.sin(math.radians(10)), 0, 0.6 * math.cos(math.radians(10))])
    made = list(alterations(ARM, 0.6, SPACE))
    assert [sum(one.kind == kind for one in made) for kind in ("link", "limit", "mass", "base")] == [12, 24, 12, 4]
    towards_y = next(one for one in made if one.change == "base +10° towards y")
    assert _tip(chain_from_urdf(towards_y.urdf))[1] > 0.1
    assert len({one.urdf for one in made} | {base}) == len(made) + 1


@settings(max_examples=15, deadline=None)
@given(st.lists(st.floats(0.0, 1.0), min_size=2, max_size=7), st.randoms())
def test_moves_make_lengths_into_others(shares: list[float], random: object) -> None:
    """What is moved from link to link makes the first lengths into the second, to a millimetre."""
    before = np.array(shares) + 0.01
    before *= 0.6 / before.sum()
    after = list(before)
    random.shuffle(after)  # type: ignore[attr-defined]
    at = before.copy()
    for by, source, sink in length_moves(before.tolist(), after):
        assert by > 0 and source != sink
        at[source - 1] -= by
        at[sink - 1] += by
    assert np.abs(at - after).max() < 2e-3 * len(shares)


def test_scores_and_intervals() -> None:
    """Scores are the evaluation's; an arm differs from itself by nothing; pairs are surer than their parts."""
    spec = small_spec(ik_mode="complete", rules=3, restarts=303, iterations=12)
    resamples = Resamples(spec)
    urdf = ARM.urdf(0.6, SPACE)
    score, result = resamples.score(urdf), evaluate(urdf, spec, joint_torques=True)
    assert (score.reach, score.torque) == (result.reach, result.torque)
    assert score.values[2:] == pytest.approx([joint.peak for joint in result.joint_torques or ()], abs=1e-12)
    # Reach's error by theory: of each voxel a share p of n poses.
    p = result.voxel_reach
    assert score.drawn[:, 0].std() == pytest.approx(math.sqrt((p * (1 - p) / spec.poses_per_voxel).sum()), rel=0.2)
    assert (score.drawn[:, 2:] <= score.values[2:]).all() and score.drawn[:, 1].mean() == pytest.approx(
        score.torque, rel=0.05
    )
    assert all((one.value, one.low, one.high) == (0, 0, 0) and not one.sure for one in score.over(score))
    lighter = next(one for one in alterations(ARM, 0.6, SPACE) if one.change == "joint 6 -100 g")
    shorter = next(one for one in alterations(ARM, 0.6, SPACE) if one.change == "link 2 -10 mm")
    rows = what_if(score, [shorter, lighter], resamples, lambda done, total: None)
    assert rows[0].gain >= rows[1].gain
    first = next(row for row in rows if row.change == lighter.change)
    assert first.reach.value == 0 and first.torque.sure and first.torque.high < 0 and first.peaks[0].value == 0
    assert first.torque.half < 0.2 * score.drawn[:, 1].std()
    assert first.gain == pytest.approx(-100 * first.torque.value / score.torque)


def test_an_arm_of_an_atlas_stands_on_its_front() -> None:
    """Read from its URDF and scaled to its own size it scores what the atlas says, and no arm of its order beats it."""
    path = packaged()
    assert path is not None
    atlas = read_atlas(path)
    row = next(row for row, joints in enumerate(atlas.joints) if joints == "YPPYPY")
    design = atlas.design(row)
    arm = arm_of_chain(chain_from_urdf(to_urdf(design, atlas.space)), "a")
    found = place(arm, atlas, times_poses=1)
    assert found.scaled.reach == pytest.approx(atlas.values["reach"][row], abs=0.1)
    assert found.scaled.torque == pytest.approx(atlas.values["torque"][row], rel=5e-3)
    assert found.of_order is not None and found.of_order.more_reach is None
    rival = found.of_all.more_reach
    assert rival is not None and rival.design.joints != "YPPYPY" and rival.reach.sure
    own = np.flatnonzero([joints == "YPPYPY" for joints in atlas.joints])
    worse = replace(found.scaled, reach=found.scaled.reach - 1, torque=found.scaled.torque + 1)
    assert better(atlas, own, worse)[0] == row


def test_the_picture_has_the_arm_in_the_atlas() -> None:
    """All arms of the atlas, a star for the arm and a hollow one for its twin, and the other real arms."""
    path = packaged()
    assert path is not None
    atlas = read_atlas(path)
    table = table_of_atlas(atlas)
    assert len(table.complete) == len(atlas) and table.complete[7].joints == atlas.joints[7]
    assert hypervolume([row.values for row in table.front], table.aims) == pytest.approx(atlas.about.hypervolume)
    few = StudyTable(table.rows[:50], table.n_joints, table.n_voxels, table.aims)
    placed = [Placed("ours, scaled", 70.0, 900.0, True), Placed("ours, its twin", 30.0, 300.0, False)]
    axes = sampling_figure(few, "ours", placed=placed).axes[0]
    assert {"ours, scaled", "ours, its twin"} <= {text.get_text() for text in axes.texts}
    assert axes.get_xlim()[1] > 70 and axes.get_ylim()[1] > 900


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Words and JSON say the same; bad input gets one line."""
    path = packaged()
    assert path is not None
    atlas = read_atlas(path)
    few = replace(atlas.about, spec={**atlas.about.spec, "poses_per_voxel": 3})
    write_atlas(tmp_path / "few.parquet", replace(atlas, about=few))
    where = ("--in", tmp_path / "few.parquet", "--what-if", "none")
    assert mobo("arms", "place", "xarm6", *where, "-o", tmp_path / "xarm6.svg") == 0
    assert (tmp_path / "xarm6.svg").read_bytes().startswith(b"<?xml")
    out = capsys.readouterr().out
    assert "xArm6, YPPYPY, scaled" in out and "for the same torque," in out and "front of its own order" in out
    found = mobo_json(capsys, "arms", "place", "xarm6", *where, "--json")
    assert f"reach {found['scaled']['reach']:.2f} of 75" in out and found["what_if"] is None
    assert found["front_of_all"]["more_reach"]["joints"] in out
    (tmp_path / "bad.urdf").write_text("<robot/>")
    (tmp_path / "bad.parquet").write_text("no")
    for words in (
        ("UR99",), (tmp_path / "bad.urdf",), (tmp_path / "none.urdf",), ("UR5", "--in", tmp_path / "bad.parquet"),
        ("UR5", "--in", tmp_path), ("UR5", "--top", "-1"), ("UR5", "--set", "a=1"), ("UR5", "--tip", "b"),
        ("UR5", "-o", tmp_path / "x.txt"),
    ):  # fmt: skip
        assert mobo("arms", "place", *words) == 2, words
        assert len(capsys.readouterr().err.splitlines()) == 1, words
