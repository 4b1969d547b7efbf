"""The evaluator node: answers the candidates that name it, each in a worker process."""

from __future__ import annotations

import sys
import threading

from rclpy.executors import Executor
from rclpy.node import Node

from mobo.diagnostics import publish_health
from mobo.parameters import declare
from mobo.runtime import CANDIDATES_QOS, MESSAGES_QOS, light_executor, run, subscribe
from mobo_core.coordination.answer import Answering
from mobo_core.coordination.evaluator import HEARTBEAT_S, Evaluator, default_name
from mobo_core.coordination.options import EvaluatorOptions
from mobo_core.coordination.parameters import help_text
from mobo_core.coordination.pool import WorkerPool
from mobo_core.coordination.stop import Stop
from mobo_msgs.msg import Candidate, Evaluation, EvaluatorStatus, Trial

HELP = help_text(
    "evaluator",
    "Evaluate arms: announce itself, take candidates while workers are free, answer each.",
    EvaluatorOptions,
    ["", "--ros-args -p workers:=1", "--ros-args -r __node:=big_machine -p workers:=16"],
)


class _Watcher:
    """A thread that does nothing but wait for workers; all else happens on the executor's."""

    def __init__(self, pool: WorkerPool, evaluator: Evaluator, executor: Executor) -> None:
        self._pool, self._evaluator, self._executor = pool, evaluator, executor
        self._collected, self._closing = threading.Event(), threading.Event()
        self.failure: Exception | None = None
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._thread.start()

    def _watch(self) -> None:
        while not self._closing.is_set():
            self._pool.wait(0.5)
            self._collected.clear()
            if self._closing.is_set():
                return
            self._executor.create_task(self._collect)
            self._collected.wait(1.0)

    def _collect(self) -> None:
        try:
            self._evaluator.collect()
        except Exception as error:  # a task must not raise
            self.failure = error
        self._collected.set()

    def close(self) -> None:
        """End the thread: none may be left that could call into the executor while the interpreter ends."""
        self._closing.set()
        self._collected.set()
        self._thread.join()


def _body(node: Node, executor: Executor, stop: Stop) -> int:
    options, log = declare(node, EvaluatorOptions), node.get_logger()
    options.check_load()
    answering = Answering(node.get_name(), options.engine, options.threads, options.simulated_s)
    pool = WorkerPool(answering, options.workers, options.evaluation_timeout_s, options.memory_mb)
    publishers = {
        "evaluations": node.create_publisher(Evaluation, "evaluations", MESSAGES_QOS),
        "evaluators": node.create_publisher(EvaluatorStatus, "evaluators", MESSAGES_QOS),
    }
    evaluator = Evaluator(
        pool, publish=lambda topic, data: publishers[topic].publish(data), log=log.info,
        warn=lambda text: log.warning(text, throttle_duration_sec=1.0),
    )  # fmt: skip
    subscribe(node, Candidate, "candidates", evaluator.on_candidate, CANDIDATES_QOS)
    subscribe(node, Trial, "trials", evaluator.on_trial, MESSAGES_QOS)
    node.create_timer(HEARTBEAT_S, evaluator.beat)
    publish_health(node, "workers", evaluator.health)
    watcher = _Watcher(pool, evaluator, executor)
    try:
        while not stop:
            executor.spin_once(timeout_sec=0.1)
            if watcher.failure is not None:
                raise watcher.failure
        evaluator.leave()
        return 0
    finally:
        watcher.close()
        pool.close()


def main() -> int:
    """Run the node; return its exit code."""
    return run(default_name(), HELP, EvaluatorOptions, _body, light_executor)


if __name__ == "__main__":
    sys.exit(main())
