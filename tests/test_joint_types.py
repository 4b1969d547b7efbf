"""Joint types of other distributions, from the space to the report."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from distributions import install
from studies import mobo, run_study

from mobo_core.bag.collector import read_study
from mobo_core.design import JOINTS, Design, DesignSpace, JointType, effective_joints, to_urdf
from mobo_core.design.prepared import PreparedXacro
from mobo_core.errors import InputError

SOURCE = """
from pathlib import Path
from mobo_core.design import JointType

SKEW = JointType("K", "skew", "skew", (0.0, 0.6, 0.8), "#009e73", file=Path(__file__).with_name("skew.xacro"),
                 next_built="R")
"""
MACRO = """
<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <material name="skew"><color rgba="0 0.6 0.45 1"/></material>
  <xacro:macro name="skew" params="index parent offset length">
    <xacro:joint_and_link index="${index}" parent="${parent}" offset="${offset}" length="${length}"
                          axis="0 0.6 0.8" motor_rpy="0 0 0" material="skew"/>
  </xacro:macro>
</robot>
"""
SPACE = {"n_joints": 6, "joint_types": "KP"}


@pytest.fixture
def skew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A distribution with the joint type K."""
    folder = tmp_path / "skewed"
    folder.mkdir()
    (folder / "skew.xacro").write_text(MACRO)
    install(folder, monkeypatch, JOINTS, "skewed", SOURCE, K="SKEW")
    yield


@pytest.mark.slow
def test_a_joint_type_of_another_distribution(skew: None, tmp_path: Path) -> None:
    """A study of arms with it runs, is recorded, verified bit for bit, and reported."""
    assert DesignSpace().joint_types == "RPY" and DesignSpace.of(SPACE).n_orders == 21
    settings = {"space": SPACE, "spec": {"poses_per_voxel": 10, "ik_mode": "complete"}, "sampler": "random"}
    bag = run_study(tmp_path / "bag", 12, settings=settings, engine="kernel")
    study = read_study(bag)
    assert {"K", "P", "R"} == set("".join(candidate.joints for candidate in study.candidates))
    assert sum(trial.reach for trial in study.complete_trials()) > 0
    assert mobo("verify", bag, "--workers", 1) == 0
    assert mobo("report", bag, "-o", tmp_path / "report") == 0
    assert mobo("export", "urdf", "--joints", "kp", "--lengths", "0.3,0.3", "-o", tmp_path / "arm.urdf") == 0


def test_its_rule_and_description(skew: None) -> None:
    """After K comes R, by its rule, and the prepared description is plain xacro's, with its axis."""
    assert effective_joints("KKPK") == "KRPK"
    space = DesignSpace.of(SPACE)
    prepared = PreparedXacro(space)
    for joints in ("KKPKPP", "PPKPPK", "PKKKPP"):
        design = Design(joints, (0.1, 0.2, 0.3, 0.0, 0.0, 0.0))
        assert prepared.to_urdf(design) == to_urdf(design, space)
    assert not prepared.plain


def test_axes_are_those_of_the_macros(skew: None) -> None:
    """The axis of each joint type is the one that its macro writes, and of length 1."""
    for joint in JOINTS.values():
        robot = ElementTree.fromstring(to_urdf(Design(joint.letter, (0.6,)), DesignSpace(n_joints=1)))
        axis = robot.find("joint[@name='joint_1']/axis")
        assert axis is not None
        assert np.array_equal(np.array(axis.get("xyz", "").split(), float), joint.axis)
        assert math.hypot(*joint.axis) == pytest.approx(1.0, abs=1e-15)


def test_without_the_distribution_the_letter_is_unknown() -> None:
    """In one line that says which there are."""
    with pytest.raises(InputError, match=r"unknown joint 'K' at place 1 of 'KP'; expected R \(roll\), P \(pitch\), Y"):
        Design("KP", (0.1, 0.2))


@pytest.mark.parametrize("letter", ["", "RP", "s", "1", "Ä", "."])
def test_letters_are_capitals(letter: str) -> None:
    """Names of orders are made of them, and files are named so."""
    with pytest.raises(ValueError, match="expected a capital, A to Z"):
        JointType(letter, "odd", "roll", (1.0, 0.0, 0.0), "#000000")
