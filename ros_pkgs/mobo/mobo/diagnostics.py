"""Publishes a node's health on /diagnostics once a second."""

from __future__ import annotations

from collections.abc import Callable

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from mobo_core.coordination.answer import host_id
from mobo_core.coordination.health import Health

_PERIOD_S = 1.0


def publish_health(node: Node, component: str, health: Callable[[], Health]) -> None:
    """Publish what ``health`` returns as the status ``NODE: component``."""
    publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
    name = f"{node.get_fully_qualified_name().lstrip('/')}: {component}"

    def publish() -> None:
        now = health()
        values = [KeyValue(key=key, value=value) for key, value in now.figures.items()]
        status = DiagnosticStatus(
            level=bytes([now.level]), name=name, message=now.message, hardware_id=host_id(), values=values
        )
        array = DiagnosticArray(status=[status])
        array.header.stamp = node.get_clock().now().to_msg()
        publisher.publish(array)

    node.create_timer(_PERIOD_S, publish)
