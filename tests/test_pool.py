"""The workers of an evaluator, and how they answer."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from arms import HANDED_ARM, arm, small_spec
from nodes import alive

from mobo_core.bag.validity import evaluation_fault
from mobo_core.coordination.answer import Answering
from mobo_core.coordination.pool import WorkerPool
from mobo_core.evaluation import EvaluationSpec
from mobo_core.evaluation.evaluate import evaluate
from mobo_core.evaluation.spec_message import spec_to_message
from mobo_core.messages import UNABLE, Candidate, Evaluation, decode, encode

OK, REJECTED, FAILED = (getattr(Evaluation, name) for name in ("OK", "REJECTED", "FAILED"))
SMALL = small_spec(poses_per_voxel=3)
ENDLESS = EvaluationSpec(voxel_size=0.02, restarts=1000, iterations=10000, position_tolerance=1e-300)  # for days


def candidate(trial: int = 0, urdf: str = arm("PRRYPY"), spec: EvaluationSpec = SMALL, **fields: Any) -> Any:
    given = {"attempt": 1, "evaluator": "e", "tip": "tool", **fields}
    return Candidate(study="s", trial=trial, urdf=urdf, spec=spec_to_message(spec), **given)


def gather(pool: WorkerPool, count: int) -> list[Any]:
    """Wait for answers; pytest's own time-out ends this."""
    answers: list[Any] = []
    while len(answers) < count:
        pool.wait(1.0)
        answers += [decode(Evaluation, data) for data in pool.collect()]
    return answers


def wait_until(holds: Callable[[], bool], pool: WorkerPool | None = None) -> None:
    while not holds():
        time.sleep(0.02)
        if pool is not None:
            assert pool.collect() == []


@contextlib.contextmanager
def pool_of(workers: int, engine: Any = "kernel", **options: Any) -> Iterator[WorkerPool]:
    settings = {name: options.pop(name) for name in ("threads", "simulated_s") if name in options}
    pool = WorkerPool(Answering("e", engine, **settings), workers, **options)
    try:
        yield pool
    finally:
        pool.close()


@pytest.fixture(scope="module")
def kernel_pool() -> Iterator[WorkerPool]:
    with pool_of(2) as pool:
        yield pool


def test_answers_are_what_an_evaluation_gives(kernel_pool: WorkerPool) -> None:
    """Each candidate gets one answer, with the values evaluate() gives here, naming study, trial and attempt."""
    urdfs = [arm("PRRYPY"), arm("YPPYPY"), HANDED_ARM, arm("YPYPYPR"), arm("RPYPRP")]
    tips = ["tool", "tool", "tcp", "tool", "link_6"]
    for trial, (urdf, tip) in enumerate(zip(urdfs, tips, strict=True)):
        kernel_pool.submit(candidate(trial, urdf, tip=tip, attempt=trial + 2))
    assert len(kernel_pool.held()) == 5
    answers = {given.trial: given for given in gather(kernel_pool, 5)}
    assert kernel_pool.held() == []
    assert sorted(answers) == [0, 1, 2, 3, 4]
    for trial, given in answers.items():
        assert (given.study, given.evaluator, given.attempt, given.status) == ("s", "e", trial + 2, OK)
        expected = evaluate(urdfs[trial], SMALL, tip=tips[trial], audit_poses=8, audit_number=trial)
        assert (given.reach, given.torque) == (expected.reach, expected.torque)
        assert np.array_equal(given.voxel_reach, expected.voxel_reach)
        assert np.array_equal(given.voxel_torque, expected.voxel_torque)
        assert np.array_equal(given.voxel_torque_sd, expected.voxel_torque_sd.astype(np.float32))
        assert np.array_equal(given.voxel_in_collision, expected.in_collision)
        assert (given.attempts, given.iterations) == (expected.attempts, expected.iterations)
        assert (given.audit_poses, given.audit_max_error) == (expected.audit_poses, expected.audit_max_error)
        assert given.audit_poses > 0
        assert evaluation_fault(given, SMALL.n_voxels) == ""


def test_what_this_evaluator_is_unable_to_answer_is_failed_not_rejected(kernel_pool: WorkerPool) -> None:
    """Another evaluator may: candidates of another schema, or with more joints than the kernel takes."""
    for asked, words in (
        (candidate(schema_version=999), "schema_version: 999; expected 2, this evaluator's"),
        (candidate(urdf=arm("P" * 13, (0.04,) * 13)), "13 joints on the way to the tip"),
    ):
        kernel_pool.submit(asked)
        (given,) = gather(kernel_pool, 1)
        assert given.status == FAILED
        assert given.reason.startswith(UNABLE)
        assert words in given.reason


@pytest.mark.parametrize(
    ("bad", "words"),
    [
        (candidate(urdf="<robot"), "urdf: not well-formed XML"),
        (candidate(urdf=""), "urdf: not well-formed XML"),
        (candidate(urdf=" " * 50_000_000), "at most 1000000 bytes"),
        (candidate(urdf=arm("PRRYPY").replace('value="0.5', 'value="-0.5')), "more than 0"),
        (candidate(tip="hook"), "no link 'hook'"),
        (candidate(urdf=HANDED_ARM, tip=""), "3 leaf links"),
    ],
)
def test_bad_candidates_are_rejected(kernel_pool: WorkerPool, bad: Any, words: str) -> None:
    """A bad candidate is answered REJECTED with a one-line reason, by a worker that stays alive."""
    pids = kernel_pool.pids
    kernel_pool.submit(bad)
    (given,) = gather(kernel_pool, 1)
    assert given.status == REJECTED
    assert words in given.reason
    assert "\n" not in given.reason
    assert len(given.voxel_reach) == 0
    assert kernel_pool.pids == pids


def test_bad_specs_are_rejected(kernel_pool: WorkerPool) -> None:
    """A candidate whose spec makes no sense is answered REJECTED."""
    bad = candidate()
    bad.spec.voxel_size = 1e-9
    kernel_pool.submit(bad)
    (given,) = gather(kernel_pool, 1)
    assert (given.status, "at most 1000000 voxels" in given.reason) == (REJECTED, True)


@pytest.mark.slow
def test_a_killed_worker_costs_its_candidate_alone() -> None:
    """When a worker is SIGKILLed its candidate is answered FAILED, the others go on, and it is replaced."""
    with pool_of(1) as pool:
        wait_until(lambda: pool.ready == 1, pool)
        pool.submit(candidate(7, spec=ENDLESS, attempt=3))
        pool.submit(candidate(8))
        first = pool.pids
        os.kill(first[0], signal.SIGKILL)
        failed, good = gather(pool, 2)
        assert (failed.trial, failed.attempt, failed.status) == (7, 3, FAILED)
        assert failed.reason == "worker died of signal 9"
        assert (good.trial, good.status) == (8, OK)
        assert not alive(first[0])
        assert pool.pids != first
        assert len(pool) == 1


def test_an_idle_worker_that_dies_is_replaced() -> None:
    """A worker killed while it waits costs nothing but its replacement."""
    with pool_of(1, "simulated", simulated_s=0.0) as pool:
        wait_until(lambda: pool.ready == 1, pool)
        (first,) = pool.pids
        os.kill(first, signal.SIGKILL)
        wait_until(lambda: not alive(first))
        pool.submit(candidate(1))  # before the pool can know
        (given,) = gather(pool, 1)
        assert given.status in (OK, FAILED)
        pool.submit(candidate(2))
        assert [again.status for again in gather(pool, 1)] == [OK]
        assert pool.pids != [first]


@pytest.mark.slow
def test_time_out() -> None:
    """A worker that takes too long is killed, its candidate answered FAILED, and the next one served."""
    now = [0.0]
    with pool_of(1, timeout_s=600.0, clock=lambda: now[0]) as pool:
        wait_until(lambda: pool.ready == 1, pool)
        (first,) = pool.pids
        now[0] = 1000.0
        pool.submit(candidate(1, spec=ENDLESS))
        pool.submit(candidate(2))
        now[0] = 1600.0
        assert pool.collect() == []
        assert pool.pids == [first]
        now[0] = 1600.1
        failed, good = gather(pool, 2)
        assert (failed.trial, failed.status, failed.reason) == (1, FAILED, "no answer within 600 s")
        assert (good.trial, good.status) == (2, OK)
        assert not alive(first)


def test_candidates_wait_in_order_and_can_be_dropped() -> None:
    """Candidates beyond the number of workers wait; those that are no longer wanted are forgotten, running ones not."""
    with pool_of(1, "simulated", simulated_s=0.05) as pool:
        for trial in range(6):
            pool.submit(candidate(trial))
        wait_until(lambda: pool.ready == 1, pool)
        assert [held.trial for held in pool.held()] == [0, 1, 2, 3, 4, 5]
        pool.drop(lambda waiting: waiting.trial in (3, 5))
        assert [held.trial for held in pool.held()] == [0, 3, 5]
        assert [given.trial for given in gather(pool, 3)] == [0, 3, 5]
        assert pool.held() == []


def test_simulated_answers_depend_on_the_urdf_alone() -> None:
    """The simulated engine answers valid values made from the URDF, the same from any worker, at any time."""
    with pool_of(2, "simulated", simulated_s=0.0) as pool:
        for trial, joints in enumerate(["PRRYPY", "YPPYPY"] * 4):
            pool.submit(candidate(trial, arm(joints)))
        answers = sorted(gather(pool, 8), key=lambda given: given.trial)
    values = [(given.reach, given.torque) for given in answers]
    assert all(given.status == OK and evaluation_fault(given, SMALL.n_voxels) == "" for given in answers)
    assert values == values[:2] * 4
    assert values[0] != values[1]
    assert 0 <= values[0][0] <= SMALL.n_voxels


@pytest.mark.slow
def test_close_leaves_no_child() -> None:
    """After close() no worker is left, idle or busy, and close() may be called again."""
    with pool_of(3) as pool:
        wait_until(lambda: pool.ready == 3, pool)
        pool.submit(candidate(spec=ENDLESS))
        pids = pool.pids
        assert all(alive(pid) for pid in pids)
        pool.close()
        assert not any(alive(pid) for pid in pids)
        assert len(pool) == 0


@pytest.mark.slow
@pytest.mark.parametrize("signum", [signal.SIGKILL, signal.SIGTERM])
def test_no_child_outlives_a_killed_parent(signum: int) -> None:
    """When the process that holds the pool is killed, its workers end too, even busy ones."""
    code = (
        "import time, test_pool\n"
        "from mobo_core.coordination.answer import Answering\n"
        "from mobo_core.coordination.pool import WorkerPool\n"
        "pool = WorkerPool(Answering('e'), 2)\n"
        "while pool.ready < 2: pool.wait(1.0); pool.collect()\n"
        "pool.submit(test_pool.candidate(spec=test_pool.ENDLESS))\n"
        "print(*pool.pids, flush=True)\n"
        "time.sleep(600)\n"
    )
    path = os.pathsep.join([str(Path(__file__).parent), *filter(None, sys.path)])
    parent = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, env={**os.environ, "PYTHONPATH": path}
    )
    assert parent.stdout is not None
    pids = [int(word) for word in parent.stdout.readline().split()]
    assert len(pids) == 2
    assert all(alive(pid) for pid in pids)
    parent.send_signal(signum)
    parent.communicate()
    wait_until(lambda: not any(alive(pid) for pid in pids))


def test_workers_that_cannot_start_are_said(monkeypatch: pytest.MonkeyPatch) -> None:
    """Workers that die as they start, again and again, end the pool with an error instead of a loop."""
    monkeypatch.setattr(sys, "executable", "/bin/false")
    with pytest.raises(RuntimeError, match=r"workers do not start \(exit code 1\)"), pool_of(2) as pool:
        while True:
            pool.wait(1.0)
            pool.collect()


def test_the_unforeseen_is_a_failure(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> None:
    """An exception that nobody foresaw is answered FAILED with its name, and printed for whoever looks into it."""

    def broken(*_: object, **__: object) -> None:
        raise ZeroDivisionError("of all things")

    monkeypatch.setattr("mobo_core.evaluation.evaluate.evaluate", broken)
    given = Answering("e").answer(candidate())
    assert (given.status, given.reason) == (FAILED, "ZeroDivisionError: of all things")
    assert "Traceback" in capfd.readouterr().err


def test_a_failed_audit_is_a_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    """An evaluation whose audit finds a fault is answered FAILED with it, without values."""

    def doubtful(*args: Any, **options: Any) -> Any:
        result = evaluate(*args, **options)
        result.audit_fault = "audit: voxel 1, pose 2: torque off by 1 N m"
        return result

    monkeypatch.setattr("mobo_core.evaluation.evaluate.evaluate", doubtful)
    given = Answering("e").answer(candidate())
    assert (given.status, given.reason) == (FAILED, "audit: voxel 1, pose 2: torque off by 1 N m")
    assert len(given.voxel_reach) == 0
    assert encode(given)


def test_reasons_are_short() -> None:
    """A reason is cut at 2,000 characters, however long the name that caused it."""
    given = Answering("e").answer(candidate(tip="x" * 100_000))
    assert given.status == REJECTED
    assert len(given.reason) <= 2000


def test_reference_engine_and_threads() -> None:
    """The reference engine and two threads answer what the kernel with one thread does."""
    quick = small_spec(poses_per_voxel=1, restarts=0)
    kernel, threaded, reference = (
        Answering("e", engine, threads=threads).answer(candidate(3, spec=quick))
        for engine, threads in (("kernel", 1), ("kernel", 2), ("reference", 1))
    )
    assert (threaded.reach, threaded.torque) == (kernel.reach, kernel.torque)
    assert reference.reach == kernel.reach
    assert reference.torque == pytest.approx(kernel.torque, abs=1e-6)


def test_an_evaluator_and_simulated_workers_need_no_heavy_libraries() -> None:
    """What they import starts in a fraction of the time that Numba, Pinocchio and Optuna take."""
    program = (
        "import sys\n"
        "from mobo_core.coordination import pool, worker\n"
        "from mobo_core.coordination.answer import Answering\n"
        "Answering('e', 'simulated').load()\n"
        "print(sorted({'numba', 'pinocchio', 'coal', 'optuna', 'scipy'} & sys.modules.keys()))\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
