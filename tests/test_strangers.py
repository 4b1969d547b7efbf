"""An optimizer among strangers: floods of answers nobody asked for, heartbeats that no evaluator sends."""

from __future__ import annotations

import math
import re
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from nodes import QUICK_SPEC, Nodes, output, values, wait_for
from peer import Peer
from studies import run_study

from mobo_core.bag.collector import read_study
from mobo_core.coordination.answer import Answering
from mobo_core.messages import Evaluation, EvaluatorStatus, decode, encode

pytestmark = pytest.mark.ros

N = 12
SETTINGS = {"spec": yaml.safe_load(QUICK_SPEC), "n_startup_trials": 5, "sampler": "structured"}  # as nodes have it
BURST = 1000  # as much as the optimizer's reader keeps


def noise(candidate: Any, kind: int) -> bytes:
    """Return an answer that must not be used, made from a true one to ``candidate``."""
    answer = Answering("ghost", "simulated", simulated_s=0.0).answer(candidate)
    match kind % 8:
        case 0:
            answer.study = "another"
        case 1:
            answer.trial = 4_000_000_000
        case 2:
            pass  # sound, but never sent to this one
        case 3:
            answer.evaluator, answer.attempt = candidate.evaluator, 4_000_000_000
        case 4:
            answer.evaluator, answer.reach = candidate.evaluator, math.nan
            answer.attempt = 77
        case 5:
            answer.voxel_reach = np.zeros(3)
        case 6:
            return encode(answer)[: 30 + kind % 400]
        case 7:
            return b"\x00\x01\x00\x00" + bytes(np.random.default_rng(kind).integers(0, 256, kind % 300, np.uint8))
    return encode(answer)


def absurd_heartbeats() -> list[bytes]:
    """Return heartbeats that no evaluator sends."""
    held = 1_000_000
    many = {"studies": ["s"], "trials": np.arange(held), "attempts": np.ones(held, np.uint32)}
    fields: list[dict[str, Any]] = [
        {"evaluator": "x" * 1_000_000, "workers": 1},
        {"evaluator": "", "workers": 1},
        {"evaluator": "a\nb\x1b[31m", "workers": 1},
        {"evaluator": "greedy", "workers": 2**31},
        {"evaluator": "none", "workers": 0},
        {"evaluator": "many", "workers": 1, **many},
        {"evaluator": "odd", "workers": 1, "studies": ["s", "s"], "trials": [1], "attempts": [1, 2, 3]},
        {"evaluator": "state", "workers": 1, "state": 250},
    ]
    return [encode(EvaluatorStatus(**{"engine": "simulated", **values})) for values in fields]


def test_a_flood_of_noise_changes_nothing(nodes: Nodes, peer: Peer, tmp_path: Path) -> None:
    """3,000 answers in bursts, absurd heartbeats and rubbish: counted, hardly recorded, one line a second."""
    check_flood(nodes, peer, tmp_path, bursts=3)


def check_flood(nodes: Nodes, peer: Peer, tmp_path: Path, bursts: int) -> None:
    quiet = run_study(tmp_path / "quiet", N, name="s", settings=SETTINGS)
    bag = tmp_path / "bag"
    import mobo_msgs.msg

    peer.hear("study", "StudyStatus", mobo_msgs.msg.StudyStatus, latched=True)
    began = time.monotonic()
    optimizer = nodes.optimizer(bag, n_trials=N, n_startup_trials=5)
    status = peer.until(lambda: peer.heard.get("study"), "the optimizer")[-1]
    assert status.told == 0
    peer.until(lambda: peer.is_heard_on("evaluations") and peer.is_heard_on("evaluators"), "it to hear the peer")
    # The trials in flight are open, and nobody has been sent any: nothing can be a true answer.
    true = read_study(quiet).candidates
    messages = [noise(true[kind % len(true)], kind) for kind in range(400)]
    for burst in range(bursts):
        for i in range(BURST):
            peer.send("evaluations", messages[i % len(messages)])
        for heartbeat in absurd_heartbeats() if burst in (0, bursts - 1) else []:
            peer.send("evaluators", heartbeat)
        received = status.answers + (burst + 1) * BURST * 0.9
        peer.until(lambda received=received: peer.heard["study"][-1].answers >= received, f"{received} answers")
    status = peer.heard["study"][-1]
    assert (status.told, status.asked, status.evaluators) == (0, 8, 0)
    assert status.answers_unused == status.answers
    # Now true ones come; each is repeated, cut, and sent again with other numbers.
    nodes.start("evaluator", remap="__node:=e1", workers=1, engine="simulated", simulated_s=0.2)
    seen = 0

    def echo() -> bool:
        nonlocal seen
        answers = [e for e in read_study(bag).evaluations if e.evaluator == "e1" and e.attempt == 1]
        for answer in answers[seen : seen + 1]:
            seen += 1
            for _ in range(20):
                peer.send("evaluations", answer)
            changed = decode(Evaluation, encode(answer))
            changed.reach, changed.torque = 0.0, 0.0
            peer.send("evaluations", changed)
        return optimizer.poll() is not None

    wait_for(echo, "the study to end")
    seconds = time.monotonic() - began
    assert optimizer.returncode == 0, output(optimizer)
    assert seen > 0
    assert values(bag) == values(quiet)
    study = read_study(bag)
    assert len(study.evaluations) <= N * (16 + 1)
    joined = {e.evaluator for e in study.evaluators if e.state == EvaluatorStatus.JOINED}
    assert joined == {"e1"}
    lines = output(optimizer).splitlines()
    assert sum("ignored" in line for line in lines) <= seconds + 2
    assert any(re.search(r"answer ignored: trial \d+ of study", line) or "not readable" in line for line in lines)
    assert max(map(len, lines)) < 1000
