"""The workers of one evaluator: started, fed, watched, and replaced when they die."""

from __future__ import annotations

import contextlib
import json
import os
import selectors
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from multiprocessing.connection import Connection

from mobo_core.coordination.answer import Abilities, Answering
from mobo_core.messages import Candidate, Evaluation, encode

# A worker that dies while it starts, this many times in a row, will not come up at all.
_MAX_FAILED_STARTS = 3


@dataclass
class _Worker:
    process: subprocess.Popen[bytes]
    connection: Connection
    ready: bool = False
    candidate: Candidate | None = None
    since: float = field(default=0.0)


class WorkerPool:
    """Answers candidates in child processes. Not thread-safe but for :meth:`wait`.

    Args:
        answering: how candidates are answered.
        workers: number of child processes.
        timeout_s: a worker busy for longer with one candidate is killed, and the candidate answered FAILED.
        memory_mb: MB of data a worker may hold (RLIMIT_DATA); 0 for no limit.
        clock: seconds, monotonic.
    """

    def __init__(
        self,
        answering: Answering,
        workers: int,
        timeout_s: float = 600.0,
        memory_mb: int = 0,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.answering = answering
        self._timeout_s, self._memory_mb, self._clock = timeout_s, memory_mb, clock
        self._failed_starts = 0
        self.restarts = 0  # workers replaced so far
        self.abilities = Abilities()  # of the worker that started last
        self._waiting: list[Candidate] = []
        self._selector = selectors.DefaultSelector()
        self._workers = [self._start() for _ in range(workers)]

    def __len__(self) -> int:
        """Return the number of workers."""
        return len(self._workers)

    @property
    def ready(self) -> int:
        """Number of workers that have started up."""
        return sum(worker.ready for worker in self._workers)

    @property
    def pids(self) -> list[int]:
        """Process ids of the workers."""
        return [worker.process.pid for worker in self._workers]

    def held(self) -> list[Candidate]:
        """Return the candidates that are being answered or wait for a worker."""
        return [w.candidate for w in self._workers if w.candidate is not None] + list(self._waiting)

    def submit(self, candidate: Candidate) -> None:
        """Take a candidate; it waits if all workers are busy."""
        self._waiting.append(candidate)
        self._feed()

    @property
    def waiting(self) -> int:
        """Number of candidates that wait for a worker."""
        return len(self._waiting)

    def drop(self, keep: Callable[[Candidate], bool]) -> None:
        """Forget the waiting candidates that ``keep`` does not hold for."""
        self._waiting = [candidate for candidate in self._waiting if keep(candidate)]

    def wait(self, timeout: float) -> bool:
        """Wait up to ``timeout`` seconds for something to :meth:`collect`; may be called from another thread."""
        try:
            return bool(self._selector.select(timeout))
        except (OSError, KeyError, ValueError):  # collect() replaces a worker just now
            return True

    def collect(self) -> list[bytes]:
        """Return the Evaluation messages (as CDR bytes) that came in, replacing workers that died or hang.

        Raises:
            RuntimeError: the workers cannot start.
        """
        answers: list[bytes] = []
        ready = {key.fileobj for key, _ in self._selector.select(0)}
        for i, worker in enumerate(self._workers):
            try:
                if worker.connection in ready:
                    data = worker.connection.recv_bytes()
                    if worker.ready:
                        answers.append(data)
                        worker.candidate = None
                    else:
                        kernel_hash, objectives = json.loads(data)
                        self.abilities = Abilities(kernel_hash, tuple(objectives))
                    worker.ready = True
                    self._failed_starts = 0
            except (EOFError, ConnectionResetError, OSError):
                answers += self._replace(i, "")
                continue
            if worker.candidate is not None and self._clock() - worker.since > self._timeout_s:
                answers += self._replace(i, f"no answer within {self._timeout_s:g} s")
        self._feed()
        return answers

    def close(self) -> None:
        """End all workers at once."""
        for worker in self._workers:
            worker.process.kill()
            worker.connection.close()
        for worker in self._workers:
            worker.process.wait()
        self._workers = []
        self._selector.close()

    def _start(self) -> _Worker:
        ours, theirs = socket.socketpair()
        with theirs:
            numbers = (theirs.fileno(), os.getpid(), self._memory_mb)
            command = [sys.executable, "-m", "mobo_core.coordination.worker", *map(str, numbers)]
            process = subprocess.Popen(command, pass_fds=[theirs.fileno()], stdin=subprocess.DEVNULL)
        connection = Connection(ours.detach())
        # If it has died already, collect() finds out.
        with contextlib.suppress(OSError):
            connection.send(self.answering)
        self._selector.register(connection, selectors.EVENT_READ)
        return _Worker(process, connection)

    def _replace(self, i: int, reason: str) -> list[bytes]:
        worker = self._workers[i]
        if not reason:
            # Its connection has closed, so it is ending: its own exit code is worth a moment.
            with contextlib.suppress(subprocess.TimeoutExpired):
                worker.process.wait(1.0)
        worker.process.kill()
        code = worker.process.wait()
        self._selector.unregister(worker.connection)
        worker.connection.close()
        if not worker.ready:
            self._failed_starts += 1
            if self._failed_starts >= _MAX_FAILED_STARTS:
                raise RuntimeError(f"workers do not start (exit code {code})")
        self.restarts += 1
        self._workers[i] = self._start()
        if worker.candidate is None:
            return []
        reason = reason or (f"worker died of signal {-code}" if code < 0 else f"worker ended with code {code}")
        return [encode(self.answering.refusal(worker.candidate, Evaluation.FAILED, reason))]

    def _feed(self) -> None:
        for worker in self._workers:
            if self._waiting and worker.ready and worker.candidate is None:
                worker.candidate, worker.since = self._waiting.pop(0), self._clock()
                # If it just died, collect() finds out and answers for it.
                with contextlib.suppress(OSError):
                    worker.connection.send_bytes(encode(worker.candidate))
