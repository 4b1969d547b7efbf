"""A live evaluator and a live optimizer among strangers: bad candidates, bad answers, a replay."""

from __future__ import annotations

import math
import os
import signal
import time
from pathlib import Path
from typing import Any

import pytest
from nodes import Nodes, children_of, finish, output, told_so_far, values, wait_for
from peer import Peer

from mobo_core.bag.record import read_study
from mobo_core.design import Design, DesignSpace, to_urdf
from mobo_core.evaluation.answer import Answering
from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.messages import make, message_type, spec_to_message

pytestmark = [pytest.mark.ros, pytest.mark.timeout(180)]

SPEC = EvaluationSpec(poses_per_voxel=2, restarts=1, iterations=20)
URDF = to_urdf(Design("YPPYPY", (0.05, 0.25, 0.2, 0.05, 0.0, 0.05)), DesignSpace())


def _candidate(trial: int, evaluator: str, **fields: Any) -> Any:
    base = {"study": "t", "trial": trial, "attempt": 1, "evaluator": evaluator, "urdf": URDF, "tip": "tool"}
    return make("Candidate", **{**base, "spec": spec_to_message(SPEC), **fields})


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
    kinds = message_type("Evaluation")
    for number, (_, reason) in enumerate(bad.values()):
        assert answers[number].status == kinds.REJECTED
        assert reason in answers[number].reason and "\n" not in answers[number].reason
    assert 20 not in answers
    assert answers[21].status == kinds.OK
    assert answers[21].audit_poses > 0
    assert evaluator.poll() is None, output(evaluator)


def test_noise_from_strangers_changes_nothing(nodes: Nodes, peer: Peer, tmp_path: Path) -> None:
    quiet = tmp_path / "quiet"
    slow = {"engine": "simulated", "simulated_s": 0.2}  # so that the noise comes in time
    quietly = nodes.study(quiet, study_name="quiet", n_trials=15, n_startup_trials=5, evaluators=1, **slow)
    assert finish(quietly) == 0
    bag = tmp_path / "bag"
    optimizer = nodes.optimizer(bag, n_trials=15, n_startup_trials=5)
    nodes.start("evaluator", remap="__node:=e1", workers=1, **slow)
    sent: set[int] = set()

    def pester() -> bool:
        for candidate in list(peer.heard.get("candidates", [])):
            trial = int(candidate.trial)
            if trial in sent or candidate.study != "s":
                continue
            sent.add(trial)
            answering = Answering("stranger", "simulated", simulated_s=0.0)
            never_sent = answering.answer(candidate)
            wrong_study = Answering(candidate.evaluator, "simulated", simulated_s=0.0).answer(candidate)
            wrong_study.study = "another"
            not_finite = Answering(candidate.evaluator, "simulated", simulated_s=0.0).answer(candidate)
            not_finite.reach, not_finite.attempt = math.nan, 77
            unknown = Answering(candidate.evaluator, "simulated", simulated_s=0.0).answer(candidate)
            unknown.trial = 4_000_000
            for message in (never_sent, wrong_study, not_finite, unknown, b"\x00\x01\x00\x00\x01"):
                peer.send("evaluations", message)
        return optimizer.poll() is not None

    peer.until(pester, "the study to end")
    assert optimizer.returncode == 0, output(optimizer)
    assert values(bag) == values(quiet)
    assert len(read_study(bag).evaluations) > 15


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


def test_a_candidate_that_kills_its_worker_costs_the_worker_alone(nodes: Nodes, peer: Peer, tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    evaluator = nodes.start("evaluator", workers=1, engine="simulated", simulated_s=1.0)
    optimizer = nodes.optimizer(bag, n_trials=4, in_flight=1, sampler="random")
    wait_for(lambda: len(read_study(bag).candidates) >= 2 if told_so_far(bag) else False, "the second candidate")
    time.sleep(0.3)  # of the second it takes
    (worker,) = children_of(evaluator.pid)
    os.kill(worker, signal.SIGSEGV)
    assert finish(optimizer) == 0, output(optimizer)
    assert evaluator.poll() is None
    failed = [e for e in read_study(bag).evaluations if e.status == message_type("Evaluation").FAILED]
    assert len(failed) == 1 and "signal 11" in failed[0].reason
    assert {int(t.state) for t in read_study(bag).trials.values()} == {message_type("Trial").COMPLETE}


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
