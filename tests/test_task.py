"""What a spec may ask beyond the paper's question: a tool."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from arms import KernelView, WholeRobot, arm, random_arm, small_spec
from hypothesis import given
from hypothesis import strategies as st

from mobo_core.design import DesignSpace
from mobo_core.evaluation import EvaluationSpec
from mobo_core.evaluation.chain import asked_chain
from mobo_core.evaluation.evaluate import evaluate
from mobo_core.evaluation.matrices import rpy_matrix
from mobo_core.evaluation.reference import ReferenceModel
from mobo_core.evaluation.spec_message import spec_from_message, spec_to_message
from mobo_core.evaluation.wording import further_asked
from mobo_core.messages import decode, encode
from mobo_core.messages.types import SpecMessage
from mobo_core.search.mirror import exact_twins

TOOL: dict[str, Any] = {
    "tool_xyz": (0.03, -0.02, 0.11), "tool_rpy": (0.4, -0.7, 1.9), "payload_kg": 1.3, "payload_com": (0.01, 0.04, -0.05)
}  # fmt: skip


def with_tool(urdf: str, flange: str, values: dict[str, Any]) -> str:
    """Return a URDF with a link ``hook`` on its flange and the payload as a body of that, as spec fields say."""
    xyz, rpy, com = (" ".join(map(repr, values[name])) for name in ("tool_xyz", "tool_rpy", "payload_com"))
    return urdf.replace("</robot>", (
        f'<link name="hook"/><joint name="hold" type="fixed"><parent link="{flange}"/>'
        f'<child link="hook"/><origin xyz="{xyz}" rpy="{rpy}"/></joint>'
        f'<link name="load"><inertial><origin xyz="{com}"/>'
        f'<mass value="{values["payload_kg"]!r}"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
        '</inertial></link><joint name="grip" type="fixed"><parent link="hook"/><child link="load"/></joint></robot>'
    ))  # fmt: skip


@given(st.tuples(*[st.floats(-6.0, 6.0)] * 3))
def test_rotations_by_roll_pitch_yaw_are_pinocchios(rpy: tuple[float, float, float]) -> None:
    """Roll, pitch and yaw turn as Pinocchio has them."""
    assert np.abs(np.array(rpy_matrix(rpy)) - pin.rpy.rpyToMatrix(*rpy)).max() < 1e-15


@pytest.mark.parametrize("seed", range(6))
def test_tool_and_payload_are_pinocchios(seed: int) -> None:
    """Pose of the tool and torque, by kernel and reference, are Pinocchio's of an arm with tool and load as links."""
    rng, urdf = np.random.default_rng(seed), random_arm(seed)
    values: dict[str, Any] = {name: tuple(rng.uniform(-3, 3, 3).tolist()) for name in TOOL} | {"payload_kg": 0.5 + seed}
    chain = asked_chain(urdf, "flange", EvaluationSpec.of(values))
    whole, reference = WholeRobot(with_tool(urdf, "flange", values)), ReferenceModel(chain)
    q = rng.uniform(chain.lower, chain.upper)
    expected, view = whole.tip(chain.joint_names, q, "hook"), KernelView(chain, q)
    assert np.abs(view.tip[:3] - expected.rotation).max() < 1e-12
    assert np.abs(view.tip[3] - expected.translation).max() < 1e-12
    assert np.abs(reference.tip(q).homogeneous - expected.homogeneous).max() < 1e-12
    torque = whole.torque(chain.joint_names, q)
    assert np.abs(view.torque() - torque).max() < 1e-10
    assert np.abs(reference.torque(q) - torque).max() < 1e-10


def test_an_arm_with_a_tool_is_the_arm_that_has_it_as_a_link() -> None:
    """Both evaluate alike; the audit agrees, and so does the reference engine."""
    urdf = arm("PRRYPY")
    tip = asked_chain(urdf, "", EvaluationSpec()).tip
    asked = evaluate(urdf, small_spec(**TOOL), audit_poses=20)
    built = evaluate(with_tool(urdf, tip, TOOL), small_spec(), tip="hook")
    assert (asked.audit_fault, asked.audit_poses) == ("", 20)
    assert asked.audit_max_error < 1e-9
    assert asked.reach == pytest.approx(built.reach, abs=0.11)
    assert asked.torque == pytest.approx(built.torque, rel=0.02)
    assert abs(asked.reach - evaluate(urdf, small_spec()).reach) > 0.5
    few = small_spec(**TOOL, poses_per_voxel=1, restarts=1)
    fast, reference = (evaluate(urdf, few, engine=engine) for engine in ("kernel", "reference"))
    assert (fast.reach, fast.attempts) == (reference.reach, reference.attempts)
    assert fast.torque == pytest.approx(reference.torque, abs=1e-6)


def test_what_older_versions_could_ask_is_written_as_they_wrote_it() -> None:
    """Later fields are written where they ask for something, and come back; a message holds them in any case."""
    assert "tool_xyz" not in json.loads(EvaluationSpec(seed=3).to_json())
    spec = EvaluationSpec.of(TOOL)
    assert EvaluationSpec.of(json.loads(spec.to_json())) == spec
    assert spec_from_message(decode(SpecMessage, encode(spec_to_message(spec)))) == spec


def test_words_on_what_is_asked() -> None:
    """Tool and payload are told in words, and nothing where there is neither."""
    assert further_asked(EvaluationSpec()) == []
    assert further_asked(EvaluationSpec.of(TOOL)) == [
        "payload 1.3 kg with its centre at 0.01 0.04 -0.05 m in the tool's frame",
        "tool at 0.03 -0.02 0.11 m from the tip, turned by 22.92 -40.11 108.9°",
    ]


def test_a_lateral_tool_has_no_mirror_twin() -> None:
    """Arms with a tool beside their axis are not each other's reflection; with one along it they are."""
    orders, space = ("PRRYPY", "RPPYRP", "RPPYPY", "RPRPRP", "PRPRPR"), DesignSpace()
    twins = exact_twins(orders, space, EvaluationSpec())
    assert twins
    assert exact_twins(orders, space, EvaluationSpec(tool_xyz=(0.0, 0.0, 0.1))) == twins
    assert exact_twins(orders, space, EvaluationSpec(tool_xyz=(0.1, 0.0, 0.0))) == {}
    assert exact_twins(orders, space, EvaluationSpec(tool_rpy=(0.1, 0.0, 0.0))) == {}
