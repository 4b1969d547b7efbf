"""The evaluator without its ROS node: candidates in, answers and heartbeats out, as bytes."""

from __future__ import annotations

import os
import re
import socket
from collections.abc import Callable

import numpy as np

from mobo_core.coordination.answer import host_id
from mobo_core.coordination.answers import MAX_NAME
from mobo_core.coordination.health import Health, evaluator_health
from mobo_core.coordination.pool import WorkerPool
from mobo_core.errors import InputError, StudyError
from mobo_core.messages import Candidate, Evaluation, EvaluatorStatus, Trial, address, decode, encode
from mobo_core.version import __version__

HEARTBEAT_S = 1.0

# A URDF and a thousand target poses. So many may wait for a worker: stragglers, and those of another optimizer.
_MAX_CANDIDATE_BYTES = 2_000_000
_MOST_WAITING = 64


def default_name() -> str:
    """Return the name of an evaluator that was given none: ``evaluator_<host>_<pid>``."""
    host = re.sub(r"\W", "_", socket.gethostname(), flags=re.ASCII)
    return f"evaluator_{host}_{os.getpid()}"


class Evaluator:
    """Has a pool's workers answer the candidates that name it, and says that it is there.

    Args:
        pool: its workers, which answer in its name.
        publish: sends bytes on a topic (relative name).
        log: takes lines for people.
        warn: takes lines on what went wrong; a flood of them may come.
    """

    def __init__(
        self,
        pool: WorkerPool,
        publish: Callable[[str, bytes], None],
        log: Callable[[str], None] = print,
        warn: Callable[[str], None] = print,
    ) -> None:
        self._name, self._pool = pool.answering.evaluator, pool
        self._publish, self._log, self._warn = publish, log, warn
        self._answered = 0
        self._announced = False

    def on_candidate(self, data: bytes) -> None:
        """Take a candidate (CDR bytes), if it is for this evaluator."""
        try:
            named = address(data)
            if named.evaluator != self._name:
                return
            self._check_budget(named.study)
            candidate = decode(Candidate, data)
        except InputError as error:
            self._warn(f"candidate ignored: {error}")
            return
        if not self._announced:
            return  # what comes before the first heartbeat was meant for an earlier node of this name
        if len(data) > _MAX_CANDIDATE_BYTES:
            reason = f"candidate: {len(data):,} bytes; expected at most {_MAX_CANDIDATE_BYTES:,}"
            answer = self._pool.answering.refusal(candidate, Evaluation.REJECTED, reason)
            self._publish("evaluations", encode(answer))
            self._answered += 1
        else:
            self._pool.submit(candidate)

    def _check_budget(self, study: str) -> None:
        """See that a candidate's study has a name like others, and that there is room; an optimizer sends it again.

        Raises:
            InputError: there is none.
        """
        held, most = len(self._pool.held()), len(self._pool) + _MOST_WAITING
        if len(study) > MAX_NAME:
            raise InputError(f"{len(study):,} characters", where="study", expected=f"at most {MAX_NAME}")
        if held >= most:
            raise InputError(f"{held} held already", where="candidate", expected=f"at most {most}")

    def on_trial(self, data: bytes) -> None:
        """Take a Trial (CDR bytes): a candidate of it that still waits for a worker is no longer needed."""
        if not self._pool.waiting:
            return
        try:
            told = decode(Trial, data)
        except InputError:
            return
        self._pool.drop(lambda c: not (c.study == told.study and c.trial == told.trial))

    def collect(self) -> None:
        """Publish the answers that came in from workers.

        Raises:
            StudyError: the workers cannot start.
        """
        try:
            answers = self._pool.collect()
        except RuntimeError as error:
            raise StudyError(str(error)) from None
        for answer in answers:
            self._publish("evaluations", answer)
            self._answered += 1
        if not self._announced and self._pool.ready:
            self._announced = True
            self._log(f"{self._name}: {len(self._pool)} workers ready")
            self.beat()

    def beat(self) -> None:
        """Say that this evaluator is there, and what it holds; not before a worker can work."""
        if self._announced:
            self._publish_status(EvaluatorStatus.ALIVE)

    def leave(self) -> None:
        """Say goodbye, so that its candidates go elsewhere at once."""
        if self._announced:
            self._publish_status(EvaluatorStatus.LEFT)

    def health(self) -> Health:
        """Return how well it is."""
        pool = self._pool
        return evaluator_health(
            workers=len(pool), ready=pool.ready, restarts=pool.restarts, held=len(pool.held()), answered=self._answered
        )

    def _publish_status(self, state: int) -> None:
        held = self._pool.held() if state == EvaluatorStatus.ALIVE else []
        status = EvaluatorStatus(
            evaluator=self._name,
            state=state,
            workers=len(self._pool),
            threads=self._pool.answering.threads,
            engine=self._pool.answering.engine,
            kernel_hash=self._pool.abilities.kernel_hash,
            objectives=list(self._pool.abilities.objectives),
            studies=[candidate.study for candidate in held],
            trials=np.array([candidate.trial for candidate in held], np.uint32),
            attempts=np.array([candidate.attempt for candidate in held], np.uint32),
            answered=self._answered,
            mobo_version=__version__,
            host_id=host_id(),
            pid=os.getpid(),
        )
        self._publish("evaluators", encode(status))
