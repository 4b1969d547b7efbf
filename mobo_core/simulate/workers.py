"""Simulated workers: the real answer to a candidate, some simulated time later, unless they die, hang or lie."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections import deque
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from mobo_core.coordination.answer import Answering
from mobo_core.coordination.worker_processes import Worker
from mobo_core.messages import UNABLE, Candidate, Evaluation, decode, encode
from mobo_core.simulate.world import Process

# So many evaluations of a trial may be made to fail: one less than it takes for the trial to fail.
MOST_FAILURES = 2
_ONE_ARM_IN = 16


def is_bad(urdf: str) -> bool:
    """Return whether an arm is one that every evaluator rejects."""
    return hashlib.sha256(b"bad" + urdf.encode()).digest()[0] % _ONE_ARM_IN == 0


def honest_answer(answering: Answering, candidate: Candidate) -> Evaluation:
    """Return what an evaluator that does what it should answers."""
    if is_bad(candidate.urdf):
        return answering.refusal(candidate, Evaluation.REJECTED, "bad arm")
    return answering.answer(candidate)


@dataclass
class Manners:
    """What is wrong with an evaluator's workers for the moment.

    Attributes:
        slow: times as long as it should take.
        dies, hangs, lies: share of evaluations.
        unable: answers nothing but that it is unable to.
        deaf: never answers.
    """

    slow: float = 1.0
    dies: float = 0.0
    hangs: float = 0.0
    lies: float = 0.0
    unable: bool = False
    deaf: bool = False


class SimulatedWorkers:
    """Workers of a simulated evaluator.

    Args:
        process: the evaluator; it is asked to collect when a worker has something to say.
        evaluation_s: s that an evaluation takes, more or less.
        kernel_hash: that they say they have.
    """

    def __init__(self, process: Process, evaluation_s: float, kernel_hash: str = "") -> None:
        self.process, self.evaluation_s, self.kernel_hash = process, evaluation_s, kernel_hash
        self.manners = Manners()
        self.collect = lambda: None
        self.random = process.world.chance(f"workers of {process.name} from {process.world.now}")
        self._started: list[_SimulatedWorker] = []

    def start(self, answering: Answering, memory_mb: int) -> Worker:
        """Start one; it is ready some time later."""
        worker = _SimulatedWorker(self, answering)
        self._started.append(worker)
        hello = json.dumps([self.kernel_hash, ["reach", "torque"]]).encode()
        worker.says(hello, self.random.uniform(0.2, 1.0))
        return worker

    def ready(self) -> Collection[Worker]:
        """Return those that have a message, or have ended."""
        return [worker for worker in self._started if worker.inbox or worker.ended]

    def wait(self, timeout: float) -> bool:
        """Wait for nothing: time passes elsewhere."""
        return True

    def close(self) -> None:
        """End."""

    def forget(self, worker: _SimulatedWorker) -> None:
        """Know one that was ended no more."""
        if worker in self._started:
            self._started.remove(worker)


class _SimulatedWorker:
    def __init__(self, workers: SimulatedWorkers, answering: Answering) -> None:
        self._workers, self._answering = workers, answering
        self._world = workers.process.world
        self.inbox: deque[bytes] = deque()
        self.ended = False

    @property
    def pid(self) -> int:
        return 0

    def says(self, data: bytes | None, seconds: float) -> None:
        """Say something, or die, so many s from now."""

        def now() -> None:
            if data is None:
                self.ended = True
            else:
                self.inbox.append(data)
            self._workers.process.do(self._workers.collect)

        self._world.after(seconds, now)

    def send(self, data: bytes) -> None:
        workers, world, manners = self._workers, self._world, self._workers.manners
        seconds = workers.evaluation_s * manners.slow * workers.random.uniform(0.5, 1.5)
        candidate = decode(Candidate, data)
        fate = workers.random.random()
        if manners.deaf:
            return
        if manners.unable:
            answer = self._answering.refusal(candidate, Evaluation.FAILED, f"{UNABLE}no such engine")
            return self.says(encode(answer), seconds)
        if fate < manners.dies + manners.hangs + manners.lies and world.may_fail(candidate.trial, MOST_FAILURES):
            if fate < manners.dies:
                world.say(f"{workers.process.name}: worker with trial {candidate.trial} dies")
                return self.says(None, seconds)
            if fate < manners.dies + manners.hangs:
                world.say(f"{workers.process.name}: worker with trial {candidate.trial} hangs")
                return None
            world.say(f"{workers.process.name}: worker with trial {candidate.trial} lies")
            return self.says(encode(self._lie(self._answering.answer(candidate))), seconds)
        return self.says(encode(honest_answer(self._answering, candidate)), seconds)

    def _lie(self, true: Evaluation) -> Evaluation:
        """Return an answer that shows on its face that it is none."""
        kind = self._workers.random.randrange(5)
        if kind == 0:
            return dataclasses.replace(true, reach=true.reach + 1.0)
        if kind == 1:
            return dataclasses.replace(true, torque=float("nan"))
        if kind == 2:
            return dataclasses.replace(true, voxel_reach=np.zeros(0))
        if kind == 3:
            return dataclasses.replace(true, voxel_torque=-true.voxel_torque)
        return dataclasses.replace(true, status=77)

    def receive(self) -> bytes:
        if self.inbox:
            return self.inbox.popleft()
        raise EOFError

    def end(self, wait_s: float = 0.0) -> int:
        self._workers.forget(self)
        return -9
