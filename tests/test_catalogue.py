"""The catalogue of real arms: sources, joint orders, and what they are worth."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from arms import KernelView, small_spec
from studies import mobo, mobo_json

from mobo_core.arms.arm_joint import ArmJoint
from mobo_core.arms.catalogue import MISSING, NAMED, catalogue, find_arm, known_arms
from mobo_core.arms.order import order_of
from mobo_core.arms.real import RealArm
from mobo_core.arms.rigid import Placement
from mobo_core.arms.worth import larger, worth
from mobo_core.design import DesignSpace
from mobo_core.design.joints import JOINTS, effective_joints
from mobo_core.errors import InputError
from mobo_core.evaluation.chain import chain_from_urdf
from mobo_core.evaluation.evaluate import evaluate
from mobo_core.evaluation.spec import EvaluationSpec

COMPLETE = {"ik_mode": "complete", "rules": 2, "iterations": 12}


def test_every_arm_has_a_source_and_a_chain() -> None:
    """Sixty arms or more, each with source, licence, order and limits; its URDF has its kinematics and its masses."""
    arms = catalogue()
    assert len(arms) >= 60 and len({(arm.maker, arm.name) for arm in arms}) == len(arms)
    for arm in arms:
        assert {"package", "version", "path"} <= arm.source.keys() and arm.licence
        assert arm.order is not None and len(arm.order.joints) == arm.n == len(arm.order.lengths)
        assert effective_joints(arm.order.joints) == arm.order.joints
        chain = chain_from_urdf(arm.urdf())
        assert chain.n == arm.n and chain.mass.min() >= 0 and chain.mass.sum() > 0
        assert np.all(chain.upper > chain.lower)
        assert chain.reach_radius == pytest.approx(sum(arm.segments)) and chain.reach_radius > 0.95 * arm.length
    own = [arm for arm in arms if arm.bodies is not None]
    assert len(own) >= 10 and all("masses" not in arm.estimated for arm in own)
    # As makers state them.
    assert sum(mass for mass, _ in find_arm("UR5").bodies or ()) == pytest.approx(18.4, abs=1.5)  # kg
    assert find_arm("iiwa14").length == pytest.approx(1.306 - 0.36 + 0.2, abs=0.15)


def test_the_straightened_arm_is_its_order() -> None:
    """In the posture given, heights add up to the lengths, and axes stand as the letters say, but for the skew."""
    for arm in catalogue():
        order = arm.order
        assert order is not None
        axes, origins, _ = arm.frames(np.array(order.q))
        view = KernelView(chain_from_urdf(arm.urdf()), np.array(order.q))
        assert np.abs(view.tip[3] - origins[-1]).max() < 1e-8  # axes are rounded
        if order.skew < 1e-3 and abs(axes[0, 2]) > 0.999:
            upright = np.abs(axes[:, 2]) > 0.9
            assert [letter == "Y" for letter in order.joints] == upright.tolist(), arm.name
            heights = np.maximum(0.0, np.diff(origins[:, 2]))
            assert order.lengths == pytest.approx(heights, abs=1e-5)


@pytest.mark.parametrize(
    ("joints", "lengths"),
    [("YPPYPY", (0.05, 0.2, 0.15, 0.1, 0.04, 0.06)), ("PRRYPY", (0.06, 0.2, 0.1, 0.1, 0.1, 0.04))],
)
def test_a_design_has_its_own_order(joints: str, lengths: tuple[float, ...]) -> None:
    """An arm of a design space, its joints' zeros turned anywhere, is given its own letters and lengths back."""
    turns = [Placement((0.0, 0.0, length), (0.0, 0.0, 0.0)) for length in (0.0, *lengths)]
    made = tuple(
        ArmJoint(placed, JOINTS[letter].axis, -2.0, 2.0) for placed, letter in zip(turns, joints, strict=False)
    )
    order = order_of(RealArm("made", "us", made, turns[-1], None, {}, ""))
    assert order.joints == joints
    assert order.lengths == pytest.approx(lengths, abs=1e-5)
    assert (order.skew, order.offset) == pytest.approx((0.0, 0.0), abs=1e-5)


def test_orders_that_the_paper_states() -> None:
    """Arms of the paper that a source holds have the order that it gives them; the others are named as missing."""
    for name, joints in (("ViperX 300s", "YPPYPY"), ("xArm6", "YPPYPY"), ("Gen3", "YPYPYPY")):
        order = find_arm(name).order
        assert order is not None and order.joints == joints
    held = {arm.paper for arm in catalogue()}
    assert all(name in held or name in MISSING for name, _, _ in NAMED)
    assert {"ALOHA", "COBOTTA"} <= set(known_arms("YPPYPY")) and known_arms("YPPYPY")[-1].endswith(" more")
    assert known_arms("YPRPPPP") == known_arms("YPRPYPR") == ("Cyton Gamma",)
    assert known_arms("PRRYPY") == known_arms("YPYPYPRP") == ()


def test_three_evaluations() -> None:
    """The scaled arm has the space's length and masses; what is as large as its workspace scores alike at any size."""
    arm, spec = find_arm("UR5e"), small_spec(poses_per_voxel=4, ik_mode="complete", rules=2, iterations=12)
    chain, segments = chain_from_urdf(arm.urdf(0.6, DesignSpace())), sum(arm.segments) * 0.6 / arm.length
    assert chain.reach_radius == pytest.approx(segments)
    links = math.pi * 0.015**2 * 1000.0 * segments
    assert chain.mass.sum() == pytest.approx(6 * 0.5 + links)
    found = worth(arm, spec)
    assert found.own.reach == pytest.approx(found.scaled.reach, abs=1.0)
    # Estimated masses grow as solid bodies do, torques by one power more.
    grown = (arm.length / 0.6) ** 4
    assert found.own.mean_torque / found.scaled.mean_torque == pytest.approx(grown, rel=0.1)
    assert 0 < found.twin.reach <= spec.n_voxels
    assert larger(spec, 1.7).shape == spec.shape


def test_what_stands_around_grows_with_the_workspace() -> None:
    """Floor and boxes do; tool and payload do not; where poses are given nothing does."""
    boxes = [{"centre": [0.4, 0.0, 0.1], "rpy": [0.0, 0.0, 0.5], "size": [0.3, 0.6, 0.2]}]
    spec = small_spec(floor_z=-0.1, obstacles=boxes, tool_xyz=(0.0, 0.0, 0.1), payload_kg=1.0)
    twice = larger(spec, 2.0)
    assert (twice.floor_z, twice.tool_xyz, twice.payload_kg) == (-0.2, spec.tool_xyz, 1.0)
    assert twice.obstacles[0].centre == (0.8, 0.0, 0.2) and twice.obstacles[0].size == (0.6, 1.2, 0.4)
    assert twice.obstacles[0].rpy == spec.obstacles[0].rpy and larger(small_spec(), 2.0).floor_z is None
    posed = EvaluationSpec.of({**spec.to_dict(), "poses_per_voxel": 1, "target_poses": [[0.3, 0, 0.2, 0, 0, 0]]})
    assert larger(posed, 2.0) == posed
    # An arm that is as much larger as the scene reaches alike.
    arm, asked = find_arm("xArm6"), small_spec(poses_per_voxel=2, floor_z=0.0, obstacles=boxes, **COMPLETE)
    same, wide = (evaluate(arm.urdf(0.6 * k), larger(asked, k)).reach for k in (1.0, 2.0))
    assert same == pytest.approx(wide, abs=0.5) and 0 < same < evaluate(arm.urdf(0.6), small_spec(**COMPLETE)).reach


def test_the_commands(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """List, show and evaluate print and write what they say; a name that is none gets one line."""
    assert len(mobo_json(capsys, "arms", "list", "--json")["arms"]) == len(catalogue())
    assert mobo("arms", "list", "--joints", "yppypy") == 0
    assert mobo("arms", "show", "ur5", "--urdf", tmp_path / "ur5.urdf") == 0
    assert mobo("arms", "show", "aloha") == 0
    out = capsys.readouterr().out
    assert "ViperX 300s" in out and "in the paper ALOHA" in out
    assert chain_from_urdf((tmp_path / "ur5.urdf").read_text()).n == 6
    spec = tmp_path / "spec.yaml"
    spec.write_text("{ik_mode: complete, rules: 2, iterations: 12, poses_per_voxel: 1}")
    assert mobo("arms", "evaluate", "UR5", "ViperX 300s", "--spec", spec, "-o", tmp_path / "page") == 0
    page = (tmp_path / "page" / "index.html").read_text()
    assert page.count("<svg") == 2 and "default-src 'none'" in page and "COBOTTA" in page
    rows = json.loads((tmp_path / "page" / "arms.json").read_text())["arms"]
    assert [row["name"] for row in rows] == ["UR5", "ViperX 300s"] and rows[0]["worth"]["twin"]["reach"] > 0
    capsys.readouterr()
    assert mobo("arms", "show", "UR99") == 2
    assert len(capsys.readouterr().err.splitlines()) == 1
    with pytest.raises(InputError, match="one of Panda"):
        find_arm("pand")
