"""A process that belongs to no study, and talks all the same."""

from __future__ import annotations

import dataclasses
from collections import deque

import numpy as np

from mobo_core.coordination.answer import Answering
from mobo_core.messages import Candidate, Evaluation, EvaluatorStatus, decode, encode
from mobo_core.simulate.network import Network
from mobo_core.simulate.world import Process, World


class Stranger(Process):
    """Listens to all, and sends what no evaluator would.

    What it never does is to answer what was sent, in the name of whom it was sent to, with values that add up: nobody
    could tell but by evaluating again, as ``mobo verify`` does.

    Args:
        world, name, host: as of any process.
        network: it hears and is heard on.
    """

    def __init__(self, world: World, name: str, host: str, network: Network) -> None:
        super().__init__(world, name, host)
        self._network, self._random = network, world.chance(name)
        self._joins = self._random.random() < 0.5  # as an evaluator; then it answers nothing in its own name
        self._candidates: deque[Candidate] = deque(maxlen=30)
        self._answers: deque[bytes] = deque(maxlen=30)
        network.subscribe(self, "candidates", lambda data: self._candidates.append(decode(Candidate, data)))
        network.subscribe(self, "evaluations", self._answers.append)
        self.every(0.25, self._talk)

    def _talk(self) -> None:
        random, kind = self._random, self._random.randrange(7)
        if kind == 0 and self._answers:
            self._network.publish(self, "evaluations", random.choice(self._answers))
        elif kind == 1 and self._answers:
            data = random.choice(self._answers)
            self._network.publish(self, "evaluations", data[: int(len(data) * random.random())])
        elif kind == 2:
            self._network.publish(self, random.choice(("evaluations", "evaluators")), random.randbytes(100))
        elif self._candidates:
            candidate = random.choice(self._candidates)
            if kind in (3, 4):
                self._network.publish(self, "evaluations", encode(self._false_answer(candidate)))
            else:
                self._beat(candidate, own=kind == 5 and self._joins)

    def _false_answer(self, candidate: Candidate) -> Evaluation:
        """Return values that add up, of a sending that never was."""
        true = Answering(candidate.evaluator, "simulated", simulated_s=0.0).answer(candidate)
        wrong = dataclasses.replace(true, torque=0.0, voxel_torque=np.zeros(len(true.voxel_torque)))
        random = self._random
        return dataclasses.replace(wrong, **random.choice((
            {"attempt": candidate.attempt + 500} if self._joins else {"evaluator": self.name},
            {"attempt": candidate.attempt + 1000},
            {"trial": candidate.trial + 10_000},
            {"study": "another"},
        )))  # fmt: skip

    def _beat(self, candidate: Candidate, *, own: bool) -> None:
        """Say that an evaluator, or this, has what it has not; or that an evaluator leaves."""
        random = self._random
        trials = np.array([candidate.trial + random.randrange(2)], np.uint32)
        status = EvaluatorStatus(
            evaluator=self.name if own else candidate.evaluator,
            state=EvaluatorStatus.LEFT if random.random() < 0.2 else EvaluatorStatus.ALIVE,
            workers=random.randint(1, 3), engine="simulated", studies=[candidate.study], trials=trials,
            attempts=np.array([random.randint(1, 3)], np.uint32),
        )  # fmt: skip
        self._network.publish(self, "evaluators", encode(status))
