"""A message from one node to another and back, over the middleware: what `mobo doctor` tries."""

from __future__ import annotations

import os
import statistics
import sys
import time

from mobo.runtime import MESSAGES_QOS, subscribe
from mobo_core import messages
from mobo_core.messages import decode, encode
from mobo_msgs.msg import EvaluatorStatus

import rclpy  # isort: skip  # after runtime, which keeps the discovery on this host
from rclpy.executors import SingleThreadedExecutor  # isort: skip

_PATIENCE_S = 15.0
_EXCHANGES = 9


def main() -> int:
    """Send until some answers came back; print the median time of an exchange."""
    rclpy.init()
    name = f"mobo_doctor_{os.getpid()}"
    here, there = rclpy.create_node(name), rclpy.create_node(f"{name}_echo")
    echo = there.create_publisher(EvaluatorStatus, f"{name}/back", MESSAGES_QOS)
    subscribe(there, EvaluatorStatus, f"{name}/out", echo.publish, MESSAGES_QOS)
    back: list[bytes] = []
    subscribe(here, EvaluatorStatus, f"{name}/back", back.append, MESSAGES_QOS)
    out = here.create_publisher(EvaluatorStatus, f"{name}/out", MESSAGES_QOS)
    executor = SingleThreadedExecutor()
    executor.add_node(here)
    executor.add_node(there)
    until = time.monotonic() + _PATIENCE_S
    times: list[float] = []
    while time.monotonic() < until and len(times) < _EXCHANGES:
        back.clear()
        sent = time.monotonic()
        out.publish(encode(messages.EvaluatorStatus(evaluator=name)))
        while not back and time.monotonic() < sent + 0.5:
            executor.spin_once(timeout_sec=0.5)
        if back and decode(messages.EvaluatorStatus, back[0]).evaluator == name:
            times.append(time.monotonic() - sent)
    if times:
        scope = os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"]
        print(f"round trip in {1e3 * statistics.median(times):.1f} ms, discovery range {scope}")
        return 0
    print("no message came back", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
