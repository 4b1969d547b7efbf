"""The processes behind a pool's workers: started, written to, listened to, ended."""

from __future__ import annotations

import contextlib
import os
import selectors
import socket
import subprocess
import sys
from collections.abc import Collection
from multiprocessing.connection import Connection
from typing import Protocol

from mobo_core.coordination.answer import Answering


class Worker(Protocol):
    """One worker; its first message says what it can do, each further one answers a candidate."""

    @property
    def pid(self) -> int:
        """Its process id."""

    def send(self, data: bytes) -> None:
        """Send it a candidate; OSError if it has ended."""

    def receive(self) -> bytes:
        """Return its next message; EOFError or OSError if it has ended."""

    def end(self, wait_s: float = 0.0) -> int:
        """End it, having waited so long for it to end by itself; return its exit code. May be called twice."""


class Workers(Protocol):
    """Where workers come from."""

    def start(self, answering: Answering, memory_mb: int) -> Worker:
        """Start one that answers like this and may hold so many MB of data (0: any)."""

    def ready(self) -> Collection[Worker]:
        """Return those that have a message, or have ended."""

    def wait(self, timeout: float) -> bool:
        """Wait up to ``timeout`` seconds for one to be ready; may be called from another thread."""

    def close(self) -> None:
        """Listen to none any more."""


class WorkerProcesses:
    """Workers that are child processes of this one."""

    def __init__(self) -> None:
        self._selector = selectors.DefaultSelector()

    def start(self, answering: Answering, memory_mb: int) -> Worker:
        """Start a process that imports and compiles all it needs, and then says so."""
        ours, theirs = socket.socketpair()
        with theirs:
            numbers = (theirs.fileno(), os.getpid(), memory_mb)
            command = [sys.executable, "-m", "mobo_core.coordination.worker", *map(str, numbers)]
            process = subprocess.Popen(command, pass_fds=[theirs.fileno()], stdin=subprocess.DEVNULL)
        connection = Connection(ours.detach())
        # If it has died already, whoever receives finds out.
        with contextlib.suppress(OSError):
            connection.send(answering)
        worker = _WorkerProcess(process, connection, self._selector)
        self._selector.register(connection, selectors.EVENT_READ, worker)
        return worker

    def ready(self) -> Collection[Worker]:
        """Return those that have a message, or have ended."""
        return {key.data for key, _ in self._selector.select(0)}

    def wait(self, timeout: float) -> bool:
        """Wait up to ``timeout`` seconds for one to be ready; may be called from another thread."""
        try:
            return bool(self._selector.select(timeout))
        except (OSError, KeyError, ValueError):  # one is replaced just now
            return True

    def close(self) -> None:
        """Listen to none any more."""
        self._selector.close()


class _WorkerProcess:
    def __init__(
        self, process: subprocess.Popen[bytes], connection: Connection, selector: selectors.BaseSelector
    ) -> None:
        self._process, self._connection, self._selector = process, connection, selector

    @property
    def pid(self) -> int:
        return self._process.pid

    def send(self, data: bytes) -> None:
        self._connection.send_bytes(data)

    def receive(self) -> bytes:
        return self._connection.recv_bytes()

    def end(self, wait_s: float = 0.0) -> int:
        if self._connection.closed:
            return self._process.wait()
        if wait_s:
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(wait_s)
        self._process.kill()
        code = self._process.wait()
        self._selector.unregister(self._connection)
        self._connection.close()
        return code
