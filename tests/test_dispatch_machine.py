"""The dispatcher as a state machine: in whatever order things come, a trial ends at most once, and in the end once."""

from __future__ import annotations

from collections import Counter

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    Bundle,
    RuleBasedStateMachine,
    consumes,
    initialize,
    invariant,
    multiple,
    precondition,
    rule,
)

from mobo_core.coordination.dispatch import Dispatcher
from mobo_core.coordination.leases import Dispatch, Verdict

NAMES = ["a", "b", "c"]
SLOTS = {"a": 1, "b": 2, "c": 3, "healer": 2}
SECONDS = st.sampled_from([0.1, 0.5, 1.0, 2.5, 5.0, 11.0, 25.0])


class AnyOrder(RuleBasedStateMachine):
    """The dispatcher among joins, losses, answers of every kind, heartbeats true and false, and time-outs.

    The world here knows what was sent and what has ended; the dispatcher has to agree. In the end a good
    evaluator joins, and every trial must come to its end, exactly once.
    """

    sendings = Bundle("sendings")

    @initialize(target=sendings, max_attempts=st.integers(1, 3), timeout=st.sampled_from([20.0, 1e9]))
    def begin(self, max_attempts: int, timeout: float) -> object:
        self.now = 0.0
        self.max_attempts, self.timeout = max_attempts, timeout
        self.dispatcher = Dispatcher(
            lease_s=10, max_attempts=max_attempts, evaluation_timeout_s=timeout, silence_s=4, grace_s=2
        )
        self.opened = 0
        self.ended: Counter[int] = Counter()
        self.exhausted: set[int] = set()
        self.told: set[int] = set()
        self.retries: Counter[int] = Counter()
        self.unable: set[tuple[int, str]] = set()
        self.sent: dict[Dispatch, float] = {}
        self.held: dict[str, set[Dispatch]] = {name: set() for name in SLOTS}
        self.open_trials(4)
        for name in NAMES:
            self.heartbeat(name)
        return self.send([])

    @rule(count=st.integers(1, 2))
    def open_trials(self, count: int) -> None:
        for _ in range(count):
            self.dispatcher.open(self.opened)
            self.opened += 1

    @rule(name=st.sampled_from(NAMES))
    def heartbeat(self, name: str) -> None:
        self.beat(name, [(d.trial, d.attempt) for d in self.held[name]])

    @rule(name=st.sampled_from(NAMES), names=st.lists(st.tuples(st.integers(0, 6), st.integers(1, 4)), max_size=2))
    def false_heartbeat(self, name: str, names: list[tuple[int, int]]) -> None:
        """It names nothing of what it holds, but perhaps what it never got."""
        self.beat(name, names)

    def beat(self, name: str, names: list[tuple[int, int]]) -> None:
        known = name in self.dispatcher.evaluators
        new = self.dispatcher.heard(name, SLOTS[name], names, self.now)
        assert new == (not known)
        assert self.dispatcher.evaluators[name] == SLOTS[name]

    @rule(name=st.sampled_from(NAMES), silently=st.booleans())
    def ends(self, name: str, silently: bool) -> None:
        self.held[name].clear()
        if silently:
            return
        leases = set(self.leases_of(name))
        assert set(self.dispatcher.left(name)) == leases
        assert name not in self.dispatcher.evaluators

    @rule(seconds=SECONDS)
    def time_passes(self, seconds: float) -> None:
        self.now += seconds
        alive = set(self.dispatcher.evaluators)
        lost, overdue = self.dispatcher.expire(self.now)
        assert set(lost) <= alive
        assert not set(lost) & set(self.dispatcher.evaluators)
        self.time_out(overdue)

    def time_out(self, overdue: list[Dispatch]) -> None:
        """Judge what takes too long as failed answers, as the optimizer does."""
        for dispatch in overdue:
            assert self.now - self.sent[dispatch] > self.timeout
            if self.dispatcher.matters(dispatch, ok=False):
                self.judge(dispatch, "overdue")
        assert self.dispatcher.expire(self.now) == ([], [])

    @rule()
    def tell(self) -> None:
        """The lowest trial that is not told is, if it has ended: nothing counts for it any more."""
        trial = len(self.told)
        if self.ended[trial]:
            self.dispatcher.close(trial)
            self.told.add(trial)

    @rule(target=sendings, seconds=st.sampled_from([0.5, 1.0, 2.0]), silent=st.sampled_from(["", "", *NAMES]))
    def a_while_passes(self, seconds: float, silent: str) -> object:
        """All evaluators but perhaps one send heartbeats, and what waits goes out."""
        self.time_passes(seconds)
        for name in NAMES:
            if name != silent:
                self.heartbeat(name)
        return self.send([])

    @rule(target=sendings, lost=st.lists(st.booleans(), max_size=10))
    def send(self, lost: list[bool]) -> object:
        """What waits goes out; of some messages nothing arrives."""
        places = {name: e.free() for name, e in self.dispatcher._evaluators.items()}
        before = {trial: dict(record.leases) for trial, record in self.dispatcher._open.items()}
        sent = self.dispatcher.next_dispatches(self.now)
        for i, dispatch in enumerate(sent):
            trial = dispatch.trial
            assert dispatch not in self.sent
            if dispatch.attempt == 1:  # for the first time, in their order
                assert trial == len({d.trial for d in self.sent})
            assert dispatch.attempt == 1 + max((d.attempt for d in self.sent if d.trial == trial), default=0)
            assert dispatch.evaluator in self.dispatcher.evaluators
            assert (trial, dispatch.evaluator) not in self.unable
            assert self.ended[trial] == 0
            for lease in before[trial].values():
                # a second sending of a straggler, to another evaluator
                assert self.now - lease.since > 1.0
                assert lease.dispatch.evaluator != dispatch.evaluator
            self.sent[dispatch] = self.now
            if not any(lost[i : i + 1]):
                self.held[dispatch.evaluator].add(dispatch)
        for dispatch in sent:
            places[dispatch.evaluator] -= 1
        assert all(n >= 0 for name, n in places.items() if name in {d.evaluator for d in sent})
        firsts = [d.trial for d in sent if not before[d.trial]]
        again = [d.trial for d in sent if before[d.trial]]
        assert [d.trial for d in sent] == sorted(set(firsts)) + sorted(set(again))
        self.nothing_waits_in_vain({name for name, n in places.items() if n > 0})
        return multiple(*sent)

    def nothing_waits_in_vain(self, free: set[str]) -> None:
        """Check that no trial is left unsent that a free evaluator could take."""
        alive = set(self.dispatcher.evaluators)
        for trial, record in self.dispatcher._open.items():
            if not record.leases:
                able = {name for name in alive if (trial, name) not in self.unable}
                failed_on = {dispatch.evaluator for dispatch in record.failed}
                assert free & able <= failed_on
                assert not free & able or able - failed_on

    @rule(name=st.sampled_from(NAMES), kind=st.sampled_from(["ok", "failed", "failed", "unable"]))
    def answer_of(self, name: str, kind: str) -> None:
        """An evaluator answers the lowest trial it holds."""
        for sending in sorted(self.held[name])[:1]:
            self.answer(sending, kind)

    @rule(sending=sendings, kind=st.sampled_from(["ok", "failed", "unable"]))
    def answer(self, sending: Dispatch, kind: str) -> None:
        """Any sending is answered: in time, late, once more, or without ever having arrived."""
        self.held[sending.evaluator].discard(sending)
        self.judge(sending, kind)

    @rule(sending=consumes(sendings))
    def forget(self, sending: Dispatch) -> None:
        """A sending is never answered."""
        self.held[sending.evaluator].discard(sending)

    @rule(
        trial=st.integers(0, 12),
        attempt=st.integers(0, 5),
        name=st.sampled_from([*NAMES, "stranger"]),
        kind=st.sampled_from(["ok", "failed", "unable"]),
    )
    def answer_from_nowhere(self, trial: int, attempt: int, name: str, kind: str) -> None:
        if Dispatch(trial, attempt, name) not in self.sent:
            self.judge(Dispatch(trial, attempt, name), kind)

    def judge(self, dispatch: Dispatch, kind: str) -> None:
        trial = dispatch.trial
        is_open = trial < self.opened and not self.ended[trial]
        answerable = trial in self.exhausted - self.told
        counts = (is_open or answerable) and dispatch in self.sent
        failed = is_open and dispatch in self.dispatcher._open[trial].failed
        assert self.dispatcher.matters(dispatch, ok=True) == counts
        assert self.dispatcher.matters(dispatch, ok=False) == (counts and is_open and not failed)
        failed_before = is_open and dispatch in self.dispatcher._open[trial].failed
        kinds = {"ok": kind == "ok", "unable": kind == "unable", "overdue": kind == "overdue"}
        verdict = self.dispatcher.answered(dispatch, self.now, **kinds)
        if answerable and counts and kind == "ok":
            assert verdict is Verdict.ACCEPTED
            self.exhausted.discard(trial)  # a good answer has come: none counts any more
        elif not is_open:
            assert verdict is Verdict.LATE
        elif dispatch not in self.sent:
            assert verdict is Verdict.UNKNOWN
        elif kind == "ok":
            assert verdict is Verdict.ACCEPTED
            self.end(trial)
        elif failed_before:
            assert verdict is Verdict.LATE
        elif kind == "unable":
            assert verdict is Verdict.RETRY
            self.unable.add((trial, dispatch.evaluator))
        else:
            self.retries[trial] += 1
            if verdict is Verdict.EXHAUSTED:
                self.end(trial)
                self.exhausted.add(trial)
                assert self.retries[trial] == self.max_attempts
            else:
                assert verdict is Verdict.RETRY
                assert self.retries[trial] < self.max_attempts

    def end(self, trial: int) -> None:
        self.ended[trial] += 1
        assert self.ended[trial] == 1
        assert trial not in self.dispatcher.open_trials

    def leases_of(self, name: str) -> list[Dispatch]:
        evaluator = self.dispatcher._evaluators.get(name)
        return [lease.dispatch for lease in evaluator.leases.values()] if evaluator else []

    @invariant()
    @precondition(lambda self: hasattr(self, "dispatcher"))
    def agrees(self) -> None:
        """Open is what has not ended; a lease is known to its trial and its evaluator; what has none waits."""
        still = {trial for trial in range(self.opened) if not self.ended[trial]}
        assert self.dispatcher.open_trials == still
        by_trial = [lease.dispatch for record in self.dispatcher._open.values() for lease in record.leases.values()]
        by_evaluator = [dispatch for name in self.dispatcher.evaluators for dispatch in self.leases_of(name)]
        assert sorted(by_trial) == sorted(by_evaluator)
        assert set(by_trial) <= self.sent.keys()
        with_evaluators: dict[int, list[str]] = {}
        for dispatch in by_trial:
            with_evaluators.setdefault(dispatch.trial, []).append(dispatch.evaluator)
        assert all(len(names) == len(set(names)) <= 2 for names in with_evaluators.values())
        assert self.dispatcher._queue == sorted(still - with_evaluators.keys())
        assert all(len(record.failed) < self.max_attempts for record in self.dispatcher._open.values())

    def teardown(self) -> None:
        """A reliable evaluator joins, messages flow, and all trials end."""
        if not hasattr(self, "dispatcher"):
            return
        healer = self.held["healer"]
        for _ in range(20 * (self.opened + 1)):
            self.now += 1.0
            self.dispatcher.heard("healer", 2, [(d.trial, d.attempt) for d in healer], self.now)
            self.time_out(self.dispatcher.expire(self.now)[1])
            for dispatch in list(healer):
                healer.discard(dispatch)
                self.judge(dispatch, "ok")
            for dispatch in self.dispatcher.next_dispatches(self.now):
                self.sent[dispatch] = self.now
                self.held[dispatch.evaluator].add(dispatch)
            self.agrees()
        assert self.dispatcher.open_trials == set()
        assert all(self.ended[trial] == 1 for trial in range(self.opened))


AnyOrder.TestCase.settings = settings(max_examples=80, stateful_step_count=60)
TestAnyOrder = AnyOrder.TestCase
