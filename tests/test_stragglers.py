"""Evaluators of different speeds, and those that do not come to an end."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field

import pytest

from mobo_core.coordination.dispatch import Dispatcher
from mobo_core.coordination.leases import Dispatch, Verdict


@dataclass
class World:
    """A study in simulated time: ordered, ``in_flight`` trials open at a time, evaluators of given speeds.

    ``seconds`` has what an evaluation takes on each evaluator, which has ``slots`` places; math.inf never ends.
    Heartbeats come every second.
    """

    seconds: dict[str, float]
    trials: int
    in_flight: int
    slots: int = 1
    now: float = 0.0
    accepted: Counter[str] = field(default_factory=Counter)
    sent: list[tuple[float, Dispatch]] = field(default_factory=list)

    def run(self, step: float = 0.05) -> World:
        """Run to the end of the study; its length is ``now``."""
        dispatcher = Dispatcher()
        told = opened = ticks = 0
        answered: set[int] = set()
        working: dict[str, list[tuple[float, Dispatch]]] = {name: [] for name in self.seconds}
        while told < self.trials:
            if ticks % round(1 / step) == 0:
                for name, work in working.items():
                    dispatcher.heard(name, self.slots, [(d.trial, d.attempt) for _, d in work], self.now)
            for name, work in working.items():
                for done, dispatch in [item for item in work if item[0] <= self.now + 1e-9]:
                    work.remove((done, dispatch))
                    if dispatcher.answered(dispatch, self.now, ok=True) is Verdict.ACCEPTED:
                        answered.add(dispatch.trial)
                        self.accepted[name] += 1
            assert dispatcher.expire(self.now) == ([], [])
            while told in answered:
                told += 1
            while opened < min(self.trials, told + self.in_flight):
                dispatcher.open(opened)
                opened += 1
            for dispatch in dispatcher.next_dispatches(self.now):
                self.sent.append((self.now, dispatch))
                # Its workers take them in order.
                work = working[dispatch.evaluator]
                start = self.now if len(work) < self.slots else sorted(end for end, _ in work)[-self.slots]
                work.append((start + self.seconds[dispatch.evaluator], dispatch))
            ticks += 1
            self.now = ticks * step
            assert self.now < 1000
        return self

    @property
    def twice(self) -> list[int]:
        """The trials that were sent out more than once."""
        counts = Counter(dispatch.trial for _, dispatch in self.sent)
        assert max(counts.values()) <= 2
        return [trial for trial, count in counts.items() if count > 1]


def test_equal_evaluators_send_nothing_twice() -> None:
    """Where none is slow, no place is spent on a second sending."""
    world = World({"a": 1.5, "b": 1.5, "c": 1.5}, trials=60, in_flight=8).run()
    assert world.twice == []
    assert world.now <= 1.5 * 60 / 3 + 3


@pytest.mark.parametrize("in_flight", [8, 16])
def test_the_faster_get_more(in_flight: int) -> None:
    """With evaluators of 1 s and 4 s mixed, the faster do most of it, at nearly the rate of all together."""
    seconds = {"fast_1": 1.0, "fast_2": 1.0, "slow_1": 4.0, "slow_2": 4.0}
    world = World(seconds, trials=200, in_flight=in_flight).run()
    fast, slow = (sum(n for name, n in world.accepted.items() if name.startswith(kind)) for kind in ("fast", "slow"))
    assert fast >= 3.5 * slow
    ideal = 200 / sum(1 / s for s in seconds.values())
    assert world.now < 1.15 * ideal


def test_idle_fast_evaluators_are_preferred() -> None:
    """With fewer trials in flight than places, the slow ones are left idle."""
    world = World({"slow_1": 4.0, "slow_2": 4.0, "fast": 1.0}, trials=100, in_flight=2, slots=2).run()
    assert world.accepted["fast"] > 90


def test_the_end_does_not_wait_for_a_straggler() -> None:
    """The last trials go to idle evaluators too, the oldest first, and the first answer counts."""
    quick = World({"a": 1.0, "b": 1.0}, trials=20, in_flight=20).run()
    world = World({"a": 1.0, "b": 1.0, "slow": 60.0}, trials=20, in_flight=20).run()
    assert world.now <= quick.now + 3
    assert world.accepted["slow"] == 0


@pytest.mark.parametrize("in_flight", [4, 8])
def test_a_hung_evaluation_does_not_hold_up_the_study(in_flight: int) -> None:
    """One that never ends, on an evaluator that sends heartbeats, costs the time of one straggler."""
    healthy = World({"a": 1.0, "b": 1.0}, trials=60, in_flight=in_flight).run()
    world = World({"a": 1.0, "b": 1.0, "hung": math.inf}, trials=60, in_flight=in_flight).run()
    assert world.now <= healthy.now + 5
    assert len(world.twice) == 1


def test_only_what_is_out_for_long_goes_out_twice() -> None:
    """Not before 1 s, nor before twice what the idle evaluator takes; not to one it failed on; at most to two."""
    dispatcher = Dispatcher(silence_s=1e9, lease_s=1e9, max_attempts=9)
    for trial in range(3):
        dispatcher.open(trial)
    for name in "abcd":
        dispatcher.heard(name, 1, [], 0.0)
    first, second, third = dispatcher.next_dispatches(0.0)
    assert [first.evaluator, second.evaluator, third.evaluator] == ["a", "b", "c"]
    assert dispatcher.next_dispatches(100.0) == []  # nothing known of any speed yet
    dispatcher.open(3)
    (fourth,) = dispatcher.next_dispatches(100.0)
    assert dispatcher.answered(fourth, 103.0, ok=True) is Verdict.ACCEPTED
    assert dispatcher.next_dispatches(103.0) == [Dispatch(0, 2, "d")]  # the oldest first
    assert dispatcher.answered(Dispatch(0, 2, "d"), 103.0, ok=False) is Verdict.RETRY
    assert leases_of(dispatcher, 0) == [first]
    assert dispatcher.next_dispatches(104.0) == [Dispatch(1, 2, "d")]
    assert dispatcher.next_dispatches(105.0) == []
    dispatcher.heard("e", 3, [], 105.0)
    assert dispatcher.next_dispatches(105.0) == [Dispatch(0, 3, "e"), Dispatch(2, 2, "e")]
    assert dispatcher.next_dispatches(200.0) == []
    assert dispatcher.answered(first, 200.0, ok=True) is Verdict.ACCEPTED
    assert dispatcher.answered(Dispatch(0, 3, "e"), 201.0, ok=True) is Verdict.LATE


def leases_of(dispatcher: Dispatcher, trial: int) -> list[Dispatch]:
    return [lease.dispatch for lease in dispatcher._open[trial].leases.values()]


def test_a_second_sending_waits_for_twice_the_idle_evaluators_time() -> None:
    """Just before that time it stays where it is, just after it goes out once more."""
    dispatcher = Dispatcher(silence_s=1e9, lease_s=1e9)
    dispatcher.open(0)
    for name in "ab":
        dispatcher.heard(name, 1, [], 0.0)
    (sent,) = dispatcher.next_dispatches(0.0)
    for trial in (1, 2, 3):
        dispatcher.open(trial)
        (quick,) = dispatcher.next_dispatches(0.0)
        assert quick.evaluator == "b"
        assert dispatcher.answered(quick, 2.0, ok=True) is Verdict.ACCEPTED
    assert dispatcher.next_dispatches(3.9) == []
    assert dispatcher.next_dispatches(4.1) == [Dispatch(0, 2, "b")]
    assert sent.evaluator == "a"


def test_two_sendings_that_both_take_too_long() -> None:
    """They end the trial once, and both places are free again when their evaluators have let go."""
    dispatcher = Dispatcher(silence_s=1e9, lease_s=1e9, max_attempts=1, evaluation_timeout_s=50.0)
    dispatcher.open(0)
    for name in "ab":
        dispatcher.heard(name, 1, [], 0.0)
    (first,) = dispatcher.next_dispatches(0.0)
    dispatcher.open(1)
    (quick,) = dispatcher.next_dispatches(0.0)
    assert dispatcher.answered(quick, 1.0, ok=True) is Verdict.ACCEPTED
    (second,) = dispatcher.next_dispatches(3.0)
    assert {first, second} == {Dispatch(0, 1, "a"), Dispatch(0, 2, "b")}
    dispatcher.heard("a", 1, [(0, 1)], 99.0)
    dispatcher.heard("b", 1, [(0, 2)], 99.0)
    assert dispatcher.expire(100.0) == ([], [first, second])
    assert dispatcher.answered(first, 100.0, ok=False, overdue=True) is Verdict.EXHAUSTED
    assert not dispatcher.matters(second, ok=False)
    assert dispatcher.answered(second, 100.0, ok=False, overdue=True) is Verdict.LATE
    assert dispatcher.expire(100.0) == ([], [])
    dispatcher.open(2)
    dispatcher.open(3)
    assert dispatcher.next_dispatches(100.0) == []
    for name in "ab":
        dispatcher.heard(name, 1, [], 101.0)
    assert len(dispatcher.next_dispatches(101.0)) == 2


@pytest.mark.parametrize("honest_joins", [0, 100, 200])
def test_names_with_nothing_behind_them_do_not_stop_a_study(honest_joins: int) -> None:
    """Two hundred that take candidates, name them in heartbeats and never answer; one that does, wherever it joins."""
    names = [f"fake_{i}" for i in range(200)]
    names.insert(honest_joins, "honest")
    world = World({name: 0.2 if name == "honest" else math.inf for name in names}, trials=20, in_flight=4, slots=2)
    world.run(step=0.5)
    assert world.accepted == {"honest": 20}
    assert world.now < (300 if honest_joins == 100 else 70)
