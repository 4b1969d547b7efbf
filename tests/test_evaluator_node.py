"""A live evaluator among others: bad candidates, evaluators that are unable, a replay."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from nodes import Nodes, finish, output
from peer import Peer

from mobo_core.bag.collector import read_study
from mobo_core.design import Design, DesignSpace, to_urdf
from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.evaluation.spec_message import spec_to_message
from mobo_core.messages import Candidate, Evaluation

pytestmark = [pytest.mark.ros, pytest.mark.timeout(180)]

SPEC = EvaluationSpec(poses_per_voxel=2, restarts=1, iterations=20)
URDF = to_urdf(Design("YPPYPY", (0.05, 0.25, 0.2, 0.05, 0.0, 0.05)), DesignSpace())


def _candidate(trial: int, evaluator: str, **fields: Any) -> Any:
    base = {"study": "t", "trial": trial, "attempt": 1, "evaluator": evaluator, "urdf": URDF, "tip": "tool"}
    return Candidate(**{**base, "spec": spec_to_message(SPEC), **fields})


def test_bad_candidates_are_rejected_with_the_reason_and_the_evaluator_lives(nodes: Nodes, peer: Peer) -> None:
    evaluator = nodes.start("evaluator", remap="__node:=e1", workers=1)
    peer.until(lambda: "evaluators" in peer.heard, "the evaluator's heartbeat")
    bad_spec = spec_to_message(SPEC)
    bad_spec.voxel_size = math.nan
    huge_spec = spec_to_message(SPEC)
    huge_spec.voxel_size = 1e-3
    bad = {
        "truncated": (_candidate(0, "e1", urdf=URDF[:700]), "not well-formed"),
        "bomb": (_candidate(1, "e1", urdf='<!DOCTYPE r [<!ENTITY a "aa">]><robot name="&a;"/>'), "forbidden XML"),
        "mass": (_candidate(2, "e1", urdf=URDF.replace('mass value="', 'mass value="-', 1)), "more than 0"),
        "tip": (_candidate(3, "e1", tip="hand"), "no link 'hand'"),
        "nan": (_candidate(4, "e1", spec=bad_spec), "voxel_size"),
        "many": (_candidate(5, "e1", spec=huge_spec), "voxels"),
        "closed loop": (_candidate(6, "e1", urdf=URDF.replace('link="link_3"', 'link="link_2"')), "loop"),
        "large": (_candidate(7, "e1", urdf=" " * 3_000_000), "bytes"),
        "empty": (_candidate(8, "e1", urdf=""), "urdf"),
    }
    for candidate, _ in bad.values():
        peer.send("candidates", candidate)
    peer.send("candidates", b"\x00\x01\x00\x00garbage")
    peer.send("candidates", _candidate(20, "someone_else"))
    peer.send("candidates", _candidate(21, "e1"))
    heard = peer.heard.setdefault("evaluations", [])
    peer.until(lambda: any(answer.trial == 21 for answer in heard), "the good candidate's answer")
    answers = {int(answer.trial): answer for answer in heard}
    kinds = Evaluation
    for number, (_, reason) in enumerate(bad.values()):
        assert answers[number].status == kinds.REJECTED
        assert reason in answers[number].reason and "\n" not in answers[number].reason
    assert 20 not in answers
    assert answers[21].status == kinds.OK
    assert answers[21].audit_poses > 0
    assert evaluator.poll() is None, output(evaluator)


def test_replay_plays_every_message_below_replay(nodes: Nodes, peer: Peer, tmp_path: Path) -> None:
    from std_msgs.msg import String

    import mobo_msgs.msg

    bag = tmp_path / "bag"
    assert finish(nodes.study(bag, n_trials=8, sampler="random")) == 0
    for topic, kind in (("candidates", "Candidate"), ("evaluations", "Evaluation"), ("trials", "Trial")):
        peer.hear(f"replay/{topic}", kind, getattr(mobo_msgs.msg, kind), latched=True)
    arms: list[str] = []
    peer.node.create_subscription(String, "replay/robot_description", lambda message: arms.append(message.data), 100)
    replay = nodes.start("replay", bag=bag, rate=0.3)
    peer.until(lambda: len(peer.heard.get("replay/trials", [])) == 8, "8 trials")
    assert finish(replay) == 0, output(replay)
    study = read_study(bag)
    assert len(peer.heard["replay/candidates"]) == len(study.candidates)
    assert len(peer.heard["replay/evaluations"]) == len(study.evaluations)
    peer.until(lambda: arms, "an arm to show")
    assert arms[-1] in {candidate.urdf for candidate in study.candidates}


def test_evaluators_that_are_unable_fail_no_trial(nodes: Nodes, tmp_path: Path) -> None:
    bag, spec = tmp_path / "bag", tmp_path / "complete.yaml"
    spec.write_text("{poses_per_voxel: 1, ik_mode: complete, restarts: 4, iterations: 8}")
    nodes.start("evaluator", remap="__node:=a_reference", workers=2, engine="reference")
    nodes.start("evaluator", remap="__node:=b_kernel", workers=1)
    optimizer = nodes.optimizer(bag, n_trials=8, sampler="random", spec=spec)
    assert finish(optimizer) == 0, output(optimizer)
    study = read_study(bag)
    assert len(study.complete_trials()) == 8
    assert {trial.evaluator for trial in study.trials.values()} == {"b_kernel"}
