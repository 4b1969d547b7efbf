"""Who has what: the sendings of trials, and the leases under which evaluators have them."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field
from enum import Enum
from statistics import median
from typing import NamedTuple

# An evaluator's speed is judged by so many of its latest answers.
_TIMES = 15


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
class Lease:
    """What keeps a trial with an evaluator: until when, unless it is renewed, and since when."""

    dispatch: Dispatch
    until: float
    since: float


@dataclass
class LiveEvaluator:
    """An evaluator that is alive."""

    slots: int = 0
    last_heard: float = 0.0
    # by (trial, attempt): what it was sent, and what it says it has, wanted or not
    leases: dict[tuple[int, int], Lease] = field(default_factory=dict)
    holds: set[tuple[int, int]] = field(default_factory=set)
    # Whether it ever answered, sendings since it did, and its place in the order in which evaluators joined.
    is_proven: bool = False
    unanswered: int = 0
    joined: int = 0
    times: deque[float] = field(default_factory=lambda: deque(maxlen=_TIMES))
    typical_s: float = math.nan

    def free(self) -> int:
        """Return how many of its places are."""
        return self.slots - len(self.leases.keys() | self.holds)

    def replied(self, place: tuple[int, int]) -> None:
        """Take that it answered what it had, whatever it said."""
        self.holds.discard(place)
        self.is_proven, self.unanswered = True, 0

    def took(self, seconds: float) -> None:
        """Take what an evaluation took."""
        self.times.append(seconds)
        self.typical_s = median(self.times)


@dataclass
class OpenTrial:
    """A trial without a good answer."""

    attempts: int = 0
    failed: set[Dispatch] = field(default_factory=set)
    leases: dict[int, Lease] = field(default_factory=dict)
    unable: set[str] = field(default_factory=set)
    sent: set[Dispatch] = field(default_factory=set)

    def failed_on(self) -> set[str]:
        """Return the evaluators it failed on."""
        return {dispatch.evaluator for dispatch in self.failed}


class Board:
    """Trials and evaluators, and the leases between them.

    Attributes:
        evaluators: those alive, by name.
        open: the trials that may go out, by number.
        queue: those of them that nobody has, the lowest first.
    """

    def __init__(self) -> None:
        self.evaluators: dict[str, LiveEvaluator] = {}
        self.open: dict[int, OpenTrial] = {}
        self.queue: list[int] = []

    def wait(self, trial: int) -> None:
        """Let an open trial wait for an evaluator."""
        self.queue.append(trial)
        self.queue.sort()

    def lease(self, dispatch: Dispatch, now: float, seconds: float) -> None:
        """Begin a lease of so many seconds."""
        if dispatch.trial in self.queue:
            self.queue.remove(dispatch.trial)
        lease = Lease(dispatch, now + seconds, now)
        self.open[dispatch.trial].leases[dispatch.attempt] = lease
        self.evaluators[dispatch.evaluator].leases[dispatch.trial, dispatch.attempt] = lease

    def drop(self, dispatch: Dispatch) -> None:
        """End a lease, if it has not ended yet; without any, the trial waits again."""
        trial = self.open[dispatch.trial]
        if trial.leases.pop(dispatch.attempt, None) is not None:
            self.evaluators[dispatch.evaluator].leases.pop((dispatch.trial, dispatch.attempt), None)
        if not trial.leases and dispatch.trial not in self.queue:
            self.wait(dispatch.trial)

    def close(self, number: int) -> None:
        """Take a trial off the board, if it is there."""
        trial = self.open.pop(number, None)
        if trial is None:
            return
        if number in self.queue:
            self.queue.remove(number)
        for attempt, lease in trial.leases.items():
            evaluator = self.evaluators[lease.dispatch.evaluator]
            del evaluator.leases[number, attempt]
            evaluator.holds.add((number, attempt))  # until its next heartbeat says otherwise
