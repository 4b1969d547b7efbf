"""Watches how a simulated optimizer hands out work: against what its evaluators said they have."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass

from mobo_core.coordination.dispatch import Dispatcher
from mobo_core.coordination.evaluator import HEARTBEAT_S
from mobo_core.coordination.leases import LiveEvaluator
from mobo_core.errors import MoboError
from mobo_core.messages import Evaluation, EvaluatorStatus, decode
from mobo_core.simulate.violation import Violation


@dataclass
class _Heard:
    """What an evaluator said last: when, how many places it has, and what it holds, without what it answered since."""

    at: float
    places: int
    holds: set[tuple[int, int]]


class WorkWatch:
    """Hears what the optimizer hears, and looks at leases and places.

    Args:
        study: its name.
        dispatcher: that of the optimizer.
    """

    def __init__(self, study: str, dispatcher: Dispatcher) -> None:
        self._study, self._dispatcher = study, dispatcher
        self._heard: dict[str, _Heard] = {}
        self._leased: dict[tuple[int, int, str], LiveEvaluator] = {}

    def heard(self, data: bytes, now: float) -> None:
        """Take what may be a heartbeat."""
        with contextlib.suppress(MoboError):
            status = decode(EvaluatorStatus, data)
            named = zip(status.studies, status.trials, status.attempts, strict=True)
            holds = {(int(trial), int(attempt)) for study, trial, attempt in named if study == self._study}
            if status.state == EvaluatorStatus.ALIVE:
                self._heard[status.evaluator] = _Heard(now, status.workers, holds)
            else:
                self._heard.pop(status.evaluator, None)

    def answered(self, data: bytes) -> None:
        """Take what may be an answer."""
        with contextlib.suppress(MoboError):
            answer = decode(Evaluation, data)
            if (heard := self._heard.get(answer.evaluator)) is not None:
                heard.holds.discard((answer.trial, answer.attempt))

    def sent(self, name: str) -> None:
        """See that what an evaluator was sent, and what it says it has, wanted or not, is no more than its places."""
        known, heard = self._dispatcher._evaluators[name], self._heard.get(name)
        if heard is not None and len(held := known.leases.keys() | heard.holds) > heard.places:
            raise Violation("places", f"{name} has {heard.places} places, and is to have {len(held)} candidates")

    def look(self, now: float) -> None:
        """See that no lease has ended of which an evaluator said just now that it has the candidate."""
        alive, opened = self._dispatcher._evaluators, self._dispatcher._open
        for lease, evaluator in self._leased.items():
            trial, attempt, name = lease
            if trial not in opened or alive.get(name) is not evaluator or not evaluator.is_proven:
                continue
            said, record = self._heard.get(name), opened[trial]
            still = attempt in record.leases or name in record.failed_on() | record.unable
            if said and not still and now - said.at < HEARTBEAT_S and (trial, attempt) in said.holds:
                raise Violation("leases", f"{name} has trial {trial} and says so, but its lease has ended")
        self._leased = {
            (trial, attempt, lease.dispatch.evaluator): alive[lease.dispatch.evaluator]
            for trial, record in opened.items()
            for attempt, lease in record.leases.items()
        }
        if any(len(record.leases) > 2 for record in opened.values()):
            raise Violation("leases", "a trial is with three evaluators")
