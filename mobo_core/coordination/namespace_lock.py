"""A namespace's optimizers on one host: the kernel lets one of them have it, however busy the machine is."""

from __future__ import annotations

import contextlib
import hashlib
import os
import socket
import struct
from collections.abc import Callable

from mobo_core.coordination.answer import host_id
from mobo_core.coordination.namespace_claim import Claimant, in_use

_PEER = struct.Struct("3i")  # pid, user and group of who listens


class NamespaceLock:
    """Held from construction to :meth:`release`, or to the end of the process, however that ends.

    It is a listening socket with a name that is no file: who comes second learns from the kernel whose it is. Such
    names belong to a network namespace, as ROS domains do.

    Args:
        namespace: of ROS nodes; with the ROS domain it makes the name.
        name_of: tells who a process is, as far as it is known.

    Raises:
        InUseError: another process holds it; says which.
    """

    def __init__(self, namespace: str, name_of: Callable[[int], Claimant | None] = lambda pid: None) -> None:
        domain = os.environ.get("ROS_DOMAIN_ID", "") or "0"
        address = f"\0mobo.optimizer.{domain}.{hashlib.sha256(namespace.encode()).hexdigest()[:32]}"
        self._socket = socket.socket(socket.AF_UNIX)
        try:
            self._socket.bind(address)
        except OSError:
            self._socket.close()
            pid = _holder(address)
            other = name_of(pid) or Claimant(0, host_id(), pid, "an optimizer")
            raise in_use(other, f"namespace {namespace}") from None
        self._socket.listen()

    def release(self) -> None:
        """Give it back."""
        self._socket.close()


def _holder(address: str) -> int:
    """Return the process id of who listens, 0 if it cannot be told."""
    with socket.socket(socket.AF_UNIX) as asking, contextlib.suppress(OSError):
        asking.setblocking(False)
        asking.connect(address)
        pid: int = _PEER.unpack(asking.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _PEER.size))[0]
        return pid
    return 0
