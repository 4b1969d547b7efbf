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
# s that an optimizer gives an evaluation; evaluators may give it more.
EVALUATION_TIMEOUT_S = 100.0
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
        dawdles: share of evaluations that take longer than the optimizer waits, if they end at all.
        fails: share of trials of which no evaluation comes to anything.
        deceives: share of evaluations answered by what is false, and does not look it.
        unable: answers nothing but that it is unable to.
        deaf: never answers.
    """

    slow: float = 1.0
    dies: float = 0.0
    hangs: float = 0.0
    lies: float = 0.0
    dawdles: float = 0.0
    fails: float = 0.0
    deceives: float = 0.0
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
        name, number = workers.process.name, candidate.trial
        misdeed = self._misdeed(number, fate)
        if misdeed:
            world.say(f"{name}: worker with trial {number} {misdeed}")
        if misdeed == "dies":
            return self.says(None, seconds)
        if misdeed == "hangs":
            return None
        if misdeed == "lies":
            return self.says(encode(self._lie(self._answering.answer(candidate))), seconds)
        if misdeed == "deceives":
            data = encode(self._deception(candidate))
            world.lies.add(data)
            return self.says(data, seconds)
        if misdeed == "dawdles":
            seconds = EVALUATION_TIMEOUT_S * workers.random.uniform(1.05, 2.0)
        return self.says(encode(honest_answer(self._answering, candidate)), seconds)

    def _misdeed(self, trial: int, fate: float) -> str:
        """Return what comes in place of an evaluation of a trial, or "".

        Args:
            trial: its number.
            fate: 0 to 1, drawn for this evaluation.
        """
        manners, world, random = self._workers.manners, self._world, self._workers.random
        if manners.fails and world.chance(f"trial {trial} fails").random() < manners.fails:
            return random.choice(("dies", "hangs", "lies"))
        # What shows or takes too long counts against the trial.
        for name in ("dies", "hangs", "lies", "dawdles"):
            if fate < getattr(manners, name):
                if not world.may_fail(trial, MOST_FAILURES):
                    return ""
                return random.choice(("hangs", "dawdles")) if name == "dawdles" else name
            fate -= getattr(manners, name)
        return "deceives" if fate < manners.deceives else ""

    def _deception(self, candidate: Candidate) -> Evaluation:
        """Return an answer that is false, and that only evaluating again shows to be."""
        random = self._workers.random
        if not is_bad(candidate.urdf) and random.random() < 0.3:
            return self._answering.refusal(candidate, Evaluation.REJECTED, "bad arm, or so I say")
        return self._answering.answer(dataclasses.replace(candidate, urdf=f"{candidate.urdf}{random.random()}"))

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
