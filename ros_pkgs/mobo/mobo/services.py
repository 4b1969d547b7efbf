"""The optimizer's services: pause, resume, stop, status, enqueue."""

from __future__ import annotations

import json
from collections.abc import Callable

from rclpy.node import Node
from std_srvs.srv import Trigger

from mobo_core.coordination.control import Reply
from mobo_core.coordination.optimizer import Optimizer
from mobo_msgs.srv import Enqueue

_STATES = ("running", "paused", "done", "stopped", "failed")
_SHOWN = ("study", "n_trials", "asked", "told", "failed", "evaluators", "workers", "best_reach", "hypervolume", "bag")


def offer_services(node: Node, optimizer: Optimizer, clock: Callable[[], float]) -> None:
    """Offer the commands as services with relative names."""
    controls = optimizer.controls

    def told(reply: Reply, source: str) -> Reply:
        node.get_logger().info(f"{source}: {reply.message}")
        optimizer.tick(clock())
        return reply

    def trigger(name: str, command: Callable[[int, str], Reply]) -> None:
        def answer(request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            reply = told(command(len(optimizer.study.asked), f"service {name}"), f"service {name}")
            response.success, response.message = reply.accepted, reply.message
            return response

        node.create_service(Trigger, name, answer)

    def enqueue(request: Enqueue.Request, response: Enqueue.Response) -> Enqueue.Response:
        source = request.source or "service enqueue"
        reply = controls.enqueue(
            len(optimizer.study.asked), source, request.joints, request.lengths, optimizer.n_trials
        )
        told(reply, "service enqueue")
        response.accepted, response.bad_input = reply.accepted, reply.bad_input
        response.trial, response.message = reply.trial, reply.message
        return response

    def status(request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        now = optimizer.status(optimizer.state)
        shown = {"state": _STATES[now.state]} | {name: getattr(now, name) for name in _SHOWN}
        shown["enqueued"] = len(controls.enqueued)
        response.success, response.message = True, json.dumps(shown)
        return response

    trigger("pause", controls.pause)
    trigger("resume", controls.resume)
    trigger("stop", controls.stop)
    node.create_service(Trigger, "status", status)
    node.create_service(Enqueue, "enqueue", enqueue)
