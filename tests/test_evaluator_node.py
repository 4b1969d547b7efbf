"""Evaluators that are unable, and a replay, among others."""

from __future__ import annotations

from pathlib import Path

import pytest
from nodes import Nodes, finish, output
from peer import Peer
from studies import run_study

from mobo_core.bag.collector import read_study

pytestmark = pytest.mark.ros

def test_replay_plays_every_message_below_replay(nodes: Nodes, peer: Peer, tmp_path: Path) -> None:
    from std_msgs.msg import String

    import mobo_msgs.msg

    bag = tmp_path / "bag"
    run_study(bag, 8)
    for topic, kind in (("candidates", "Candidate"), ("evaluations", "Evaluation"), ("trials", "Trial")):
        peer.hear(f"replay/{topic}", kind, getattr(mobo_msgs.msg, kind), latched=True)
    arms: list[str] = []
    peer.node.create_subscription(String, "replay/robot_description", lambda message: arms.append(message.data), 100)
    replay = nodes.start("replay", bag=bag, rate=1.0)
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
