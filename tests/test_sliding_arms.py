"""Real arms with joints that slide: their order and sizes, what changes of them do, and where they stand."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from arms import KernelView, random_arm
from studies import mobo, mobo_json

from mobo_core.arms.place import space_of
from mobo_core.arms.real import RealArm
from mobo_core.arms.straight import arm_of_chain, longer
from mobo_core.arms.what_if import alterations
from mobo_core.atlas.file import packaged, read_atlas, write_atlas
from mobo_core.design import Design, DesignSpace, to_urdf
from mobo_core.evaluation.chain import chain_from_urdf

SPACE = DesignSpace(joint_types="RPYS", slide_stroke=0.3, slide_radius=0.04)
UNIMATE = Design("YPSPYP", (0.1, 0.1, 0.25, 0.05, 0.1, 0.0))


def _arm(design: Design) -> RealArm:
    return arm_of_chain(chain_from_urdf(to_urdf(design, SPACE)), "made")


def test_a_design_that_slides_is_itself_again() -> None:
    """Its order, lengths and strokes; at its own size its masses and their centres, its tubes and its pinion."""
    arm, wanted = _arm(UNIMATE), chain_from_urdf(to_urdf(UNIMATE, SPACE))
    assert arm.order is not None and arm.order.joints == UNIMATE.joints and arm.length == pytest.approx(0.6)
    assert arm.order.lengths == pytest.approx(UNIMATE.lengths, abs=1e-9)
    made = chain_from_urdf(arm.urdf(0.6, SPACE))
    assert made.slide.tolist() == wanted.slide.tolist() and made.mass == pytest.approx(wanted.mass)
    assert (made.lower, made.upper) == (pytest.approx(wanted.lower), pytest.approx(wanted.upper))
    for q in np.random.default_rng(0).uniform(wanted.lower, wanted.upper, (5, 6)):
        ours, theirs = KernelView(made, q), KernelView(wanted, q)
        assert ours.tip[3] == pytest.approx(theirs.tip[3], abs=1e-9)
        assert ours.torque() == pytest.approx(theirs.torque(), abs=1e-9)
        assert ours.tip[3] == pytest.approx(arm.frames(q)[1][-1], abs=1e-9)
    tube, own = (chain.capsule_joint.tolist().index(2) for chain in (made, wanted))
    ends = np.sort([made.capsule_a[tube, 2], made.capsule_b[tube, 2]])
    assert ends == pytest.approx(np.sort([wanted.capsule_a[own, 2], wanted.capsule_b[own, 2]]))


def test_any_arm_keeps_its_kinematics() -> None:
    """Oblique slides among them: its URDF moves as it did, and when it is twice as large it slides twice as far."""
    chain = chain_from_urdf(random_arm(2, slides=(1, 6)), "flange")
    arm = arm_of_chain(chain, "oblique")
    assert arm.order is not None and [joint.slides for joint in arm.joints] == [True, *[False] * 4, True]
    assert arm.order.q[0] == pytest.approx(0.5 * (chain.lower[0] + chain.upper[0]))
    made, twice = chain_from_urdf(arm.urdf()), chain_from_urdf(arm.urdf(2 * arm.length))
    assert twice.slide == pytest.approx(2 * chain.slide) and twice.upper[5] == pytest.approx(2 * chain.upper[5])
    for q in np.random.default_rng(1).uniform(chain.lower, chain.upper, (5, 6)):
        there = KernelView(chain, q)
        assert KernelView(made, q).tip[3] == pytest.approx(there.tip[3] - chain.placement_p[0], abs=1e-9)
        assert KernelView(made, q).torque() == pytest.approx(there.torque(), abs=1e-9)
        wide = np.where(chain.slide > 0, 2 * q, q)
        assert KernelView(twice, wide).tip[3] == pytest.approx(2 * KernelView(made, q).tip[3], abs=1e-9)


def test_a_slide_after_a_yaw_is_named_before_it() -> None:
    """There no slide is built; stroke and length go with it, and the tip of the twin stands where the arm's does."""
    text = to_urdf(Design("SYPPYP", (0.1, 0.15, 0.1, 0.1, 0.1, 0.05)), SPACE)
    arm = arm_of_chain(chain_from_urdf(text), "made")
    swapped = replace(
        arm, joints=(replace(arm.joints[1], placed=arm.joints[0].placed), replace(arm.joints[0],
                     placed=arm.joints[1].placed), *arm.joints[2:])
    )  # fmt: skip
    again = arm_of_chain(chain_from_urdf(swapped.urdf()), "swapped")
    assert again.order is not None and again.order.joints == "SYPPYP" and again.joints[1].slides
    assert again.order.lengths == pytest.approx((0.15, 0.1, 0.1, 0.1, 0.1, 0.05))


def test_changes_of_an_arm_that_slides() -> None:
    """Strokes change by mm of the arm as it is evaluated, and motors of slides are on the link before."""
    arm = _arm(Design("SPSRPR", (0.1, 0.1, 0.2, 0.1, 0.05, 0.05)))
    base, made = chain_from_urdf(arm.urdf(1.2, SPACE)), list(alterations(arm, 1.2, SPACE))
    by_change = {one.change: chain_from_urdf(one.urdf) for one in made}
    assert [sum(one.kind == kind for one in made) for kind in ("link", "limit", "mass", "base")] == [12, 24, 10, 4]
    farther = by_change["joint 3 upper limit +10 mm, to 310 mm"]
    assert farther.upper - base.upper == pytest.approx([0, 0, 0.01, 0, 0, 0])
    # The tube is longer, to be held when it is run out.
    assert farther.mass - base.mass == pytest.approx([0, 0, math.pi * 0.015**2 * 1000 * 0.01, 0, 0, 0])
    nearer = by_change["joint 3 lower limit +10 mm, to -290 mm"]
    assert nearer.lower - base.lower == pytest.approx([0, 0, 0.01, 0, 0, 0])
    heavier = by_change["joint 3 +100 g"]
    assert heavier.mass - base.mass == pytest.approx([0, 0.1, 0, 0, 0, 0])
    moment = heavier.mass[1] * heavier.com[1] - base.mass[1] * base.com[1]
    assert moment == pytest.approx(0.1 * base.placement_p[2])
    tip = KernelView(chain_from_urdf(longer(arm, 2, 0.01).urdf(0.6, SPACE)), np.zeros(6)).tip[3]
    assert tip == pytest.approx([0, 0, 0.61], abs=1e-9)
    assert space_of(SPACE, 4).slide_radius == 0.04


def test_the_commands(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Place, with its table, evaluate and size take a file whose joints slide, and say so."""
    path = packaged()
    assert path is not None
    atlas = read_atlas(path)
    few = replace(atlas.about, spec={**atlas.about.spec, "poses_per_voxel": 1, "workspace_min": [-0.5, -0.1, -0.1]})
    write_atlas(tmp_path / "few.parquet", replace(atlas, about=few))
    arm = tmp_path / "unimate.urdf"
    arm.write_text(to_urdf(UNIMATE, SPACE))
    assert mobo("arms", "place", arm, "--in", tmp_path / "few.parquet", "--top", "100") == 0
    out = capsys.readouterr().out
    assert "unimate, YPSPYP, scaled" in out and "none in the atlas, whose arms have 6 joints that turn" in out
    assert "joints that slide (3): N m" in out and "joint 3 upper limit +10 mm, to 160 mm" in out
    spec = tmp_path / "spec.yaml"
    spec.write_text("{ik_mode: complete, rules: 2, iterations: 12, poses_per_voxel: 1}")
    found = mobo_json(capsys, "arms", "evaluate", arm, "--spec", spec, "-o", tmp_path / "page", "--json")["arms"][0]
    assert found["slides"] == [None, None, 0.04, None, None, None] and found["worth"]["twin"]["reach"] > 0
    assert "unimate.urdf" in (tmp_path / "page" / "index.html").read_text()
    sized = mobo_json(capsys, "size", arm, "--spec", spec, "--json")
    assert len(sized["joints"]) == 6 and sized["joints"][2]["peak"] > 0
    for words in (("Panda", "--set", "a=1"), ("--tip", "x"), (tmp_path / "none.urdf",)):
        assert mobo("arms", "evaluate", *words) == 2, words
        assert len(capsys.readouterr().err.splitlines()) == 1, words
