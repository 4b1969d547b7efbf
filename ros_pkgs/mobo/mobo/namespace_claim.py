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
from rclpy.publisher import Publisher
from rclpy.qos import LivelinessPolicy, QoSProfile

from mobo.runtime import qos, subscribe
from mobo_core import messages
from mobo_core.bag.study_bag import StudyBag
from mobo_core.coordination.answer import host_id
from mobo_core.coordination.namespace_claim import Claimant, NamespaceClaim, Rivals, in_use
from mobo_core.coordination.namespace_lock import NamespaceLock
from mobo_core.coordination.stop import Stop
from mobo_core.errors import InputError, InUseError
from mobo_core.messages import decode, encode
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
        self._where = f"namespace {node.get_namespace()}"
        self._message = messages.OptimizerStatus(
            optimizer=node.get_fully_qualified_name(),
            study=study,
            bag=str(bag),
            host_id=host_id(),
            pid=os.getpid(),
        )
        self._claim = NamespaceClaim(_claimant(self._message), time.monotonic(), lease_s=lease_s)
        self._rivals = Rivals(self._claim.me)
        self._holder: Publisher | None = None
        self._lock: NamespaceLock | None = None
        self._dead = 0
        self._said = ""
        self._lease_s = lease_s
        self._claims = node.create_publisher(OptimizerStatus, "claims", qos(10))
        self._repeat = node.create_timer(_REPEAT_S, lambda: self._claims.publish(encode(self._message)))
        subscribe(node, OptimizerStatus, "claims", self._on_claim, qos(10))
        events = SubscriptionEventCallbacks(liveliness=self._on_liveliness)
        node.create_subscription(
            OptimizerStatus, "optimizers", self._on_holder, _holders_qos(), event_callbacks=events, raw=True
        )

    def take(self, open_bag: Callable[[], StudyBag], executor: Executor, stop: Stop) -> StudyBag | None:
        """Return the bag once both it and the namespace are this node's; None if it shall stop before that.

        Raises:
            InUseError: another optimizer has one of them, and still had after a lease.
        """
        until = None
        while not stop:
            now = time.monotonic()
            if self._claim.may_go(now, self._where):
                try:
                    if self._lock is None:
                        self._lock = NamespaceLock(self._node.get_namespace(), self._claim.known)
                    return open_bag()
                except InUseError as error:
                    until = until or now + self._lease_s
                    if now >= until:
                        raise
                    self._say(f"{error}; waiting {self._lease_s:g} s for it to vanish")
            elif (other := self._claim.in_the_way(now)) is not None and other.pid:
                self._say(f"{self._where} is in use by {other}; waiting {self._lease_s:g} s for it to vanish")
            executor.spin_once(timeout_sec=0.05)
            # The graph keeps a killed node for long, but only with those who knew it before.
            self._claim.alive(self._node.count_publishers("optimizers") - self._dead)
        return None

    def _say(self, text: str) -> None:
        if text != self._said:
            self._said = text
            self._node.get_logger().warning(text)  # `study` shows warnings alone

    def hold(self) -> None:
        """Tell the others that the namespace is taken, until this node ends."""
        self._holder = self._node.create_publisher(OptimizerStatus, "optimizers", _holders_qos())
        self._publish_holder()
        self._node.destroy_timer(self._repeat)
        self._node.create_timer(_HOLD_REPEAT_S, self._publish_holder)

    def _publish_holder(self) -> None:
        if self._holder is not None:
            self._holder.publish(encode(self._message))

    def _on_claim(self, data: bytes) -> None:
        other = _read(data)
        if other is None or other == self._claim.me:
            return
        self._claim.claimed(other, time.monotonic())
        self._publish_holder()

    def _on_holder(self, data: bytes) -> None:
        other = _read(data)
        if other is None or other == self._claim.me:
            return
        if self._holder is None:
            self._claim.held(other, time.monotonic())
        elif self._rivals.heard(other, time.monotonic()):
            # Two networks that became one, say: the study that began later ends.
            raise in_use(other, self._where)

    def _on_liveliness(self, event: QoSLivelinessChangedInfo) -> None:
        self._dead = event.not_alive_count


def _read(data: bytes) -> Claimant | None:
    try:
        message = decode(messages.OptimizerStatus, data)
    except InputError:
        return None
    return _claimant(message)


def _claimant(message: messages.OptimizerStatus) -> Claimant:
    return Claimant(message.header.time_ns, message.host_id, message.pid, message.optimizer)
