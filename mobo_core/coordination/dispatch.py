"""Which evaluator gets which trial, and which answer counts. Pure logic: time comes in as an argument."""

from __future__ import annotations

from collections.abc import Iterable

from mobo_core.coordination.leases import Board, Dispatch, LiveEvaluator, OpenTrial, Verdict
from mobo_core.coordination.places import best_place, best_probe, is_held_in_vain, is_straggler


class Dispatcher:
    """Hands open trials to evaluators and judges their answers.

    A trial goes to one evaluator under a lease, which heartbeats that name it renew. A lease that runs out, an
    evaluator that leaves or falls silent, or one that does not know of a candidate it was sent, puts the trial
    back, to go to another evaluator if there is one; a heartbeat that names it while it waits takes it up again.
    Only answers that say FAILED and evaluations that take too long count against ``max_attempts``: a lost
    evaluator says nothing of the arm.

    A trial that has used up its attempts goes out no more, but a good answer to any of its sendings still counts
    until the trial is told, which :meth:`close` says.

    Places go to the lowest trial first; which evaluator's, and which trials go out a second time as stragglers,
    :mod:`mobo_core.coordination.places` says. What an evaluator holds fills its places, whether it is still wanted
    or not. No trial is with more than two evaluators at a time, and of their answers the first valid one counts.
    An evaluator that says it has a trial's next attempt before it was sent it has one of an earlier time, before the
    bag was cut or lost its end: it gets that trial only when it is done with what it has, which may be another arm.

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
        self._lease_s, self.max_attempts = lease_s, max_attempts
        self.evaluation_timeout_s = evaluation_timeout_s
        self._silence_s, self._grace_s = min(silence_s, lease_s), grace_s
        self._board = Board()
        self._evaluators, self._open, self._queue = self._board.evaluators, self._board.open, self._board.queue
        self._exhausted: dict[int, OpenTrial] = {}
        self._n_joined = 0

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
        record = OpenTrial(sent=set(sent))
        record.attempts = max((d.attempt for d in record.sent), default=0)
        self._open[trial] = record
        self._board.wait(trial)

    def heard(self, evaluator: str, slots: int, holds: Iterable[tuple[int, int]], now: float) -> bool:
        """Take a heartbeat that names the (trial, attempt) it holds; return whether the evaluator is new."""
        new = evaluator not in self._evaluators
        if new:
            self._n_joined += 1
            self._evaluators[evaluator] = LiveEvaluator(joined=self._n_joined)
        known = self._evaluators[evaluator]
        known.slots, known.last_heard, known.holds = slots, now, set(holds)
        for place, lease in list(known.leases.items()):
            if place in known.holds:
                lease.until = now + self._lease_s
            elif now - lease.since > self._grace_s:
                # Sent but not there: the message was lost, or its answer was.
                self._board.drop(lease.dispatch)
        for trial, attempt in sorted(known.holds):
            record, dispatch = self._open.get(trial), Dispatch(trial, attempt, evaluator)
            if record is not None and not record.leases and dispatch in record.sent - record.failed:
                self._board.lease(dispatch, now, self._lease_s)
        return new

    def left(self, evaluator: str) -> list[Dispatch]:
        """Take an evaluator's goodbye; return the dispatches that end with it."""
        if evaluator not in self._evaluators:
            return []
        ended = [lease.dispatch for lease in self._evaluators[evaluator].leases.values()]
        for dispatch in ended:
            self._board.drop(dispatch)
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
                self._board.drop(lease.dispatch)
        return lost, overdue

    def next_dispatches(self, now: float) -> list[Dispatch]:
        """Hand out queued trials, lowest number first, then stragglers once more; see the class."""
        free = {name: places for name, e in self._evaluators.items() if (places := e.free()) > 0}
        if not free:
            return []
        sent: list[Dispatch] = []
        is_held_back = False
        for trial in list(self._queue):
            record = self._open[trial]
            if is_held_back and not record.attempts:
                continue  # trials go out for the first time in their order
            # An evaluator it failed on comes last, and is left out while another is alive.
            failed_on = record.failed_on()
            able = [name for name in free if name not in record.unable and not self._has_namesake(trial, name)]
            fit = [name for name in able if name not in failed_on]
            if not fit and any(name not in failed_on | record.unable for name in self._evaluators):
                able = []
            if able:
                sent.append(self._send(trial, fit or able, free, now))
            elif not record.attempts:
                is_held_back = True
        for trial in sorted(self._open):
            record = self._open[trial]
            fit = [
                name
                for name in free
                if is_straggler(record, name, self._evaluators, now, len(free)) and not self._has_namesake(trial, name)
            ]
            if not fit:
                continue
            if is_held_in_vain(record, self._evaluators):
                fit = [best_probe(trial, fit, self._evaluators)]
                if len(record.leases) > 1:
                    self._board.drop(min(record.leases.values(), key=lambda lease: lease.since).dispatch)
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
            self._evaluators[dispatch.evaluator].replied((dispatch.trial, dispatch.attempt))
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
            self._board.drop(dispatch)
            self.close(dispatch.trial)
            return Verdict.ACCEPTED
        if dispatch in record.failed:
            return Verdict.LATE
        if unable:
            record.unable.add(dispatch.evaluator)
            self._board.drop(dispatch)
            return Verdict.RETRY
        return Verdict.EXHAUSTED if self._fail(dispatch) else Verdict.RETRY

    def close(self, trial: int) -> None:
        """End a trial: no answer to it counts from now on."""
        self._exhausted.pop(trial, None)
        self._board.close(trial)

    def _send(self, trial: int, fit: list[str], free: dict[str, int], now: float) -> Dispatch:
        """Send a trial to the best of the evaluators ``fit``, and take its place from ``free``."""
        name = best_place(fit, free, self._evaluators)
        free[name] -= 1
        if not free[name]:
            del free[name]
        record = self._open[trial]
        record.attempts += 1
        dispatch = Dispatch(trial, record.attempts, name)
        record.sent.add(dispatch)
        self._evaluators[name].unanswered += 1
        self._board.lease(dispatch, now, self._lease_s)
        return dispatch

    def _has_namesake(self, trial: int, evaluator: str) -> bool:
        """Return whether an evaluator has something that the next sending of a trial would be taken for."""
        return (trial, self._open[trial].attempts + 1) in self._evaluators[evaluator].holds

    def _redeems(self, dispatch: Dispatch) -> bool:
        """Return whether a good answer to a sending is still of use to a trial that used up its attempts."""
        record = self._exhausted.get(dispatch.trial)
        return record is not None and dispatch in record.sent

    def _fail(self, dispatch: Dispatch) -> bool:
        record = self._open[dispatch.trial]
        record.failed.add(dispatch)
        self._board.drop(dispatch)
        if len(record.failed) < self.max_attempts:
            return False
        self.close(dispatch.trial)
        self._exhausted[dispatch.trial] = record
        return True
