"""The optimizer node: asks for arms to be evaluated, and records all that is said."""

from __future__ import annotations

import contextlib
import sys
import time

from rclpy.duration import Duration
from rclpy.executors import Executor
from rclpy.node import Node

from mobo.diagnostics import publish_health
from mobo.namespace_claim import NodeNamespace
from mobo.parameters import declare
from mobo.runtime import CANDIDATES_QOS, MESSAGES_QOS, STATUS_QOS, run, subscribe
from mobo.services import offer_services
from mobo.viewer import BestArm
from mobo_core import messages
from mobo_core.arms.baselines import checked_plan, first_arms
from mobo_core.bag.study_bag import StudyBag
from mobo_core.coordination.closing import closing_line, go_on_command
from mobo_core.coordination.dispatch import Dispatcher
from mobo_core.coordination.health import StudyHealth
from mobo_core.coordination.optimizer import Optimizer
from mobo_core.coordination.options import OptimizerOptions
from mobo_core.coordination.parameters import help_text
from mobo_core.coordination.plan import total_trials
from mobo_core.coordination.stop import Stop
from mobo_core.errors import MoboError
from mobo_core.evaluation.advice import space_advice
from mobo_core.messages import decode, encode
from mobo_core.verify.spot import SpotCheck
from mobo_msgs.msg import Candidate, Command, Evaluation, EvaluatorStatus, StudyStatus, Trial

HELP = help_text(
    "optimizer",
    "Run a study: publish candidate arms, collect evaluations, record everything into a bag.",
    OptimizerOptions,
    [
        "--ros-args -p study_name:=first -p n_trials:=300",
        "--ros-args -p study_name:=first -p n_trials:=1000 -p resume:=true",
        "--ros-args -p n_joints:=7 -p sampler:=paper -p n_trials:=20000",
    ],
)

_TICK_S = 0.1
_STATUS_S = 0.5


def _body(node: Node, executor: Executor, stop: Stop) -> int:
    options = declare(node, OptimizerOptions)
    plan, namespace = checked_plan(options), node.get_namespace()
    name, folder, log = plan.name, plan.folder, node.get_logger().info
    first = () if plan.goes_on else first_arms(options.baselines, plan.settings.space, log)
    # Before the claim, so that evaluators know them when the first candidate is sent.
    publishers = {
        "candidates": node.create_publisher(Candidate, "candidates", CANDIDATES_QOS),
        "trials": node.create_publisher(Trial, "trials", MESSAGES_QOS),
        "commands": node.create_publisher(Command, "commands", MESSAGES_QOS),
        "study": node.create_publisher(StudyStatus, "study", STATUS_QOS),
    }
    claim = NodeNamespace(node, name, folder, options.lease_s)

    def open_bag() -> StudyBag:
        now = checked_plan(options)  # whoever held the namespace or the bag may have changed it
        return StudyBag(
            folder, now.name, now.settings, resume=now.goes_on,
            node=node.get_fully_qualified_name(), prefix=namespace.rstrip("/") + "/",
        )  # fmt: skip

    bag = claim.take(open_bag, executor, stop)
    if bag is None:
        return 1
    if notice := plan.notice(options):
        log(notice)
    optimizer = spot = None
    try:
        claim.hold()
        past = bag.past()
        n_trials = total_trials(options, past.n_trials, len(past.trials)) if past is not None else options.n_trials
        spot = SpotCheck(folder) if past is not None and past.trials else None
        dispatcher = Dispatcher(
            lease_s=options.lease_s,
            max_attempts=options.max_attempts,
            evaluation_timeout_s=options.evaluation_timeout_s,
        )
        optimizer = Optimizer(
            bag, bag.settings, n_trials, dispatcher,
            publish=lambda topic, data: publishers[topic].publish(data), log=log,
            warn=lambda text: node.get_logger().warning(text, throttle_duration_sec=1.0),
            first=first,
        )  # fmt: skip
        clock, best = time.monotonic, BestArm(node)

        def report() -> None:
            publishers["study"].publish(encode(optimizer.status(optimizer.state)))
            if optimizer.best is not None:
                best.show(*optimizer.best, bag.settings.spec)

        on_evaluator, on_evaluation = optimizer.on_evaluator, optimizer.on_evaluation
        subscribe(node, EvaluatorStatus, "evaluators", lambda data: on_evaluator(data, clock()), MESSAGES_QOS)
        subscribe(node, Evaluation, "evaluations", lambda data: on_evaluation(data, clock()), MESSAGES_QOS)
        node.create_timer(_TICK_S, lambda: optimizer.tick(clock()))
        node.create_timer(_STATUS_S, report)
        offer_services(node, optimizer, clock)
        health = StudyHealth(optimizer, dispatcher, folder)
        publish_health(node, "study", lambda: health.at(clock()))
        log(f"study {bag.name}: {n_trials:,} trials into {folder}")
        if advice := space_advice(bag.settings.space, bag.settings.spec):
            node.get_logger().warning(advice)
        if not optimizer.done:
            optimizer.record_status(messages.StudyStatus.RUNNING)
        while not (stop or optimizer.done or optimizer.controls.stopped):
            executor.spin_once(timeout_sec=_TICK_S)
            warn_of(spot, node)
        warn_of(spot, node, wait=optimizer.done)
        report()
        final = optimizer.end()
        bag.close()
        publishers["study"].publish(final)
        publishers["study"].wait_for_all_acked(Duration(seconds=1))
        log(closing_line(decode(messages.StudyStatus, final), folder, go_on_command(options, bag.name, namespace)))
        return 0 if optimizer.done else 1
    except BaseException as error:
        # The bag may be what failed: what is on disk stays, and the first error is the one to tell.
        with contextlib.suppress(MoboError):
            bag.close()
        if optimizer is not None and isinstance(error, MoboError):
            publishers["study"].publish(encode(optimizer.status(messages.StudyStatus.FAILED, str(error))))
            publishers["study"].wait_for_all_acked(Duration(seconds=1))
        raise
    finally:
        if spot is not None:
            spot.close()


def warn_of(spot: SpotCheck | None, node: Node, *, wait: bool = False) -> None:
    """Warn of what the look at a resumed bag has found."""
    for line in spot.lines(wait) if spot is not None else ():
        node.get_logger().warning(line)


def main() -> int:
    """Run the node; return its exit code."""
    return run("optimizer", HELP, OptimizerOptions, _body)


if __name__ == "__main__":
    sys.exit(main())
