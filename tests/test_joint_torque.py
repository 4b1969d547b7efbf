"""What each joint has to hold: against Pinocchio, to the bit in any chunks, in mobo evaluate."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from arms import HANDED_ARM, LENGTHS, arm, small_spec
from studies import mobo, mobo_json

from mobo_core.evaluation import EvaluationSpec
from mobo_core.evaluation import evaluate as evaluate_module
from mobo_core.evaluation.chain import chain_from_urdf
from mobo_core.evaluation.evaluate import evaluate
from mobo_core.evaluation.reference import ReferenceModel

ARM = ("--joints", "YPPYPY", "--lengths", "0.05,0.25,0.2,0.05,0,0.05")
FAR = "workspace_min: [1.0, 1.0, 1.0]\nworkspace_max: [1.2, 1.2, 1.2]\n"


@pytest.mark.parametrize("joints", sorted(LENGTHS))
def test_values_are_those_of_pinocchio(joints: str) -> None:
    """Mean and peak exactly, the 95 % from above by 0.1 % at most, over all accepted configurations."""
    spec = small_spec(payload_kg=0.7, gravity=(1.0, 2.0, -9.0), poses_per_voxel=30)
    result = evaluate(arm(joints), spec, joint_torques=True, configurations=True)
    found = result.configurations
    assert found is not None and result.joint_torques is not None and len(found.q) > 20
    model = ReferenceModel(chain_from_urdf(arm(joints), payload_kg=0.7, gravity=spec.gravity))
    torques = np.abs([model.torque(q) for q in found.q])
    assert [joint.joint for joint in result.joint_torques] == list(result.joints)
    for joint, values in zip(result.joint_torques, torques.T, strict=True):
        assert joint.mean == pytest.approx(values.mean(), rel=1e-9, abs=1e-12)
        assert joint.peak == pytest.approx(values.max(), rel=1e-9, abs=1e-12)
        exact = np.sort(values)[math.ceil(0.95 * len(values)) - 1]
        assert exact * (1 - 1e-9) - 1e-12 <= joint.p95 <= exact * (1 + 1.01 * 2**-10) + 1e-12
        assert joint.p95 <= joint.peak
    assert result.mean_torque == evaluate(arm(joints), spec, objectives=["mean_torque"]).extra["mean_torque"]


@pytest.mark.parametrize(("urdf", "tip"), [(arm("PRRYPY"), ""), (HANDED_ARM, "tcp")])
def test_bits_do_not_depend_on_chunks_or_threads(urdf: str, tip: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """All values are the same in chunks of any size, with any number of threads."""
    spec = EvaluationSpec()
    expected = evaluate(urdf, spec, tip=tip, joint_torques=True).joint_torques
    assert expected and all(joint.peak >= joint.p95 for joint in expected)
    assert evaluate(urdf, spec, tip=tip, joint_torques=True, threads=2).joint_torques == expected
    for chunk in (1, 100, 30 * 74):
        monkeypatch.setattr(evaluate_module, "_CHUNK_POSES", chunk)
        assert evaluate(urdf, spec, tip=tip, joint_torques=True).joint_torques == expected, chunk


def test_no_torque_is_measured_that_is_not_asked_for() -> None:
    """A result has none unless it was asked for them, and no key in its JSON."""
    result = evaluate(arm("PRRYPY"), small_spec())
    assert result.joint_torques is None and "joint_torque" not in result.to_dict()


def test_evaluate_prints_a_line_for_each_joint(capsys: pytest.CaptureFixture[str]) -> None:
    """The numbers of --json, rounded; torque per reached voxel beside the sum."""
    found = mobo_json(capsys, "evaluate", *ARM, "--json")
    assert [list(joint) for joint in found["joint_torque"]] == [["joint", "mean", "p95", "peak"]] * 6
    assert [joint["joint"] for joint in found["joint_torque"]] == found["joints"]
    reached = [t for t, r in zip(found["voxel_torque"], found["voxel_reach"], strict=True) if r > 0]
    assert found["mean_torque"] == pytest.approx(sum(reached) / len(reached), rel=1e-12)
    assert mobo("evaluate", *ARM) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[1].endswith(f"; {found['mean_torque']:.2f} N m a reached voxel")
    numbers = [[f"{joint[name]:.2f}" for name in ("mean", "p95", "peak")] for joint in found["joint_torque"]]
    assert [line.split() for line in lines[-6:]] == [
        [name, *values] for name, values in zip(found["joints"], numbers, strict=True)
    ]


def test_an_arm_that_reaches_nothing_holds_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """JSON has null for what is no number; the table is left out."""
    (tmp_path / "far.yaml").write_text(FAR)
    found = mobo_json(capsys, "evaluate", *ARM, "--spec", tmp_path / "far.yaml", "--json")
    assert found["reach"] == 0 and found["mean_torque"] is None
    assert {joint[name] for joint in found["joint_torque"] for name in ("mean", "p95", "peak")} == {None}
    assert mobo("evaluate", *ARM, "--spec", tmp_path / "far.yaml") == 0
    assert "joint " not in capsys.readouterr().out.replace("joint_", "")
