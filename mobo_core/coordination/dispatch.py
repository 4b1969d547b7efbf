"""Which evaluator gets which trial, and which answer counts. Pure logic: time comes in as an argument."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import Enum
from statistics import median
from typing import NamedTuple

# An evaluator's speed is judged by so many of its latest answers.
_TIMES = 15
# A trial is with so many evaluators at a time, at most.
_MAX_LEASES = 2
# Evaluations faster than this do not differ: messages take as long.
_JITTER_S = 0.05
# A straggler has been out for so many times what an idle evaluator takes, and for so many seconds.
_STRAGGLER_FACTOR = 2.0
_STRAGGLER_S = 1.0


class Dispatch(NamedTuple):
    """One sending of a trial to an evaluator."""

    trial: int
    attempt: int
    evaluator: str


class Verdict(Enum):
    """What became of an answer."""

    ACCEPTED = "accepted"
    RETRY = "retry"  # counts as a failed attempt; the trial goes out again
    EXHAUSTED = "exhausted"  # the last attempt allowed has failed; a good answer may still come
    LATE = "late"  # the trial has its answer, or this one says nothing new
    UNKNOWN = "unknown"  # never sent out like this


@dataclass
class _Lease:
    dispatch: Dispatch
    until: float
    since: float


@dataclass
class _Evaluator:
    slots: int = 0
    last_heard: float = 0.0
    # by (trial, attempt): what it was sent, and what it says it has, wanted or not
    leases: dict[tuple[int, int], _Lease] = field(default_factory=dict)
    holds: set[tuple[int, int]] = field(default_factory=set)
    times: deque[float] = field(default_factory=lambda: deque(maxlen=_TIMES))
    typical_s: float = math.nan

    def free(self) -> int:
        return self.slots - len(self.leases.keys() | self.holds)

    def took(self, seconds: float) -> None:
        self.times.append(seconds)
        self.typical_s = median(self.times)


@dataclass
class _Trial:
    attempts: int = 0
    failed: set[Dispatch] = field(default_factory=set)
    leases: dict[int, _Lease] = field(default_factory=dict)
    unable: set[str] = field(default_factory=set)
    sent: set[Dispatch] = field(default_factory=set)

    def failed_on(self) -> set[str]:
        return {dispatch.evaluator for dispatch in self.failed}


class Dispatcher:
    """Hands open trials to evaluators and judges their answers.

    A trial goes to one evaluator under a lease, which heartbeats that name it renew. A lease that runs out, an
    evaluator that leaves or falls silent, or one that does not know of a candidate it was sent, puts the trial
    back, to go to another evaluator if there is one; a heartbeat that names it while it waits takes it up again.
    Only answers that say FAILED and evaluations that take too long count against ``max_attempts``: a lost
    evaluator says nothing of the arm.

    A trial that has used up its attempts goes out no more, but a good answer to any of its sendings still counts
    until the trial is told, which :meth:`close` says.

    Places go to the lowest trial first, at the fastest evaluators by a factor of two, then where most are free.
    What an evaluator holds fills its places, whether it is still wanted or not.

    **Stragglers.** An ordered study soon waits for its oldest open trial, and at its end for the last one. So
    when nothing waits and a place is free (whoever calls has then opened all the trials it may), a trial that
    has been out for longer than 1 s and twice what an idle evaluator typically takes (the median of its latest
    answers) goes to that one too, the oldest trial first. No trial is with more than two evaluators at a time,
    and of their answers the first valid one counts.

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
        self.evaluation_timeout_s = evaluation_timeout_s
        self._silence_s, self._grace_s = min(silence_s, lease_s), grace_s
        self._evaluators: dict[str, _Evaluator] = {}
        self._open: dict[int, _Trial] = {}
        self._exhausted: dict[int, _Trial] = {}
        self._queue: list[int] = []

    @property
    def evaluators(self) -> dict[str, int]:
        """The evaluators alive and how many candidates each takes at a time."""
        return {name: e.slots for name, e in self._evaluators.items()}

    @property
    def waiting(self) -> int:
        """How many open trials are with no evaluator."""
        return len(self._queue)

    @property
    def open_trials(self) -> set[int]:
        """The trials without an answer that have attempts left."""
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
        new = evaluator not in self._evaluators
        known = self._evaluators.setdefault(evaluator, _Evaluator())
        known.slots, known.last_heard, known.holds = slots, now, set(holds)
        for place, lease in list(known.leases.items()):
            if place in known.holds:
                lease.until = now + self._lease_s
            elif now - lease.since > self._grace_s:
                # Sent but not there: the message was lost, or its answer was.
                self._drop(lease.dispatch)
        for trial, attempt in sorted(known.holds):
            record, dispatch = self._open.get(trial), Dispatch(trial, attempt, evaluator)
            if record is not None and not record.leases and dispatch in record.sent - record.failed:
                self._queue.remove(trial)
                self._lease(dispatch, now)
        return new

    def left(self, evaluator: str) -> list[Dispatch]:
        """Take an evaluator's goodbye; return the dispatches that end with it."""
        if evaluator not in self._evaluators:
            return []
        ended = [lease.dispatch for lease in self._evaluators[evaluator].leases.values()]
        for dispatch in ended:
            self._drop(dispatch)
        del self._evaluators[evaluator]
        return ended

    def expire(self, now: float) -> tuple[list[str], list[Dispatch]]:
        """Let time pass: return the evaluators lost since, and what takes too long, to be judged as a failed answer."""
        lost = [name for name, e in self._evaluators.items() if now - e.last_heard > self._silence_s]
        for name in lost:
            self.left(name)
        overdue = []
        for lease in [lease for e in self._evaluators.values() for lease in e.leases.values()]:
            if now - lease.since > self.evaluation_timeout_s:
                overdue.append(lease.dispatch)
            elif now > lease.until:
                self._drop(lease.dispatch)
        return lost, overdue

    def next_dispatches(self, now: float) -> list[Dispatch]:
        """Hand out queued trials, lowest number first, then stragglers once more; see the class."""
        free = {name: places for name, e in self._evaluators.items() if (places := e.free()) > 0}
        if not free:
            return []
        sent = []
        for trial in list(self._queue):
            record = self._open[trial]
            # An evaluator it failed on comes last, and is left out while another is alive.
            failed_on = record.failed_on()
            able = [name for name in free if name not in record.unable]
            fit = [name for name in able if name not in failed_on]
            if not fit and any(name not in failed_on | record.unable for name in self._evaluators):
                continue
            if able:
                self._queue.remove(trial)
                sent.append(self._send(trial, fit or able, free, now))
        for trial in sorted(self._open):
            if fit := [name for name in free if self._is_straggler(self._open[trial], name, now)]:
                sent.append(self._send(trial, fit, free, now))
        return sent

    def matters(self, dispatch: Dispatch, *, ok: bool) -> bool:
        """Return whether such an answer would change anything."""
        if (record := self._open.get(dispatch.trial)) is not None:
            return dispatch in record.sent and (ok or dispatch not in record.failed)
        return ok and self._redeems(dispatch)

    def answered(
        self, dispatch: Dispatch, now: float, *, ok: bool, unable: bool = False, overdue: bool = False
    ) -> Verdict:
        """Judge an answer: the first one that is ``ok`` of any sending of a trial not told counts.

        Without ``ok`` the answer says that this evaluator could not do it. If it was ``unable`` to, whatever
        the arm, that does not count against the trial, which will not go to it again. What is ``overdue`` is no
        answer: the evaluator still works on it.
        """
        if not overdue and dispatch.evaluator in self._evaluators:
            self._evaluators[dispatch.evaluator].holds.discard((dispatch.trial, dispatch.attempt))
        record = self._open.get(dispatch.trial)
        if record is None:
            if not (ok and self._redeems(dispatch)):
                return Verdict.LATE
            self.close(dispatch.trial)
            return Verdict.ACCEPTED
        if dispatch not in record.sent:
            return Verdict.UNKNOWN
        if ok:
            for lease in record.leases.values():
                # One that was overtaken would have taken longer still, which says enough of it.
                self._evaluators[lease.dispatch.evaluator].took(now - lease.since)
            self._drop(dispatch)
            self.close(dispatch.trial)
            return Verdict.ACCEPTED
        if dispatch in record.failed:
            return Verdict.LATE
        if unable:
            record.unable.add(dispatch.evaluator)
            self._drop(dispatch)
            return Verdict.RETRY
        return Verdict.EXHAUSTED if self._fail(dispatch) else Verdict.RETRY

    def close(self, trial: int) -> None:
        """End a trial: no answer to it counts from now on."""
        self._exhausted.pop(trial, None)
        record = self._open.pop(trial, None)
        if record is None:
            return
        if trial in self._queue:
            self._queue.remove(trial)
        for attempt, lease in record.leases.items():
            evaluator = self._evaluators[lease.dispatch.evaluator]
            del evaluator.leases[trial, attempt]
            evaluator.holds.add((trial, attempt))  # until its next heartbeat says otherwise

    def _typical_s(self, name: str) -> float:
        """Return what an evaluation takes on an evaluator, or on the median one if it has not answered yet."""
        own = self._evaluators[name].typical_s
        if not math.isnan(own):
            return own
        known = [e.typical_s for e in self._evaluators.values() if not math.isnan(e.typical_s)]
        return median(known) if known else math.inf

    def _is_straggler(self, record: _Trial, name: str, now: float) -> bool:
        """Return whether a trial shall go to an idle evaluator too."""
        if not 0 < len(record.leases) < _MAX_LEASES:
            return False
        asked = {lease.dispatch.evaluator for lease in record.leases.values()} | record.failed_on() | record.unable
        since = min(lease.since for lease in record.leases.values())
        patience_s = max(_STRAGGLER_S, _STRAGGLER_FACTOR * self._typical_s(name))
        return name not in asked and now - since > patience_s

    def _send(self, trial: int, fit: list[str], free: dict[str, int], now: float) -> Dispatch:
        """Send a trial to the best of the evaluators ``fit``, and take its place from ``free``."""
        times = {name: max(_JITTER_S, self._typical_s(name)) for name in fit}
        fastest = min(times.values())
        slower = {name: int(math.log2(times[name] / fastest)) if math.isfinite(fastest) else 0 for name in fit}
        name = min(fit, key=lambda e: (slower[e], -free[e], e))
        free[name] -= 1
        if not free[name]:
            del free[name]
        record = self._open[trial]
        record.attempts += 1
        dispatch = Dispatch(trial, record.attempts, name)
        record.sent.add(dispatch)
        self._lease(dispatch, now)
        return dispatch

    def _lease(self, dispatch: Dispatch, now: float) -> None:
        lease = _Lease(dispatch, now + self._lease_s, now)
        self._open[dispatch.trial].leases[dispatch.attempt] = lease
        self._evaluators[dispatch.evaluator].leases[dispatch.trial, dispatch.attempt] = lease

    def _drop(self, dispatch: Dispatch) -> None:
        """End a lease, if it has not ended yet; without any, the trial waits again."""
        record = self._open[dispatch.trial]
        if record.leases.pop(dispatch.attempt, None) is not None:
            self._evaluators[dispatch.evaluator].leases.pop((dispatch.trial, dispatch.attempt), None)
        if not record.leases and dispatch.trial not in self._queue:
            self._queue.append(dispatch.trial)
            self._queue.sort()

    def _redeems(self, dispatch: Dispatch) -> bool:
        """Return whether a good answer to a sending is still of use to a trial that used up its attempts."""
        record = self._exhausted.get(dispatch.trial)
        return record is not None and dispatch in record.sent

    def _fail(self, dispatch: Dispatch) -> bool:
        record = self._open[dispatch.trial]
        record.failed.add(dispatch)
        self._drop(dispatch)
        if len(record.failed) < self._max_attempts:
            return False
        self.close(dispatch.trial)
        self._exhausted[dispatch.trial] = record
        return True
