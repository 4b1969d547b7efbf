"""Dispatch as state machines: in whatever order things come, a trial is told at most once, and in the end once."""

from __future__ import annotations

import shutil
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

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
from nodes import values
from studies import run_study

from mobo_core.bag.collector import read_study
from mobo_core.bag.study_bag import StudyBag
from mobo_core.coordination.answer import Answering
from mobo_core.coordination.dispatch import Dispatcher
from mobo_core.coordination.leases import Dispatch, Verdict
from mobo_core.coordination.optimizer import Optimizer
from mobo_core.messages import Candidate, Evaluation, EvaluatorStatus, Trial, decode, encode
from mobo_core.search.study import StudySettings
from mobo_core.verify.history import History

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

N_TRIALS = 8
# The model takes over from the fifth trial on, so that a value told wrongly shows in the parameters that follow.
STUDY = {"n_startup_trials": 4, "in_flight": 3, "sampler": "tpe"}
REJECTED = 2  # this one is bad, on every evaluator


class AnyMessages(RuleBasedStateMachine):
    """The optimizer with a real bag: its evaluators die, answer twice, late or rubbish; it is killed and resumes.

    Failed answers stay below ``max_attempts``, so that the trials must be those of a quiet study, to the bit.
    """

    def __init__(self) -> None:
        super().__init__()
        self.folder = Path(tempfile.mkdtemp())
        self.bag = self.folder / "bag"
        self.settings = StudySettings.of(STUDY)
        self.now = 0.0
        self.held: dict[str, list[Any]] = {name: [] for name in NAMES}
        self.past: list[bytes] = []  # answers given
        self.failures: Counter[int] = Counter()
        self.published: list[tuple[str, bytes]] = []
        self.told: Counter[int] = Counter()
        self.start(resume=False)

    def start(self, *, resume: bool) -> None:
        self.store = StudyBag(self.bag, "s", self.settings, resume=resume)
        self.optimizer = Optimizer(
            self.store, self.settings, N_TRIALS, Dispatcher(), lambda topic, data: self.published.append((topic, data)),
            log=lambda line: None, warn=lambda line: None,
        )  # fmt: skip

    def deliver(self, lost: bool = False) -> None:
        """Take what the optimizer has published: trials are counted, candidates reach their evaluators, or not."""
        for topic, data in self.published:
            if topic == "trials":
                self.told[int(decode(Trial, data).trial)] += 1
            elif topic == "candidates" and not lost:
                candidate = decode(Candidate, data)
                self.held.setdefault(candidate.evaluator, []).append(candidate)
        self.published.clear()
        assert all(count == 1 for count in self.told.values())

    @rule(name=st.sampled_from(NAMES), lost=st.booleans())
    def heartbeat(self, name: str, lost: bool) -> None:
        self.beat(name)
        self.deliver(lost)

    def beat(self, name: str, **fields: Any) -> None:
        held = self.held[name]
        named = {"studies": ["s"] * len(held), "trials": [c.trial for c in held], "attempts": [c.attempt for c in held]}
        status = EvaluatorStatus(**{"evaluator": name, "workers": SLOTS[name], **named, **fields})
        self.optimizer.on_evaluator(encode(status), self.now)

    @rule(name=st.sampled_from(NAMES))
    def crash(self, name: str) -> None:
        self.held[name].clear()

    @rule(name=st.sampled_from(NAMES))
    def goodbye(self, name: str) -> None:
        self.held[name].clear()
        self.beat(name, state=EvaluatorStatus.LEFT)
        self.deliver()

    @rule(seconds=SECONDS)
    def time_passes(self, seconds: float) -> None:
        self.now += seconds
        self.optimizer.tick(self.now)
        self.deliver()

    @rule(name=st.sampled_from(NAMES), times=st.integers(0, 2))
    def answer(self, name: str, times: int) -> None:
        """The oldest candidate an evaluator holds is answered: once, twice, or the answer is lost."""
        if self.held[name]:
            candidate = self.held[name].pop(0)
            for _ in range(times):
                self.evaluated(candidate, name)
            self.deliver()

    def evaluated(self, candidate: Any, name: str) -> None:
        answering = Answering(name, "simulated", simulated_s=0.0)
        rejection = Evaluation.REJECTED
        bad = candidate.trial == REJECTED
        answer = answering.refusal(candidate, rejection, "bad arm") if bad else answering.answer(candidate)
        self.past.append(encode(answer))
        self.optimizer.on_evaluation(self.past[-1], self.now)

    @rule(name=st.sampled_from(NAMES), reason=st.sampled_from(["died", "unable: too small"]))
    def fails(self, name: str, reason: str) -> None:
        if self.held[name] and self.failures[self.held[name][0].trial] < 2:
            candidate = self.held[name].pop(0)
            self.failures[candidate.trial] += 1
            failed = Answering(name).refusal(candidate, Evaluation.FAILED, reason)
            self.optimizer.on_evaluation(encode(failed), self.now)
            self.deliver()

    @rule(data=st.data())
    def old_answer(self, data: st.DataObject) -> None:
        """An answer comes once more, as it was, cut, or with other numbers."""
        if not self.past:
            return
        answer = bytearray(data.draw(st.sampled_from(self.past)))
        for place, value in data.draw(st.lists(st.tuples(st.integers(0, len(answer) - 1), st.integers(0, 255)))):
            answer[place] = value
        cut = data.draw(st.integers(0, len(answer)))
        message = bytes(answer[:cut])
        if message not in self.past and _could_be_true(message):
            return  # damaged where only a checksum could tell
        self.optimizer.on_evaluation(message, self.now)
        self.deliver()

    @rule()
    def killed(self) -> None:
        """The optimizer is killed and resumes, before or after what it last sent had arrived."""
        self.store._lock.release()  # as the kernel does
        self.published.clear()
        self.start(resume=self.bag.exists() and any(self.bag.glob("*.mcap")))
        self.told = Counter({told.number: 1 for told in self.optimizer.study.told})

    def teardown(self) -> None:
        """The evaluators behave, and the study comes to its end."""
        try:
            for _ in range(400):
                if self.optimizer.done:
                    break
                self.now += 1.0
                for name in self.held:
                    self.beat(name)
                    self.deliver()
                    while self.held[name]:
                        self.evaluated(self.held[name].pop(0), name)
                        self.deliver()
            assert self.optimizer.done
            self.store.close()
            study = read_study(self.bag)
            assert study.repeated == [] and study.faults == []
            assert sorted(study.trials) == list(range(N_TRIALS))
            assert values(self.bag) == quiet_values()
            history = History(study)
            history.replay()
            assert history.faults == []  # whatever happened, an honest bag is no lie
        finally:
            shutil.rmtree(self.folder)


def _could_be_true(message: bytes) -> bool:
    """Return whether a damaged answer still decodes: what then differs is a true answer's numbers or names."""
    try:
        decode(Evaluation, message)
    except Exception:
        return False
    return True


_quiet: list[Any] = []


def quiet_values() -> list[Any]:
    """Return the trials of the study that nothing disturbs."""
    if not _quiet:
        with tempfile.TemporaryDirectory() as folder:
            bag = run_study(Path(folder) / "bag", N_TRIALS, name="s", settings=STUDY, rejected=[REJECTED])
            _quiet.extend(values(bag))
    return _quiet


AnyMessages.TestCase.settings = settings(max_examples=6, stateful_step_count=40)
TestAnyMessages = AnyMessages.TestCase
