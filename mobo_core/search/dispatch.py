"""Which evaluator gets which trial, and which answer counts. Pure logic: time comes in as an argument."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import Enum
from typing import NamedTuple


class Dispatch(NamedTuple):
    """One sending of a trial to an evaluator."""

    trial: int
    attempt: int
    evaluator: str


class Verdict(Enum):
    """What became of an answer."""

    ACCEPTED = "accepted"
    RETRY = "retry"  # counts as a failed attempt; the trial goes out again
    EXHAUSTED = "exhausted"  # the last attempt allowed has failed
    LATE = "late"  # the trial has its answer
    UNKNOWN = "unknown"  # never sent out like this


@dataclass
class _Evaluator:
    slots: int
    last_heard: float
    silent: bool = False


@dataclass
class _Lease:
    dispatch: Dispatch
    until: float
    since: float


@dataclass
class _Trial:
    attempts: int = 0
    failed: set[Dispatch] = field(default_factory=set)
    leases: dict[int, _Lease] = field(default_factory=dict)
    unable: set[str] = field(default_factory=set)
    sent: set[Dispatch] = field(default_factory=set)


class Dispatcher:
    """Hands open trials to evaluators and judges their answers.

    A trial goes to one evaluator at a time under a lease, which heartbeats that name it renew. A lease
    that runs out, an evaluator that leaves or falls silent, or one that does not know of a candidate it was
    sent, puts the trial back, to go to another evaluator if there is one. Only answers that say FAILED and
    evaluations that take too long count against ``max_attempts``: a lost evaluator says nothing of the arm.

    Args:
        lease_s: seconds a lease lasts without a heartbeat that names its candidate.
        max_attempts: failed attempts after which a trial has failed.
        evaluation_timeout_s: seconds an evaluation may take, heartbeats or not.
        silence_s: an evaluator not heard of for so long is lost.
        grace_s: an evaluator whose heartbeat does not name a candidate sent so long ago never got it.
    """

    def __init__(
        self,
        *,
        lease_s: float = 10.0,
        max_attempts: int = 3,
        evaluation_timeout_s: float = 600.0,
        silence_s: float = 4.0,
        grace_s: float = 2.0,
    ) -> None:
        self._lease_s, self._max_attempts = lease_s, max_attempts
        self._timeout_s, self._silence_s, self._grace_s = evaluation_timeout_s, min(silence_s, lease_s), grace_s
        self._evaluators: dict[str, _Evaluator] = {}
        self._open: dict[int, _Trial] = {}
        self._queue: list[int] = []

    @property
    def evaluators(self) -> dict[str, int]:
        """The evaluators alive and how many candidates each takes at a time."""
        return {name: e.slots for name, e in self._evaluators.items() if not e.silent}

    @property
    def waiting(self) -> int:
        """How many trials without an answer are with no evaluator."""
        return len(self._queue)

    @property
    def open_trials(self) -> set[int]:
        """The trials without an answer."""
        return set(self._open)

    def open(self, trial: int, sent: Iterable[Dispatch] = ()) -> None:
        """Add a trial to be evaluated; ``sent`` are dispatches of it that a record knows of."""
        record = _Trial(sent=set(sent))
        record.attempts = max((d.attempt for d in record.sent), default=0)
        self._open[trial] = record
        self._queue.append(trial)
        self._queue.sort()

    def heard(self, evaluator: str, slots: int, holds: Iterable[tuple[int, int]], now: float) -> bool:
        """Take a heartbeat that names the (trial, attempt) it holds; return whether the evaluator is new."""
        known = self._evaluators.get(evaluator)
        new = known is None or known.silent
        self._evaluators[evaluator] = _Evaluator(slots, now)
        held = set(holds)
        for trial, record in self._open.items():
            for attempt, lease in list(record.leases.items()):
                if lease.dispatch.evaluator != evaluator:
                    continue
                if (trial, attempt) in held:
                    lease.until = now + self._lease_s
                elif now - lease.since > self._grace_s:
                    # Sent but not there: the message was lost, or its answer was.
                    self._drop(trial, attempt)
        return new

    def left(self, evaluator: str) -> list[Dispatch]:
        """Take an evaluator's goodbye; return the dispatches that end with it."""
        self._evaluators.pop(evaluator, None)
        return self._release(evaluator)

    def expire(self, now: float) -> tuple[list[str], list[int]]:
        """Let time pass: return the evaluators lost since, and the trials that used up their attempts."""
        lost = []
        for name, evaluator in list(self._evaluators.items()):
            if now - evaluator.last_heard > self._silence_s and not evaluator.silent:
                evaluator.silent = True
                lost.append(name)
                self._release(name)
        exhausted = []
        for trial, record in list(self._open.items()):
            for attempt, lease in list(record.leases.items()):
                if now - lease.since > self._timeout_s:
                    if self._fail(lease.dispatch):
                        exhausted.append(trial)
                        break
                elif now > lease.until:
                    self._drop(trial, attempt)
        return lost, exhausted

    def next_dispatches(self, now: float) -> list[Dispatch]:
        """Hand out queued trials, lowest number first, to the evaluators with most free places."""
        busy = dict.fromkeys(self._evaluators, 0)
        for record in self._open.values():
            for lease in record.leases.values():
                if lease.dispatch.evaluator in busy:
                    busy[lease.dispatch.evaluator] += 1
        free = {name: e.slots - busy[name] for name, e in self._evaluators.items() if not e.silent}
        free = {name: places for name, places in free.items() if places > 0}
        sent = []
        for trial in list(self._queue):
            if not free:
                break
            record = self._open[trial]
            # An evaluator it failed on comes last, and is left out while another is alive.
            able = [name for name in free if name not in record.unable]
            failed_on = {dispatch.evaluator for dispatch in record.failed}
            fit = [name for name in able if name not in failed_on]
            if not fit and any(name not in failed_on | record.unable for name in self.evaluators):
                continue
            if not able:
                continue
            name = min(fit or able, key=lambda e: (-free[e], e))
            record.attempts += 1
            dispatch = Dispatch(trial, record.attempts, name)
            record.leases[dispatch.attempt] = _Lease(dispatch, now + self._lease_s, now)
            record.sent.add(dispatch)
            self._queue.remove(trial)
            free[name] -= 1
            if not free[name]:
                del free[name]
            sent.append(dispatch)
        return sent

    def answered(self, dispatch: Dispatch, *, ok: bool, unable: bool = False) -> Verdict:
        """Judge an answer: the first one that is ``ok`` of any sending of an open trial counts.

        Without ``ok`` the answer says that this evaluator could not do it. If it was ``unable`` to, whatever
        the arm, that does not count against the trial, which will not go to it again.
        """
        record = self._open.get(dispatch.trial)
        if record is None:
            return Verdict.LATE
        if dispatch not in record.sent:
            return Verdict.UNKNOWN
        if ok:
            self.close(dispatch.trial)
            return Verdict.ACCEPTED
        if dispatch in record.failed:
            return Verdict.LATE
        if unable:
            record.unable.add(dispatch.evaluator)
            self._drop(dispatch.trial, dispatch.attempt)
            return Verdict.RETRY
        return Verdict.EXHAUSTED if self._fail(dispatch) else Verdict.RETRY

    def close(self, trial: int) -> None:
        """End a trial: no answer to it counts from now on."""
        self._open.pop(trial, None)
        if trial in self._queue:
            self._queue.remove(trial)

    def _release(self, evaluator: str) -> list[Dispatch]:
        ended = []
        for trial, record in self._open.items():
            for attempt, lease in list(record.leases.items()):
                if lease.dispatch.evaluator == evaluator:
                    ended.append(lease.dispatch)
                    self._drop(trial, attempt)
        return ended

    def _drop(self, trial: int, attempt: int) -> None:
        record = self._open[trial]
        record.leases.pop(attempt, None)
        if not record.leases and trial not in self._queue:
            self._queue.append(trial)
            self._queue.sort()

    def _fail(self, dispatch: Dispatch) -> bool:
        record = self._open[dispatch.trial]
        record.failed.add(dispatch)
        if len(record.failed) >= self._max_attempts:
            self.close(dispatch.trial)
            return True
        self._drop(dispatch.trial, dispatch.attempt)
        return False
