"""What joints have to hold: against Pinocchio; motors, and the payload that they leave."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from arms import HANDED_ARM, arm, small_spec
from studies import mobo, mobo_json

from mobo_core.arms.motors import Motor, Motors
from mobo_core.arms.size import lightest, over_most, payloads, size
from mobo_core.design import Design, DesignSpace, to_urdf
from mobo_core.errors import InputError, StudyError
from mobo_core.evaluation.chain import chain_from_urdf

LENGTHS = (0.05, 0.25, 0.2, 0.05, 0.0, 0.05)
ARM = ("--joints", "YPPYPY", "--lengths", "0.05,0.25,0.2,0.05,0,0.05")
FILE = Path(__file__).resolve().parents[1] / "examples" / "motors.yaml"


def _pinocchio(urdf: str, tip: str, payload: float, q: np.ndarray) -> np.ndarray:
    """Return the torques (m, n) that hold a payload, by Pinocchio: the model's own and J^T of its weight."""
    chain = chain_from_urdf(urdf, tip)
    model, data = chain.model, chain.model.createData()
    found = []
    for row in q:
        own = pin.computeGeneralizedGravity(model, data, row)
        jacobian = pin.computeFrameJacobian(model, data, row, chain.tip_frame, pin.LOCAL_WORLD_ALIGNED)
        found.append(own - jacobian[:3].T @ (payload * np.array([0, 0, -9.81])))
    return np.array(found)


@pytest.mark.parametrize(("urdf", "tip"), [(arm("PRRYPY"), ""), (HANDED_ARM, "tcp")])
def test_torques_are_those_of_pinocchio(urdf: str, tip: str) -> None:
    """Median, 95 % and peak at the same configurations to 1e-9; the peak is where it is said to be."""
    found = size(urdf, small_spec(poses_per_voxel=30), 1.3, tip=tip)
    configurations = found.result.configurations
    assert configurations is not None and len(configurations.q) > 20
    torque = np.abs(_pinocchio(urdf, tip, 1.3, configurations.q))
    assert [one.peak for one in found.joints] == pytest.approx(torque.max(axis=0).tolist(), abs=1e-9)
    assert [one.median for one in found.joints] == pytest.approx(np.median(torque, axis=0).tolist(), abs=1e-9)
    assert [one.p95 for one in found.joints] == pytest.approx(np.percentile(torque, 95, axis=0).tolist(), abs=1e-9)
    for i, one in enumerate(found.joints):
        assert np.abs(_pinocchio(urdf, tip, 1.3, one.q[None]))[0, i] == pytest.approx(one.peak, abs=1e-9)
    assert found.payload == np.inf and all(one.motor is None for one in found.joints)


def test_the_largest_payload_is_held_and_no_more() -> None:
    """By Pinocchio, at that payload every motor holds 99 % of the poses, and at a little more it does not."""
    urdf = arm("PRRYPY")
    motors = Motors.of([{"name": "a", "torque": 9, "mass": 0.3}, {"name": "b", "torque": 3, "mass": 0.1}])
    named = motors.model_copy(update={"joints": ("a", "a", "a", "b", "b", "b")})
    found = size(urdf, small_spec(poses_per_voxel=30), 0.0, motors=named, use=0.9)
    assert found.result.configurations is not None and 0 < found.payload < np.inf
    q, holds = found.result.configurations.q, 0.9 * np.array([9, 9, 9, 3, 3, 3])

    def share(payload: float) -> float:
        return float((np.abs(_pinocchio(urdf, "", payload, q)) <= holds + 1e-9).all(axis=1).mean())

    assert share(found.payload) >= 0.99 > share(found.payload + 1e-4)
    voxel = int(np.nanargmin(found.voxel_payload))
    there = q[found.result.configurations.voxel == voxel]
    held = np.abs(_pinocchio(urdf, "", found.voxel_payload[voxel], there))
    assert (held <= holds + 1e-9).all() and (held > holds - 1e-6).any()
    assert np.isnan(found.voxel_payload[found.result.voxel_reach == 0]).all()
    assert found.payload <= min(one.payload for one in found.joints)


def test_chosen_motors_hold_with_their_own_masses() -> None:
    """With motors in place of the arm's own, torques are those of the design with these masses, and all are held."""
    motors, space = Motors.from_yaml(FILE), DesignSpace()
    urdf = to_urdf(Design("YPPYPY", LENGTHS), space)
    found = size(urdf, small_spec(), 0.5, motors=motors, own_motors=(0.5,) * 6, use=0.5)
    chosen = [one.motor for one in found.joints]
    assert all(motor is not None and one.peak <= one.holds for motor, one in zip(chosen, found.joints, strict=True))
    assert found.payload >= 0.5 and found.result.configurations is not None
    made = to_urdf(Design("YPPYPY", LENGTHS), DesignSpace(motor_mass=tuple(motor.mass for motor in chosen if motor)))
    torque = np.abs(_pinocchio(made, "", 0.5, found.result.configurations.q))
    assert [one.peak for one in found.joints] == pytest.approx(torque.max(axis=0).tolist(), abs=1e-9)
    stays = size(urdf, small_spec(), 0.5, motors=motors, use=0.5)
    assert stays.joints[1].peak == pytest.approx(size(urdf, small_spec(), 0.5).joints[1].peak, abs=1e-9)
    with pytest.raises(InputError, match="joint 1 carries"):
        size(urdf, small_spec(), 0.5, motors=motors, own_motors=(5.0,) * 6)


def test_rules_of_choice_and_of_payload() -> None:
    """The lightest that holds, or the strongest; a payload that first balances; joints that feel none."""
    small, large, light = (Motor(name=n, torque=t, mass=m) for n, t, m in (("s", 1, 1), ("l", 5, 3), ("m", 2, 0.5)))
    assert lightest((small, large, light), 0.9) is light and lightest((small, large, light), 9.0) is large
    holds = np.array([2.0])
    cases = [(1.0, 1.0, 1.0), (-1.0, 1.0, 3.0), (1.0, -0.5, 6.0), (1.0, 0.0, np.inf), (3.0, -1.0, -np.inf)]
    for empty, per_kg, most in cases:
        assert payloads(np.array([[empty]]), np.array([[per_kg]]), holds)[0, 0] == most
    assert over_most(np.arange(200.0)) == 2.0 and over_most(np.array([7.0])) == 7.0


def test_the_example_has_ten_servos_with_sources() -> None:
    """Each with a source; what that does not show is marked."""
    motors = Motors.from_yaml(FILE).motors
    assert len(motors) == 10 and all(motor.source for motor in motors)
    assert any(motor.unverified for motor in motors)


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Words, JSON and a picture; bad input gets one line, and nothing half-written."""
    spec = tmp_path / "spec.yaml"
    spec.write_text("{ik_mode: complete, rules: 2, iterations: 12, poses_per_voxel: 3}")
    asked = (*ARM, "--payload", "0.4", "--motors", FILE, "--spec", spec)
    assert mobo("size", *asked) == 0
    out = capsys.readouterr().out
    found = mobo_json(capsys, "size", *asked, "--json")
    assert f"payload over 99 % of the reached poses: {found['payload']:.2f} kg" in out
    assert "in place of the arm's own" in out and len(found["voxel_payload"]) == 75 and "z 0.00 m" in out
    assert [joint["motor"]["name"] in out for joint in found["joints"]] == [True] * 6
    assert mobo("size", *asked, "-o", tmp_path / "map.svg") == 0
    assert (tmp_path / "map.svg").read_bytes().startswith(b"<?xml")
    capsys.readouterr()
    bad = tmp_path / "bad.yaml"
    for text in ("[]", "motors: [{name: a}]", "[{name: a, torque: -1, mass: 1}]", "{", "joints: [a]", "[1, 2]"):
        bad.write_text(text)
        assert mobo("size", *ARM, "--motors", bad) == 2
        assert len(capsys.readouterr().err.splitlines()) == 1, text
    bad.write_text("motors: [{name: a, torque: 1, mass: 1}]\njoints: [a, a]")
    for words in (
        (*ARM, "--motors", bad), (*ARM, "--payload", "-1"), (*ARM, "--payload", "nan"), ("UR99",), (),
        (*ARM, "-o", tmp_path / "x.png"), (*asked, "-o", tmp_path / "x.txt"), (*asked, "--motor-mass", "1,2"),
        (*ARM, "--motor-mass", "1"), (*asked, "--use", "0"), (tmp_path / "none.urdf",), (*ARM, "--motors", tmp_path),
        ("ur5", "--set", "a=1"), ("ur5", *ARM),
    ):  # fmt: skip
        assert mobo("size", *words) == 2, words
        assert len(capsys.readouterr().err.splitlines()) == 1, words
    assert not list(tmp_path.glob("x.*"))
    spec.write_text("workspace_min: [1.0, 1.0, 1.0]\nworkspace_max: [1.2, 1.2, 1.2]\n")
    assert mobo("size", *ARM, "--spec", spec) == 1
    assert "reaches none" in capsys.readouterr().err
    with pytest.raises(StudyError):
        size(arm("PRRYPY"), small_spec(workspace_min=(3, 3, 3), workspace_max=(3.3, 3.3, 3.3)), 0.0)
