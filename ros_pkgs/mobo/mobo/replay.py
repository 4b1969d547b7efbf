"""The replay node: plays a recorded study below ``replay/``, for viewers."""

from __future__ import annotations

import sys
import time

from rclpy.duration import Duration
from rclpy.executors import Executor
from rclpy.node import Node

from mobo.parameters import declare
from mobo.runtime import qos, run
from mobo.viewer import BestArm
from mobo_core import messages
from mobo_core.bag.collector import message_of, read_study
from mobo_core.bag.reader import entries
from mobo_core.bag.record import StudyRecord
from mobo_core.coordination.options import ReplayOptions
from mobo_core.coordination.parameters import help_text
from mobo_core.coordination.stop import Stop
from mobo_core.errors import InputError
from mobo_core.messages import TOPICS, encode
from mobo_msgs.msg import Candidate, Command, Evaluation, EvaluatorStatus, StudyStatus, Trial

HELP = help_text(
    "replay",
    "Play a bag: its messages below replay/, with the best arm so far as replay/robot_description and "
    "replay/voxels.",
    ReplayOptions,
    ["--ros-args -p bag:=bags/first", "--ros-args -p bag:=bags/first -p rate:=100"],
)

# Whoever waits for the first message needs a moment to find these publishers.
_DISCOVERY_S = 2.0

_TYPES = {
    kind.__name__: kind for kind in (Candidate, Command, Evaluation, EvaluatorStatus, StudyStatus, Trial)
}


def _body(node: Node, executor: Executor, stop: Stop) -> int:
    options = declare(node, ReplayOptions)
    if not options.bag:
        raise InputError("no bag given", where="parameter bag", expected="-p bag:=FOLDER")
    study = read_study(options.bag)
    for fault in study.faults:
        node.get_logger().warning(f"{fault}; playing what comes before")
    # Latched: a viewer that asks for it gets what was played before it came.
    kept = qos(1000, latched=True)
    publishers = {
        topic: node.create_publisher(_TYPES[cls.kind], f"replay/{topic}", kept) for topic, cls in TOPICS.items()
    }
    best, best_reach = BestArm(node, "replay/"), -1.0
    _pause(executor, stop, _DISCOVERY_S)
    began, first_ns, played = time.monotonic(), None, 0
    for entry in entries(study.contents):
        topic = entry.topic.rsplit("/", 1)[-1]
        if topic not in TOPICS or TOPICS[topic].kind != entry.kind or (message := message_of(entry)) is None:
            continue
        first_ns = entry.time_ns if first_ns is None else first_ns
        if options.rate > 0:
            due = began + (entry.time_ns - first_ns) * 1e-9 / options.rate
            _pause(executor, stop, due - time.monotonic())
        if stop:
            node.get_logger().info(f"stopped after {played} messages")
            return 1
        publishers[topic].publish(encode(message))  # an older bag's message in today's schema
        played += 1
        if isinstance(message, messages.Trial):
            best_reach = _show_best(study, message, best, best_reach)
    for publisher in publishers.values():
        publisher.wait_for_all_acked(Duration(seconds=5))
    node.get_logger().info(f"played {played} messages of {options.bag}")
    return 0


def _pause(executor: Executor, stop: Stop, seconds: float) -> None:
    until = time.monotonic() + seconds
    while not stop and (left := until - time.monotonic()) > 0:
        executor.spin_once(timeout_sec=min(left, 0.1))


def _show_best(study: StudyRecord, trial: messages.Trial, best: BestArm, best_reach: float) -> float:
    """Show the arm of a trial if it reaches more than all before; return the highest reach so far."""
    evaluation = study.accepted(trial.trial)
    candidate = study.candidate_of(trial.trial)
    if evaluation is None or candidate is None or not trial.reach > best_reach:
        return best_reach
    best.show(evaluation, candidate.urdf, study.settings.spec)
    return trial.reach


def main() -> int:
    """Run the node; return its exit code."""
    return run("replay", HELP, ReplayOptions, _body)


if __name__ == "__main__":
    sys.exit(main())
