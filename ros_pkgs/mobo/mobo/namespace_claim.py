"""One optimizer to a namespace: those that start, and the one that runs, hear each other on the network.

Who runs has a publisher on ``optimizers``, which the others see as soon as they have found its node, and whose
liveliness the middleware watches: a killed one is gone after two seconds, a busy one is not. Who wants to run
says so on ``claims`` and listens first; who runs answers that with its name. On one host the kernel decides. Should
two run after all, on networks that became one or lost messages, each repeats its name and the later one ends.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path

from rclpy.duration import Duration
from rclpy.event_handler import QoSLivelinessChangedInfo, SubscriptionEventCallbacks
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.qos import LivelinessPolicy, QoSProfile

from mobo.runtime import qos, subscribe
from mobo_core import messages
from mobo_core.bag.study_bag import StudyBag
from mobo_core.coordination.answer import host_id
from mobo_core.coordination.namespace import Namespace
from mobo_core.coordination.namespace_lock import NamespaceLock
from mobo_core.coordination.stop import Stop
from mobo_msgs.msg import OptimizerStatus

_REPEAT_S = 0.1
_ALIVE_S = 2.0
_HOLD_REPEAT_S = 1.0


def _holders_qos() -> QoSProfile:
    profile = qos(1, latched=True)
    profile.liveliness = LivelinessPolicy.AUTOMATIC
    profile.liveliness_lease_duration = Duration(seconds=_ALIVE_S)
    return profile


class NodeNamespace:
    """The namespace of this node, which it claims from construction on.

    Args:
        node: the optimizer.
        study, bag: what it means to run.
        lease_s: s to wait for a holder that may have vanished.
    """

    def __init__(self, node: Node, study: str, bag: Path, lease_s: float) -> None:
        self._node = node
        message = messages.OptimizerStatus(
            optimizer=node.get_fully_qualified_name(),
            study=study,
            bag=str(bag),
            host_id=host_id(),
            pid=os.getpid(),
        )
        name = node.get_namespace()
        self._publishers = {"claims": node.create_publisher(OptimizerStatus, "claims", qos(10))}
        self._claim = claim = Namespace(
            message, f"namespace {name}", time.monotonic(), lease_s=lease_s,
            lock=lambda known: NamespaceLock(name, known),
            publish=lambda topic, data: self._publishers[topic].publish(data),
            say=node.get_logger().warning,  # `study` shows warnings alone
        )  # fmt: skip
        self._dead = 0
        self._repeat = node.create_timer(_REPEAT_S, claim.repeat)
        subscribe(node, OptimizerStatus, "claims", lambda data: claim.on_claim(data, time.monotonic()), qos(10))
        events = SubscriptionEventCallbacks(liveliness=self._on_liveliness)
        node.create_subscription(
            OptimizerStatus, "optimizers", self._on_holder, _holders_qos(), event_callbacks=events, raw=True
        )

    def take(self, open_bag: Callable[[], StudyBag], executor: Executor, stop: Stop) -> StudyBag | None:
        """Return the bag once both it and the namespace are this node's; None if it shall stop before that.

        Raises:
            InUseError: another optimizer has one of them, and still had after a lease.
        """
        while not stop:
            if (bag := self._claim.take(open_bag, time.monotonic())) is not None:
                return bag
            executor.spin_once(timeout_sec=0.05)
            # The graph keeps a killed node for long, but only with those who knew it before.
            self._claim.alive(self._node.count_publishers("optimizers") - self._dead)
        return None

    def hold(self) -> None:
        """Tell the others that the namespace is taken, until this node ends."""
        self._publishers["optimizers"] = self._node.create_publisher(OptimizerStatus, "optimizers", _holders_qos())
        self._claim.hold()
        self._node.destroy_timer(self._repeat)
        self._node.create_timer(_HOLD_REPEAT_S, self._claim.repeat)

    def _on_holder(self, data: bytes) -> None:
        self._claim.on_holder(data, time.monotonic())

    def _on_liveliness(self, event: QoSLivelinessChangedInfo) -> None:
        self._dead = event.not_alive_count
