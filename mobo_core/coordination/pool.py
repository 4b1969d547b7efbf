"""The workers of one evaluator: started, fed, watched, and replaced when they die."""

from __future__ import annotations

import contextlib
import json
import time
from collections.abc import Callable
from dataclasses import dataclass, field

from mobo_core.coordination.answer import Abilities, Answering
from mobo_core.coordination.worker_processes import Worker, WorkerProcesses, Workers
from mobo_core.messages import Candidate, Evaluation, encode

# A worker that dies while it starts, this many times in a row, will not come up at all.
_MAX_FAILED_STARTS = 3


@dataclass
class _Place:
    worker: Worker
    ready: bool = False
    candidate: Candidate | None = None
    since: float = field(default=0.0)


class WorkerPool:
    """Answers candidates in workers, which are child processes. Not thread-safe but for :meth:`wait`.

    Args:
        answering: how candidates are answered.
        workers: how many.
        timeout_s: a worker busy for longer with one candidate is killed, and the candidate answered FAILED.
        memory_mb: MB of data a worker may hold (RLIMIT_DATA); 0 for no limit.
        clock: seconds, monotonic.
        processes: starts the workers; child processes unless a simulation has others.
    """

    def __init__(
        self,
        answering: Answering,
        workers: int,
        timeout_s: float = 600.0,
        memory_mb: int = 0,
        clock: Callable[[], float] = time.monotonic,
        processes: Workers | None = None,
    ) -> None:
        self.answering = answering
        self._timeout_s, self._memory_mb, self._clock = timeout_s, memory_mb, clock
        self._failed_starts = 0
        self.restarts = 0  # workers replaced so far
        self.abilities = Abilities()  # of the worker that started last
        self._waiting: list[Candidate] = []
        self._processes: Workers = WorkerProcesses() if processes is None else processes
        self._places = [self._start() for _ in range(workers)]

    def __len__(self) -> int:
        """Return the number of workers."""
        return len(self._places)

    @property
    def ready(self) -> int:
        """Number of workers that have started up."""
        return sum(place.ready for place in self._places)

    @property
    def pids(self) -> list[int]:
        """Process ids of the workers."""
        return [place.worker.pid for place in self._places]

    def held(self) -> list[Candidate]:
        """Return the candidates that are being answered or wait for a worker."""
        return [p.candidate for p in self._places if p.candidate is not None] + list(self._waiting)

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
        return self._processes.wait(timeout)

    def collect(self) -> list[bytes]:
        """Return the Evaluation messages (as CDR bytes) that came in, replacing workers that died or hang.

        Raises:
            RuntimeError: the workers cannot start.
        """
        answers: list[bytes] = []
        ready = self._processes.ready()
        for i, place in enumerate(self._places):
            try:
                if place.worker in ready:
                    data = place.worker.receive()
                    if place.ready:
                        answers.append(data)
                        place.candidate = None
                    else:
                        kernel_hash, objectives = json.loads(data)
                        self.abilities = Abilities(kernel_hash, tuple(objectives))
                    place.ready = True
                    self._failed_starts = 0
            except (EOFError, ConnectionResetError, OSError):
                answers += self._replace(i, "")
                continue
            if place.candidate is not None and self._clock() - place.since > self._timeout_s:
                answers += self._replace(i, f"no answer within {self._timeout_s:g} s")
        self._feed()
        return answers

    def close(self) -> None:
        """End all workers at once."""
        for place in self._places:
            place.worker.end()
        self._places = []
        self._processes.close()

    def _start(self) -> _Place:
        return _Place(self._processes.start(self.answering, self._memory_mb))

    def _replace(self, i: int, reason: str) -> list[bytes]:
        place = self._places[i]
        # If its connection has closed it is ending: its own exit code is worth a moment.
        code = place.worker.end(0.0 if reason else 1.0)
        if not place.ready:
            self._failed_starts += 1
            if self._failed_starts >= _MAX_FAILED_STARTS:
                raise RuntimeError(f"workers do not start (exit code {code})")
        self.restarts += 1
        self._places[i] = self._start()
        if place.candidate is None:
            return []
        reason = reason or (f"worker died of signal {-code}" if code < 0 else f"worker ended with code {code}")
        return [encode(self.answering.refusal(place.candidate, Evaluation.FAILED, reason))]

    def _feed(self) -> None:
        for place in self._places:
            if self._waiting and place.ready and place.candidate is None:
                place.candidate, place.since = self._waiting.pop(0), self._clock()
                # If it just died, collect() finds out and answers for it.
                with contextlib.suppress(OSError):
                    place.worker.send(encode(place.candidate))
