"""Joints that slide: their rule, their description, and arms with them by kernel, Pinocchio and search."""

from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from arms import KernelView, random_arm, small_spec
from hypothesis import given, settings
from hypothesis import strategies as st
from studies import mobo, run_study

from mobo_core.arms.motors import Motors
from mobo_core.arms.read import read_arm
from mobo_core.arms.size import size
from mobo_core.bag.collector import read_study
from mobo_core.design import Design, DesignSpace, effective_joints, to_urdf
from mobo_core.design.joints import count_orders, effective_orders, yaw_rule
from mobo_core.design.prepared import PreparedXacro
from mobo_core.evaluation.chain import chain_from_urdf
from mobo_core.evaluation.evaluate import evaluate, solve_poses
from mobo_core.evaluation.reference import ReferenceModel
from mobo_core.evaluation.spec import load_spec

SPACE = DesignSpace(n_joints=5, joint_types="RPYS", slide_stroke=0.3, slide_radius=0.04)
KINDS = (("small", 1.0, 0.1), ("middle", 5.0, 0.4), ("large", 50.0, 1.5))
UNIMATE = Design("YPSPY", (0.1, 0.1, 0.25, 0.05, 0.1))


@given(st.text("RPYS", min_size=1, max_size=12))
def test_no_second_slide_in_a_row(sampled: str) -> None:
    """In place of a slide right after one a pitch is built; the yaw rule stands; nothing changes twice."""
    built = effective_joints(sampled)
    for before, joint, drawn in zip(built, built[1:], sampled[1:], strict=False):
        assert joint == ("P" if before == "Y" or before == drawn == "S" else drawn)
    assert effective_joints(built) == built


def test_orders_with_slides() -> None:
    """They are counted as they are listed; without slides there are as many as ever, and the rule is said of yaws."""
    sampled = {effective_joints("".join(order)) for order in itertools.product("RPYS", repeat=4)}
    assert set(effective_orders(4, "RPYS")) == sampled and count_orders(4, "RPYS") == len(sampled)
    assert DesignSpace().n_orders == 239 and "S" not in DesignSpace().letters
    assert yaw_rule("RPY") == "after a yaw comes a pitch"
    assert yaw_rule("PS") == "in place of a second slide in a row comes a pitch"


def test_spaces_without_slides_are_written_as_ever() -> None:
    """Neither their settings nor their arms' URDFs say anything of slides."""
    assert not [name for name in DesignSpace().to_dict() if "slide" in name]
    assert "slide_radius" in DesignSpace(slide_radius=0.1).to_dict()
    assert "slide_radius" in DesignSpace().to_dict(full=True)
    assert "slide" not in to_urdf(Design("PRRYPY", (0.1,) * 6), DesignSpace())
    assert DesignSpace.of(SPACE.to_dict()) == SPACE


@settings(max_examples=10)
@given(st.text("RPYS", min_size=1, max_size=6), st.data())
def test_at_mid_stroke_the_arm_is_straight(sampled: str, data: st.DataObject) -> None:
    """At zero the tip is at (0, 0, total length); slides carry what is above them, and move alike either way."""
    n = len(sampled)
    lengths = tuple(data.draw(st.lists(st.sampled_from([0.0, 0.05, 0.2]), min_size=n, max_size=n)))
    design = Design(sampled, lengths)
    chain = chain_from_urdf(to_urdf(design, SPACE))
    view = KernelView(chain, np.zeros(n))
    assert view.tip[3] == pytest.approx([0, 0, math.fsum(lengths)], abs=1e-15)
    slides = np.array([joint == "S" for joint in design.joints])
    half = np.clip(np.minimum(0.15, lengths), 0.0005, None)
    assert np.array_equal(chain.slide, np.where(slides, 0.04, 0.0))
    np.testing.assert_allclose(chain.upper[slides], half[slides], rtol=1e-15)
    assert np.array_equal(chain.lower, -chain.upper)
    above = np.cumsum(chain.mass[::-1])[::-1]
    np.testing.assert_allclose(view.torque(), np.where(slides, 9.81 * 0.04 * above, 0.0), rtol=1e-12, atol=1e-15)
    assert chain.reach_radius == pytest.approx(math.fsum(lengths) + half[slides].sum(), abs=1e-12)


def test_the_tube_weighs_what_it_is() -> None:
    """Guide and motor belong to the link before; the tube is longer than its link by half the stroke."""
    tube, area = chain_from_urdf(to_urdf(UNIMATE, SPACE)), math.pi * 0.015**2 * 1000
    assert tube.mass[2] == pytest.approx(area * (0.25 + 0.15)) and tube.com[2] == pytest.approx([0, 0, 0.05])
    assert tube.mass[1] == pytest.approx(0.5 + area * 0.1 + 0.5)
    (carried,) = np.flatnonzero(tube.capsule_joint == 2)
    assert [tube.capsule_a[carried, 2], tube.capsule_b[carried, 2]] == pytest.approx([-0.15, 0.25])


def test_prepared_description_is_xacros() -> None:
    """Whichever of stroke and length binds."""
    prepared = PreparedXacro(SPACE)
    for lengths in ((0.1, 0.1, 0.2), (0.2, 0.0, 0.1)):
        design = Design("SPS", lengths)
        assert prepared.to_urdf(design) == to_urdf(design, SPACE)
    assert not prepared.plain


def test_engines_agree() -> None:
    """On Unimate's order and a joint kernel and reference reach the same, with the same torques; the audit is fine."""
    design = Design("YPSPYP", (0.1, 0.1, 0.25, 0.05, 0.1, 0.0))  # six joints: their kernel is there
    spec = small_spec(orientation="none", poses_per_voxel=3, restarts=1, iterations=15)
    asked: dict[str, Any] = {"space": SPACE, "configurations": True, "joint_torques": True, "audit_poses": 8}
    found, reference = (evaluate(design, spec, engine=engine, **asked) for engine in ("kernel", "reference"))
    assert found.slides == {"joint_3": 0.04} == found.to_dict()["slides"]
    assert found.reach > 3 and found.audit_fault == "" and found.audit_max_error < 1e-9
    assert found.voxel_reach.tolist() == reference.voxel_reach.tolist()
    np.testing.assert_allclose(found.configurations.q, reference.configurations.q, atol=1e-6)
    np.testing.assert_allclose(found.configurations.torque, reference.configurations.torque, atol=1e-6)
    for ours, theirs in zip(found.joint_torques, reference.joint_torques, strict=True):
        assert ours.peak == pytest.approx(theirs.peak, abs=1e-6)


@pytest.mark.parametrize("orientation", ["full", "free_roll"])
def test_poses_made_by_forward_kinematics_are_found(orientation: str) -> None:
    """By Pinocchio's kinematics, slides all the way out and in among them."""
    urdf = to_urdf(Design("YPSRPR", (0.1, 0.1, 0.2, 0.05, 0.05, 0.1)), SPACE)
    spec = load_spec("mobo").model_copy(update={"orientation": orientation, "self_collision": False})
    chain = chain_from_urdf(urdf)
    model, rng = ReferenceModel(chain), np.random.default_rng(0)
    made = rng.uniform(chain.lower, chain.upper, (200, chain.n))
    made[:20, 2], made[20:40, 2] = chain.upper[2], chain.lower[2]
    tips = [model.tip(q).copy() for q in made]
    outcome, q, torque = solve_poses(
        urdf, spec, np.array([tip.translation for tip in tips]), np.array([tip.rotation for tip in tips])
    )
    assert np.count_nonzero(outcome == 0) >= 198
    assert np.ptp(q[:, 2]) > 0.25
    for i in np.flatnonzero(outcome == 0):
        assert np.all((chain.lower <= q[i]) & (q[i] <= chain.upper))
        assert torque[i] == pytest.approx(float(np.linalg.norm(model.torque(q[i]))), abs=1e-9)
        found = model.tip(q[i])
        assert np.linalg.norm(found.translation - tips[i].translation) <= spec.position_tolerance + 1e-12
        if orientation == "full":
            assert np.linalg.norm(pin.log3(found.rotation.T @ tips[i].rotation)) <= spec.rotation_tolerance + 1e-9


def test_a_slide_of_many_metres_stays_within_its_limits() -> None:
    """A slide is not a joint that turns: beyond 2 pi metres no way stands for another."""
    urdf = to_urdf(Design("SPRYPR", (0.1, 0.3, 0.3, 0, 0, 0.1)), DesignSpace(joint_types="RPYS"))
    urdf = urdf.replace('lower="-0.1" upper="0.1"', 'lower="-9" upper="9"')
    chain = chain_from_urdf(urdf)
    assert chain.upper[0] == 9
    spec = load_spec("mobo").model_copy(update={"self_collision": False})
    places = np.array([[0.2, 0.1, z] for z in (-8.5, -4.0, 0.0, 4.0, 8.5)])
    outcome, q, _ = solve_poses(urdf, spec, places, np.tile(np.eye(3), (5, 1, 1)))
    for place, there in zip(places[outcome == 0], q[outcome == 0], strict=True):
        assert np.linalg.norm(ReferenceModel(chain).tip(there).translation - place) <= 1e-3 + 1e-12
    assert np.count_nonzero(outcome == 0) >= 4


def test_motors_of_slides_sit_on_the_link_before() -> None:
    """With motors in place of an arm's own, `mobo size` has the torques of the design with their masses."""
    motors = Motors.of({"motors": [{"name": name, "torque": n, "mass": kg, "source": "made"} for name, n, kg in KINDS]})
    design, spec = Design("SPSRPR", (0.1, 0.1, 0.2, 0.05, 0.05, 0.1)), small_spec(poses_per_voxel=5)
    found = size(to_urdf(design, SPACE), spec, 0.0, motors=motors, own_motors=(0.5,) * 6)
    masses = tuple(one.motor.mass for one in found.joints if one.motor)
    made = chain_from_urdf(to_urdf(design, DesignSpace.of(SPACE.to_dict() | {"n_joints": 6, "motor_mass": masses})))
    model = ReferenceModel(made)
    held = np.abs([model.torque(q) for q in found.result.configurations.q])
    assert len(set(masses)) > 1
    np.testing.assert_allclose([one.peak for one in found.joints], held.max(axis=0), atol=1e-9)


@pytest.mark.slow
def test_a_study_with_slides(tmp_path: Path) -> None:
    """It is searched, recorded, verified bit for bit, and reported."""
    space = {"joints": ["Y", "PS", "PS", "RS", "P", "R"]}
    spec = {"poses_per_voxel": 2, "ik_mode": "complete", "rules": 3, "restarts": 20, "iterations": 12}
    asked = {"space": space, "spec": spec, "sampler": "random"}
    bag = run_study(tmp_path / "bag", 8, settings=asked, engine="kernel")
    study = read_study(bag)
    assert "S" in "".join(candidate.joints for candidate in study.candidates)
    assert max(trial.reach for trial in study.complete_trials()) > 0
    assert mobo("verify", bag, "--workers", 1) == 0
    assert mobo("report", bag, "-o", tmp_path / "report") == 0


def test_any_urdf_may_slide(tmp_path: Path) -> None:
    """A found arm's slide gets the radius that the file or the caller says."""
    path = tmp_path / "arm.urdf"
    path.write_text(random_arm(2, slides=(1, 6)).replace('<slide radius="0.12"/>', ""))
    read = read_arm(path, "flange", slide_radius=0.3)
    chain = chain_from_urdf(read.urdf, read.tip)
    assert chain.slide.tolist() == [0.02, 0, 0, 0, 0, 0.3]
    assert ["turn6" in note for note in read.notes if "pinion of" in note] == [True]
