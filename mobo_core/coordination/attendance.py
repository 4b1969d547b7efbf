"""Which evaluators a study has: who joined, left and was lost, as its bag records it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from mobo_core.bag.study_bag import StudyBag
from mobo_core.coordination.admission import Admission
from mobo_core.coordination.answers import read_heartbeat
from mobo_core.coordination.dispatch import Dispatcher
from mobo_core.errors import InputError
from mobo_core.messages import EvaluatorStatus
from mobo_core.version import __version__


class Attendance:
    """Takes heartbeats and goodbyes: lets evaluators in, and tells the dispatcher what they have.

    Args:
        bag: of the study.
        admission: says who may have work.
        dispatcher: hands it out.
        log: takes lines for people.
        warn: takes lines on what went wrong.
    """

    def __init__(
        self,
        bag: StudyBag,
        admission: Admission,
        dispatcher: Dispatcher,
        log: Callable[[str], None],
        warn: Callable[[str], None],
    ) -> None:
        self._bag, self._admission, self._dispatcher = bag, admission, dispatcher
        self._log, self._warn = log, warn

    def heard(self, data: bytes, now: float) -> bool:
        """Take a heartbeat (CDR bytes of an EvaluatorStatus); return whether it is of an evaluator that may work."""
        try:
            status = read_heartbeat(data)
        except InputError as error:
            self._warn(f"heartbeat ignored: {error}")
            return False
        name = status.evaluator
        if status.state == EvaluatorStatus.LEFT:
            if name in self._dispatcher.evaluators:
                self._record(status, EvaluatorStatus.LEFT)
                self._log(f"{name} left")
            self._dispatcher.left(name)
        elif status.state == EvaluatorStatus.ALIVE:
            holds = [
                (int(trial), int(attempt))
                for study, trial, attempt in zip(status.studies, status.trials, status.attempts, strict=True)
                if study == self._bag.name
            ]
            if name not in self._dispatcher.evaluators and not self._admission.admits(status, now):
                return False
            if self._dispatcher.heard(name, status.workers, holds, now):
                self._record(status, EvaluatorStatus.JOINED)
                version = status.mobo_version or "of an unknown version"
                other = "" if version == __version__ else f", another than here ({__version__})"
                say = self._warn if other else self._log
                say(f"{name} joined: {status.workers} workers, {status.engine}, mobo {version}{other}")
        return True

    def lost(self, name: str) -> None:
        """Record that an evaluator fell silent."""
        self._record(EvaluatorStatus(evaluator=name), EvaluatorStatus.LOST)
        self._warn(f"{name} lost: its candidates go to others")

    def _record(self, status: EvaluatorStatus, state: int) -> None:
        none = np.empty(0, np.uint32)
        self._bag.append("evaluators", replace(status, state=state, studies=[], trials=none, attempts=none))
