"""The URDF of a design."""

from __future__ import annotations

import io
import math
import os
import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest
import yourdfpy
from arms import LENGTHS, arm
from hypothesis import given, settings
from hypothesis import strategies as st

from mobo_core.design import Design, DesignSpace, description, to_urdf
from mobo_core.errors import StudyError
from mobo_core.resources import xacro_folder

NAMES = sorted(LENGTHS)
TOTAL = 0.6
AXES = {"R": (1, 0, 0), "P": (0, 1, 0), "Y": (0, 0, 1)}


def tool_of(model: pin.Model, q: np.ndarray) -> pin.SE3:
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    return data.oMf[model.getFrameId("tool", pin.BODY)]


@pytest.mark.parametrize("joints", NAMES)
def test_pinocchio_reads_it(joints: str) -> None:
    """In Pinocchio the arm has one revolute joint a letter, about x, y or z, and its tool straight up."""
    model = pin.buildModelFromXML(arm(joints))
    assert list(model.names)[1:] == [f"joint_{i}" for i in range(1, len(joints) + 1)]
    tool = tool_of(model, np.zeros(model.nq))
    assert tool.translation == pytest.approx([0, 0, TOTAL], abs=1e-15)
    assert np.array_equal(tool.rotation, np.eye(3))
    data = model.createData()
    jacobian = pin.computeJointJacobians(model, data, np.zeros(model.nq))
    assert [tuple(column) for column in jacobian[3:].T] == [AXES[joint] for joint in joints]


@pytest.mark.parametrize("joints", NAMES)
def test_yourdfpy_reads_it(joints: str) -> None:
    """In yourdfpy the arm has the same joints and limits, and its tool straight up."""
    robot = yourdfpy.URDF.load(io.StringIO(arm(joints)), load_meshes=False, build_collision_scene_graph=False)
    assert list(robot.actuated_joint_names) == [f"joint_{i}" for i in range(1, len(joints) + 1)]
    assert robot.base_link == "base_link"
    assert robot.validate()
    robot.update_cfg(np.zeros(len(joints)))
    assert robot.get_transform("tool") == pytest.approx(
        np.block([[np.eye(3), np.array([[0], [0], [TOTAL]])], [0, 0, 0, 1]]), abs=1e-12
    )


@pytest.mark.parametrize("joints", NAMES)
def test_check_urdf_passes_it(joints: str, tmp_path: Path) -> None:
    """The check_urdf of urdfdom finds one chain from base_link to tool."""
    tool = shutil.which("check_urdf", path=f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    if tool is None:
        pytest.skip("no check_urdf")
    path = tmp_path / "arm.urdf"
    path.write_text(arm(joints))
    checked = subprocess.run([tool, str(path)], capture_output=True, text=True, timeout=300)
    assert checked.returncode == 0, checked.stderr
    assert "root Link: base_link has 1 child(ren)" in checked.stdout
    assert checked.stdout.count("child(1):") == len(joints) + 1
    assert checked.stdout.rstrip().endswith("tool")


@given(st.text("RPY", min_size=1, max_size=8), st.data())
@settings(max_examples=20, deadline=None)
def test_masses_and_limits(order: str, data: st.DataObject) -> None:
    """Link i weighs motor + pi r^2 L rho, its centre and inertia are those of a ball and a rod, limits as set."""
    length = st.sampled_from([0.0, 1e-9]) | st.floats(1e-3, 0.5)
    lengths = data.draw(st.lists(length, min_size=len(order), max_size=len(order)))
    space = DesignSpace(joint_limit=2.0, motor_mass=0.7, link_radius=0.02, link_density=900)
    model = pin.buildModelFromXML(to_urdf(Design(order, tuple(lengths)), space))
    assert np.array_equal(model.lowerPositionLimit, np.full(len(order), -2.0))
    assert np.array_equal(model.upperPositionLimit, np.full(len(order), 2.0))
    for i, length in enumerate(lengths, start=1):
        rod = math.pi * 0.02**2 * length * 900
        ball = 0.4 * 0.7 * 0.02**2
        whole = pin.Inertia(0.7, np.zeros(3), ball * np.eye(3))
        if rod:
            whole += pin.Inertia.FromCylinder(rod, 0.02, length).se3Action(
                pin.SE3(np.eye(3), np.array([0, 0, length / 2]))
            )
        found = model.inertias[i]
        assert found.mass == pytest.approx(0.7 + rod, rel=1e-14)
        assert found.lever == pytest.approx(whole.lever, abs=1e-15)
        assert found.inertia == pytest.approx(whole.inertia, rel=1e-9, abs=1e-15)


def test_default_masses_are_the_papers() -> None:
    """By default a motor weighs 0.5 kg, links 0.706858 kg a metre, and limits are 135 degrees either way."""
    model = pin.buildModelFromXML(arm("PRRYPY"))
    assert pin.computeTotalMass(model) == pytest.approx(6 * 0.5 + math.pi * 0.015**2 * 1000 * TOTAL, rel=1e-12)
    assert np.degrees(model.upperPositionLimit) == pytest.approx([135] * 6)


def test_every_link_of_some_length_has_one_capsule_and_none_of_no_length() -> None:
    """A collision cylinder runs from a joint to the next; links of no length have none."""
    lengths = LENGTHS["PRRYPY"]
    robot = ElementTree.fromstring(arm("PRRYPY"))
    for i, length in enumerate(lengths, start=1):
        collisions = robot.findall(f"link[@name='link_{i}']/collision")
        if length == 0:
            assert collisions == []
            continue
        (collision,) = collisions
        cylinder, origin = collision.find("geometry/cylinder"), collision.find("origin")
        assert cylinder is not None
        assert origin is not None
        assert (float(cylinder.get("length", "")), float(cylinder.get("radius", ""))) == (length, 0.015)
        assert [float(v) for v in origin.get("xyz", "").split()] == [0, 0, length / 2]
        assert origin.get("rpy") == "0 0 0"
    assert len(robot.findall(".//collision")) == 4


def test_same_text_from_any_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The text is the same on every call and from every working directory, and names no place on this machine."""
    text = arm("PRRYPY")
    monkeypatch.chdir(tmp_path)
    assert arm("PRRYPY") == text
    assert arm("YPPYPY") != text
    assert arm("PRRYPY") == text
    assert str(xacro_folder()) not in text
    assert "xacro" not in text


def test_macros_in_a_folder_with_an_odd_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """mobo may be installed below a folder whose name means something in XML."""
    text = arm("PRRYPY")
    folder = tmp_path / "R&D <x> \"y\" 'z'"
    shutil.copytree(xacro_folder(), folder)
    monkeypatch.setattr(description, "xacro_folder", lambda: folder)
    assert arm("PRRYPY") == text


def test_missing_macros_are_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without its macros the description fails with an error of mobo's that names the arm, exit code 1."""
    monkeypatch.setattr(description, "xacro_folder", lambda: tmp_path)
    with pytest.raises(StudyError, match="xacro of PRRYPY") as error:
        arm("PRRYPY")
    assert error.value.exit_code == 1


def test_text_is_that_of_the_effective_order() -> None:
    """Designs that the yaw rule makes equal have the same text."""
    lengths = LENGTHS["YPPYPY"]
    assert arm("YRPYRY", lengths) == arm("YPPYPY", lengths)


@pytest.mark.parametrize(("letter", "axis"), [("R", 0), ("P", 1), ("Y", 2)])
def test_positive_turns_are_right_handed(letter: str, axis: int) -> None:
    """A positive angle turns the rest of the arm right-handed about the joint's axis."""
    model = pin.buildModelFromXML(to_urdf(Design(letter, (0.6,)), DesignSpace()))
    turned = tool_of(model, np.array([0.3]))
    expected = pin.exp3(0.3 * np.eye(3)[axis])
    assert turned.rotation == pytest.approx(expected, abs=1e-15)
    assert turned.translation == pytest.approx(expected @ [0, 0, 0.6], abs=1e-15)


def test_the_longest_arm_allowed() -> None:
    """An arm of 64 joints is described too."""
    model = pin.buildModelFromXML(to_urdf(Design("RPY" * 21 + "R", (0.01,) * 64), DesignSpace()))
    assert model.nq == 64
