"""A live evaluator and candidates that would crash it, fill its memory or never end."""

from __future__ import annotations

import contextlib
import math
import os
import resource
import signal
from pathlib import Path

import pytest
from hostile import answers_to, candidate, hostile_candidates, live_evaluator, mutated_urdfs
from nodes import Nodes, children_of, finish, output, told_so_far, wait_for
from peer import Peer

from mobo_core.bag.collector import read_study
from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.evaluation.spec_message import spec_to_message
from mobo_core.messages import Evaluation, Trial

pytestmark = pytest.mark.ros

OK, REJECTED, FAILED = (getattr(Evaluation, name) for name in ("OK", "REJECTED", "FAILED"))


def test_mutated_urdfs_and_hostile_specs(nodes: Nodes, peer: Peer) -> None:
    """Each is answered, none costs even the worker, and the next good candidate gets its values.

    Garbage, and what is meant for another, is not answered.
    """
    evaluator = live_evaluator(nodes, peer)
    workers = children_of(evaluator.pid)
    check_mutated(peer, 150, seed=1)
    hostile = hostile_candidates("e1")
    for number, answer in answers_to(peer, hostile).items():
        assert answer.status == REJECTED, (hostile[number], answer)
        assert len(answer.reason) <= 2000 and "\n" not in answer.reason
    peer.send("candidates", b"\x00\x01\x00\x00garbage")
    peer.send("candidates", candidate(99_999, "someone_else"))
    (good,) = answers_to(peer, [candidate(100_000, "e1")]).values()  # nothing came for the one before
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
    evaluator = live_evaluator(nodes, peer, memory_mb=20_000, evaluation_timeout_s=10)
    answers_to(peer, [candidate(9, "e1")])  # what the worker needs is there once it has answered
    (worker,) = children_of(evaluator.pid)
    limits = resource.prlimit(worker, resource.RLIMIT_DATA)
    assert limits == (20_000 * 10**6,) * 2
    # What it needs differs from one start to the next: so the limit comes down to just above that.
    used = int(Path(f"/proc/{worker}/status").read_text().split("VmData:")[1].split()[0]) * 1024
    resource.prlimit(worker, resource.RLIMIT_DATA, (used + 15 * 10**6, limits[1]))
    large = EvaluationSpec(voxel_size=0.01, poses_per_voxel=80)
    (answer,) = answers_to(peer, [candidate(0, "e1", spec=spec_to_message(large))]).values()
    assert answer.status == FAILED
    assert "MemoryError" in answer.reason or "signal" in answer.reason
    (answer,) = answers_to(peer, [candidate(1, "e1")]).values()
    assert answer.status == OK
    (worker,) = wait_for(lambda: children_of(evaluator.pid), "its worker")
    os.kill(worker, signal.SIGSTOP)
    asked = [candidate(2, "e1"), candidate(3, "e1")]
    answers = answers_to(peer, asked)
    assert [int(answers[n].status) for n in (2, 3)] == [FAILED, OK]
    assert answers[2].reason == "no answer within 10 s"
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
    import mobo_msgs.msg

    bag = tmp_path / "bag"
    # Slow ones: nothing is answered but by the death of a worker.
    evaluators = {
        name: nodes.start("evaluator", remap=f"__node:={name}", workers=1, engine="simulated", simulated_s=600.0)
        for name in ("e1", "e2")
    }
    peer.hear("study", "StudyStatus", mobo_msgs.msg.StudyStatus)
    optimizer = nodes.optimizer(bag, n_trials=2, in_flight=1, sampler="random", max_attempts=3)
    # Only then has it a choice.
    peer.until(lambda: (known := peer.heard.get("study")) and known[-1].evaluators == 2, "it to know both")
    killed: set[int] = set()
    for attempt in range(1, 4):
        (asked,) = peer.until(
            lambda attempt=attempt: [c for c in peer.heard.get("candidates", []) if c.attempt == attempt],
            f"attempt {attempt}",
        )
        assert asked.trial == 0
        worker = wait_for(lambda name=asked.evaluator: working(evaluators[name].pid, killed), "a worker that works")
        os.kill(worker, signal.SIGSEGV)
        killed.add(worker)
    wait_for(lambda: told_so_far(bag) == 1, "the trial to be told")
    for evaluator in evaluators.values():
        assert evaluator.poll() is None, output(evaluator)
        wait_for(lambda evaluator=evaluator: len(children_of(evaluator.pid)) == 1, "its new worker")
        evaluator.kill()
    nodes.start("evaluator", workers=1, engine="simulated", simulated_s=0.0)
    assert finish(optimizer) == 0, output(optimizer)
    study = read_study(bag)
    assert [int(study.trials[n].state) for n in range(2)] == [Trial.FAIL, Trial.COMPLETE]
    assert study.trials[0].reason == "worker died of signal 11"
    failures = [e for e in study.evaluations if e.status == FAILED]
    assert [int(e.trial) for e in failures] == [0, 0, 0]
    assert failures[0].evaluator != failures[1].evaluator  # and then, as there is no third, one of them again


def working(evaluator: int, killed: set[int]) -> int | None:
    """Return the worker of an evaluator that sleeps in a simulated evaluation; None if there is none yet."""
    for pid in set(children_of(evaluator)) - killed:
        with contextlib.suppress(OSError):  # it has just ended
            if "nanosleep" in Path(f"/proc/{pid}/wchan").read_text():
                return pid
    return None
