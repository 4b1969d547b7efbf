"""The evaluator node: answers the candidates that name it, each in a worker process."""

from __future__ import annotations

import os
import re
import socket
import sys
import threading

import numpy as np
from rclpy.executors import Executor
from rclpy.node import Node

from mobo.diagnostics import publish_health
from mobo.parameters import declare
from mobo.runtime import CANDIDATES_QOS, MESSAGES_QOS, Stop, light_executor, run, subscribe
from mobo_core import messages
from mobo_core.coordination.answer import Answering, host_id
from mobo_core.coordination.health import Health, evaluator_health
from mobo_core.coordination.options import EvaluatorOptions
from mobo_core.coordination.parameters import help_text
from mobo_core.coordination.pool import WorkerPool
from mobo_core.errors import InputError, StudyError
from mobo_core.messages import address, decode, encode
from mobo_core.version import __version__
from mobo_msgs.msg import Candidate, Evaluation, EvaluatorStatus, Trial

HELP = help_text(
    "evaluator",
    "Evaluate arms: announce itself, take candidates while workers are free, answer each.",
    EvaluatorOptions,
    ["", "--ros-args -p workers:=1", "--ros-args -r __node:=big_machine -p workers:=16"],
)

_HEARTBEAT_S = 1.0


class _Evaluator:
    def __init__(self, node: Node, pool: WorkerPool, options: EvaluatorOptions) -> None:
        self._node, self._pool, self._options = node, pool, options
        self._answered = 0
        self._announced = False
        self.collected = threading.Event()
        self.failure: Exception | None = None
        self._evaluations = node.create_publisher(Evaluation, "evaluations", MESSAGES_QOS)
        self._status = node.create_publisher(EvaluatorStatus, "evaluators", MESSAGES_QOS)
        subscribe(node, Candidate, "candidates", self._on_candidate, CANDIDATES_QOS)
        subscribe(node, Trial, "trials", self._on_trial, MESSAGES_QOS)
        node.create_timer(_HEARTBEAT_S, self.beat)
        publish_health(node, "workers", self._health)

    def _health(self) -> Health:
        pool = self._pool
        return evaluator_health(
            workers=len(pool), ready=pool.ready, restarts=pool.restarts, held=len(pool.held()), answered=self._answered
        )

    def _on_candidate(self, data: bytes) -> None:
        try:
            if address(data).evaluator != self._node.get_name():
                return
            candidate = decode(messages.Candidate, data)
        except InputError as error:
            self._node.get_logger().warning(f"candidate ignored: {error}", throttle_duration_sec=1.0)
            return
        # What comes before the first heartbeat was meant for an earlier node of this name.
        if self._announced:
            self._pool.submit(candidate)

    def _on_trial(self, data: bytes) -> None:
        # A candidate that still waits for a worker while its trial is told elsewhere is no longer needed.
        if not self._pool.waiting:
            return
        try:
            told = decode(messages.Trial, data)
        except InputError:
            return
        self._pool.drop(lambda c: not (c.study == told.study and c.trial == told.trial))

    def collect(self) -> None:
        """Publish the answers that came in from workers; keep what goes wrong in ``failure``."""
        try:
            self._collect()
        except RuntimeError as error:
            self.failure = StudyError(str(error))
        except Exception as error:
            self.failure = error
        self.collected.set()

    def _collect(self) -> None:
        answers = self._pool.collect()
        for answer in answers:
            self._evaluations.publish(answer)
            self._answered += 1
        if not self._announced and self._pool.ready:
            self._announced = True
            self._node.get_logger().info(f"{self._node.get_name()}: {len(self._pool)} workers ready")
            self.beat()

    def beat(self) -> None:
        """Say that this evaluator is there, and what it holds; not before a worker can work."""
        if self._announced:
            self._publish(messages.EvaluatorStatus.ALIVE)

    def leave(self) -> None:
        """Say goodbye, so that its candidates go elsewhere at once."""
        if self._announced:
            self._publish(messages.EvaluatorStatus.LEFT)

    def _publish(self, state: int) -> None:
        held = self._pool.held() if state == messages.EvaluatorStatus.ALIVE else []
        status = messages.EvaluatorStatus(
            evaluator=self._node.get_name(),
            state=state,
            workers=len(self._pool),
            threads=self._options.threads,
            engine=self._options.engine,
            studies=[candidate.study for candidate in held],
            trials=np.array([candidate.trial for candidate in held], np.uint32),
            attempts=np.array([candidate.attempt for candidate in held], np.uint32),
            answered=self._answered,
            mobo_version=__version__,
            host_id=host_id(),
            pid=os.getpid(),
        )
        self._status.publish(encode(status))


def _body(node: Node, executor: Executor, stop: Stop) -> int:
    options = declare(node, EvaluatorOptions)
    answering = Answering(node.get_name(), options.engine, options.threads, options.simulated_s)
    pool = WorkerPool(answering, options.workers, options.evaluation_timeout_s, options.memory_mb)
    evaluator = _Evaluator(node, pool, options)
    # One thread does nothing but wait for workers; all else happens on the executor's.
    closing = threading.Event()

    def watch() -> None:
        while not closing.is_set():
            pool.wait(0.5)
            evaluator.collected.clear()
            if closing.is_set():
                return
            executor.create_task(evaluator.collect)
            evaluator.collected.wait(1.0)

    watcher = threading.Thread(target=watch, daemon=True)
    watcher.start()
    try:
        while not stop:
            executor.spin_once(timeout_sec=0.1)
            if evaluator.failure is not None:
                raise evaluator.failure
        evaluator.leave()
        return 0
    finally:
        # No thread may be left that could call into the executor while the interpreter ends.
        closing.set()
        evaluator.collected.set()
        watcher.join()
        pool.close()


def main() -> int:
    """Run the node; return its exit code."""
    host = re.sub(r"\W", "_", socket.gethostname(), flags=re.ASCII)
    return run(f"evaluator_{host}_{os.getpid()}", HELP, _body, light_executor)


if __name__ == "__main__":
    sys.exit(main())
