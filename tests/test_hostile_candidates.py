"""A live evaluator and candidates that would crash it, fill its memory or never end."""

from __future__ import annotations

import math
import os
import signal
import time
from pathlib import Path

import pytest
from hostile import answers_to, candidate, hostile_candidates, live_evaluator, mutated_urdfs
from nodes import Nodes, children_of, finish, output, wait_for
from peer import Peer

from mobo_core.bag.collector import read_study
from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.evaluation.spec_message import spec_to_message
from mobo_core.messages import Evaluation, Trial

pytestmark = [pytest.mark.ros, pytest.mark.timeout(240)]

OK, REJECTED, FAILED = (getattr(Evaluation, name) for name in ("OK", "REJECTED", "FAILED"))
ENDLESS = EvaluationSpec(voxel_size=0.1, restarts=1000, iterations=10000, position_tolerance=1e-300)  # for days


def test_mutated_urdfs_and_hostile_specs(nodes: Nodes, peer: Peer) -> None:
    """Each is answered, none costs even the worker, and the next good candidate gets its values."""
    evaluator = live_evaluator(nodes, peer)
    workers = children_of(evaluator.pid)
    check_mutated(peer, 150, seed=1)
    hostile = hostile_candidates("e1")
    for number, answer in answers_to(peer, hostile).items():
        assert answer.status == REJECTED, (hostile[number], answer)
        assert len(answer.reason) <= 2000 and "\n" not in answer.reason
    (good,) = answers_to(peer, [candidate(100_000, "e1")]).values()
    assert good.status == OK
    assert children_of(evaluator.pid) == workers, output(evaluator)
    assert evaluator.poll() is None


def check_mutated(peer: Peer, count: int, seed: int) -> None:
    """Send mutated URDFs and check that each is answered, with finite values or a reason."""
    asked = [candidate(1000 + i, "e1", urdf=urdf) for i, urdf in enumerate(mutated_urdfs(count, seed))]
    answers = answers_to(peer, asked)
    for answer in answers.values():
        assert answer.status in (OK, REJECTED) or answer.reason.startswith("unable: "), answer
        assert math.isfinite(answer.reach) and math.isfinite(answer.torque)
        assert answer.status == OK or answer.reason
    assert len({answer.status for answer in answers.values()}) >= 2


def test_a_candidate_beyond_memory_or_time_costs_at_most_its_worker(nodes: Nodes, peer: Peer) -> None:
    """With memory_mb and evaluation_timeout_s, either is answered FAILED with the reason, and the next is served."""
    free = live_evaluator(nodes, peer)
    answers_to(peer, [candidate(9, "e1")])  # what the worker needs is there once it has answered
    (worker,) = children_of(free.pid)
    status = Path(f"/proc/{worker}/status").read_text()
    used_mb = int(status.split("VmData:")[1].split()[0]) // 1000
    free.kill()
    free.wait()
    peer.heard.clear()
    evaluator = live_evaluator(nodes, peer, memory_mb=used_mb + 15, evaluation_timeout_s=3)
    large = EvaluationSpec(voxel_size=0.01, poses_per_voxel=80)
    asked = [
        candidate(0, "e1", spec=spec_to_message(large)),
        candidate(1, "e1"),
        candidate(2, "e1", spec=spec_to_message(ENDLESS)),
        candidate(3, "e1"),
    ]
    answers = answers_to(peer, asked)
    assert [int(answers[n].status) for n in range(4)] == [FAILED, OK, FAILED, OK]
    assert "MemoryError" in answers[0].reason or "signal" in answers[0].reason
    assert answers[2].reason == "no answer within 3 s"
    assert evaluator.poll() is None and len(children_of(evaluator.pid)) == 1


def test_workers_that_cannot_start_end_the_evaluator_with_one_clear_line(nodes: Nodes) -> None:
    """Its exit code is 1 and its last line says why."""
    evaluator = nodes.start("evaluator", workers=1, memory_mb=1)
    assert finish(evaluator) == 1
    assert "mobo evaluator: workers do not start" in output(evaluator).splitlines()[-1]


def test_a_poisoned_trial_fails_after_max_attempts_on_different_evaluators(
    nodes: Nodes, peer: Peer, tmp_path: Path
) -> None:
    """A candidate that kills every worker it meets is told FAIL with the reason; the study goes on."""
    bag = tmp_path / "bag"
    evaluators = {
        name: nodes.start("evaluator", remap=f"__node:={name}", workers=1, engine="simulated", simulated_s=8.0)
        for name in ("e1", "e2")
    }
    peer.until(lambda: {s.evaluator for s in peer.heard.get("evaluators", [])} == set(evaluators), "both evaluators")
    optimizer = nodes.optimizer(bag, n_trials=3, in_flight=1, sampler="random", max_attempts=3)
    from mobo_msgs.msg import StudyStatus as RosStudyStatus

    peer.hear("study", "StudyStatus", RosStudyStatus)
    poisoned: list[int] = []  # the first trial that is sent once the optimizer knows both: only then has it a choice
    killed: dict[int, float] = {}  # attempt -> when its worker was killed

    def poison() -> bool:
        sent = peer.heard.get("candidates", [])
        if not poisoned and (statuses := peer.heard.get("study")) and statuses[-1].evaluators == 2:
            answered_trials = {int(e.trial) for e in peer.heard.get("evaluations", [])}
            poisoned.extend([int(c.trial) for c in sent if int(c.trial) not in answered_trials][:1])
        answered = {int(e.attempt) for e in peer.heard.get("evaluations", []) if e.trial in poisoned}
        for asked in sent:
            attempt = int(asked.attempt)
            if asked.trial not in poisoned or attempt in answered:
                continue
            # The only trial in flight: it is what this worker works on, half a second after it was sent. On a busy
            # machine the worker may not have had it yet: then the next one gets it, and is killed too.
            if time.monotonic() - killed.setdefault(attempt, time.monotonic() - 2.5) > 3:
                for worker in children_of(evaluators[asked.evaluator].pid):
                    os.kill(worker, signal.SIGSEGV)
                killed[attempt] = time.monotonic()
        return optimizer.poll() is not None

    peer.until(poison, "the study to end", 120)
    assert optimizer.returncode == 0, output(optimizer)
    study = read_study(bag)
    kinds = Trial
    assert poisoned, "both evaluators were never known while a trial was out"
    assert {n: int(study.trials[n].state) for n in range(3)} == {
        n: kinds.FAIL if n in poisoned else kinds.COMPLETE for n in range(3)
    }
    assert study.trials[poisoned[0]].reason == "worker died of signal 11"
    failures = [e for e in study.evaluations if e.status == FAILED]
    assert [int(e.trial) for e in failures] == poisoned * 3
    assert failures[0].evaluator != failures[1].evaluator  # and then, as there is no third, one of them again
    for evaluator in evaluators.values():
        assert evaluator.poll() is None, output(evaluator)
        wait_for(lambda evaluator=evaluator: len(children_of(evaluator.pid)) == 1, "its new worker")
