"""A node of a test itself, among the real ones."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import Any

from nodes import PATIENCE_S, wait_for

from mobo_core.errors import InputError
from mobo_core.messages import KINDS, TOPICS, decode, encode


class Peer:
    """A node of this test: publishes what it likes, hears everything."""

    def __init__(self, environment: dict[str, str]) -> None:
        import rclpy
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.qos import DurabilityPolicy, QoSProfile

        import mobo_msgs.msg

        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=int(environment["ROS_DOMAIN_ID"]))
        self.node = rclpy.create_node("peer", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.heard: dict[str, list[Any]] = {}
        self._received = 0
        self._publishers = {}
        self._latched = latched = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        for topic in ("candidates", "evaluations", "evaluators"):
            kind = TOPICS[topic].kind
            cls = getattr(mobo_msgs.msg, kind)
            self._publishers[topic] = self.node.create_publisher(cls, topic, latched)
            self.hear(topic, kind, cls)

    def hear(self, topic: str, kind: str, cls: Any, *, latched: bool = False) -> None:
        def take(data: bytes) -> None:
            self._received += 1
            with contextlib.suppress(InputError):  # it hears its own garbage too
                self.heard.setdefault(topic, []).append(decode(KINDS[kind], data))

        self.node.create_subscription(cls, topic, take, self._latched if latched else 1000, raw=True)

    def send(self, topic: str, message: Any) -> None:
        self._publishers[topic].publish(message if isinstance(message, bytes) else encode(message))

    def is_heard_on(self, topic: str) -> bool:
        """Return whether another node than this one listens to what it sends."""
        return bool(self._publishers[topic].get_subscription_count() > 1)

    def until(self, what: Callable[[], Any], text: str, timeout_s: float = PATIENCE_S) -> Any:
        def step() -> Any:
            self.executor.spin_once(timeout_sec=0.02)
            heard = -1
            while heard != (heard := self._received):
                self.executor.spin_once(timeout_sec=0)
            return what()

        return wait_for(step, text, timeout_s)

    def close(self) -> None:
        self.node.destroy_node()
        self.context.try_shutdown()
