"""Which evaluator gets which trial, and which answer counts."""

from __future__ import annotations

import pytest

from mobo_core.coordination.dispatch import Dispatcher
from mobo_core.coordination.leases import Dispatch, Verdict


def leases(dispatcher: Dispatcher) -> dict[int, list[Dispatch]]:
    """Return the sendings under lease of every open trial."""
    return {trial: [lease.dispatch for lease in record.leases.values()] for trial, record in dispatcher._open.items()}


def started(trials: int = 1, slots: int = 1, evaluators: str = "a", **options: float) -> Dispatcher:
    """Return a dispatcher with open trials and evaluators of one letter each, heard at time 0."""
    dispatcher = Dispatcher(**options)  # type: ignore[arg-type]
    for trial in range(trials):
        dispatcher.open(trial)
    for name in evaluators:
        assert dispatcher.heard(name, slots, [], 0.0)
    return dispatcher


def beat(dispatcher: Dispatcher, times: range, *holding: Dispatch, name: str = "a", slots: int = 1) -> None:
    """Send a heartbeat that names candidates at each of the times, and let the time pass."""
    for now in times:
        dispatcher.heard(name, slots, [(d.trial, d.attempt) for d in holding], now)
        assert dispatcher.expire(now) == ([], [])


def test_trials_go_out_lowest_first_to_who_has_most_room() -> None:
    """Trials go out in order of number, each to the evaluator with most free places, none to a full one."""
    dispatcher = started(trials=0)
    for trial in (5, 3, 9, 1):
        dispatcher.open(trial)
    dispatcher.heard("b", 2, [], 0.0)
    sent = dispatcher.next_dispatches(0.0)
    assert sent == [Dispatch(1, 1, "b"), Dispatch(3, 1, "a"), Dispatch(5, 1, "b")]
    assert dispatcher.next_dispatches(0.0) == []
    assert dispatcher.open_trials == {1, 3, 5, 9}
    assert dispatcher.answered(sent[1], 0.0, ok=True) is Verdict.ACCEPTED
    assert dispatcher.next_dispatches(1.0) == [Dispatch(9, 1, "a")]


def test_first_good_answer_counts_and_no_other() -> None:
    """An answer to a trial is accepted once; all later ones, of any sending, are late."""
    dispatcher = started()
    (sent,) = dispatcher.next_dispatches(0.0)
    assert dispatcher.answered(sent, 0.0, ok=True) is Verdict.ACCEPTED
    assert dispatcher.open_trials == set()
    for ok in (True, False):
        assert dispatcher.answered(sent, 0.0, ok=ok) is Verdict.LATE
        assert dispatcher.answered(sent._replace(attempt=2), 0.0, ok=ok) is Verdict.LATE


def test_answers_to_what_was_never_sent_do_not_count() -> None:
    """Another attempt, another evaluator or a trial never opened: no such answer is used, the true one still is."""
    dispatcher = started(evaluators="ab")
    (sent,) = dispatcher.next_dispatches(0.0)
    for ok in (True, False):
        assert dispatcher.answered(sent._replace(attempt=2), 0.0, ok=ok) is Verdict.UNKNOWN
        assert dispatcher.answered(sent._replace(evaluator="b"), 0.0, ok=ok) is Verdict.UNKNOWN
        assert dispatcher.answered(sent._replace(trial=1), 0.0, ok=ok) is Verdict.LATE
    assert dispatcher.answered(sent, 0.0, ok=True) is Verdict.ACCEPTED


def test_heartbeats_that_name_a_candidate_renew_its_lease() -> None:
    """For as long as heartbeats name it a candidate stays where it is, far beyond one lease."""
    dispatcher = started(lease_s=10)
    (sent,) = dispatcher.next_dispatches(0.0)
    beat(dispatcher, range(1, 500), sent)
    assert dispatcher.next_dispatches(499) == []
    assert dispatcher.answered(sent, 0.0, ok=True) is Verdict.ACCEPTED


def test_lost_evaluator() -> None:
    """An evaluator not heard of for silence_s is lost, once; its candidate goes to another, as attempt 2."""
    dispatcher = started(evaluators="a", silence_s=4)
    (sent,) = dispatcher.next_dispatches(0.0)
    assert dispatcher.expire(4.0) == ([], [])
    assert dispatcher.expire(4.1) == (["a"], [])
    assert dispatcher.expire(5.0) == ([], [])
    assert dispatcher.evaluators == {}
    assert dispatcher.next_dispatches(5.0) == []
    assert dispatcher.heard("b", 1, [], 5.0)
    assert dispatcher.next_dispatches(5.0) == [Dispatch(0, 2, "b")]
    assert dispatcher.answered(sent, 0.0, ok=True) is Verdict.ACCEPTED  # it was not dead after all, and first
    assert dispatcher.answered(Dispatch(0, 2, "b"), 0.0, ok=True) is Verdict.LATE


def test_lost_evaluator_that_comes_back() -> None:
    """An evaluator heard again after it was lost is new again, and gets work again."""
    dispatcher = started()
    dispatcher.expire(100.0)
    assert dispatcher.heard("a", 3, [], 101.0)
    assert not dispatcher.heard("a", 3, [], 102.0)
    assert dispatcher.evaluators == {"a": 3}
    assert dispatcher.next_dispatches(102.0) == [Dispatch(0, 1, "a")]


def test_losing_evaluators_costs_no_attempts() -> None:
    """However many evaluators are lost with it, a trial is not given up."""
    dispatcher = started(evaluators="", max_attempts=1)
    for i in range(20):
        dispatcher.heard(f"e{i}", 1, [], 100.0 * i)
        assert dispatcher.next_dispatches(100.0 * i) == [Dispatch(0, i + 1, f"e{i}")]
        assert dispatcher.expire(100.0 * i + 50) == ([f"e{i}"], [])
    assert dispatcher.open_trials == {0}


def test_goodbye() -> None:
    """An evaluator that says goodbye gives back what it holds, at once; a stranger's goodbye means nothing."""
    dispatcher = started(trials=2, slots=2)
    sent = dispatcher.next_dispatches(0.0)
    assert dispatcher.left("nobody") == []
    assert sorted(dispatcher.left("a")) == sent
    assert dispatcher.evaluators == {}
    dispatcher.heard("b", 2, [], 0.0)
    assert dispatcher.next_dispatches(0.0) == [Dispatch(0, 2, "b"), Dispatch(1, 2, "b")]


def test_lost_message() -> None:
    """A candidate that its evaluator does not name after grace_s got lost on the way, and is sent again."""
    dispatcher = started(grace_s=2)
    (sent,) = dispatcher.next_dispatches(0.0)
    beat(dispatcher, range(1, 3))  # it may still be on its way
    assert dispatcher.next_dispatches(2.0) == []
    beat(dispatcher, range(3, 4))
    (again,) = dispatcher.next_dispatches(3.0)
    assert again == Dispatch(0, 2, "a")
    beat(dispatcher, range(4, 30), again)
    assert dispatcher.answered(sent, 0.0, ok=True) is Verdict.ACCEPTED  # both are valid, the first wins


def test_a_heartbeat_takes_up_again_what_waits() -> None:
    """A sending given up as lost is in force again when its evaluator names it before the trial went elsewhere."""
    dispatcher = started(grace_s=2)
    (first,) = dispatcher.next_dispatches(0.0)
    beat(dispatcher, range(1, 4))
    assert leases(dispatcher) == {0: []}
    beat(dispatcher, range(4, 30), first)
    assert leases(dispatcher) == {0: [first]}
    dispatcher.heard("b", 1, [(0, 1)], 30.0)  # b was never sent it
    assert dispatcher.next_dispatches(30.0) == []
    assert dispatcher.answered(first, 30.0, ok=True) is Verdict.ACCEPTED


def test_an_evaluator_that_goes_on_through_a_restart_keeps_its_candidate() -> None:
    """A trial opened from a record stays with the evaluator that names it."""
    dispatcher = Dispatcher()
    dispatcher.open(4, [Dispatch(4, 1, "a"), Dispatch(4, 2, "b")])
    dispatcher.heard("b", 2, [(4, 2)], 0.0)
    assert dispatcher.next_dispatches(0.0) == []
    assert leases(dispatcher) == {4: [Dispatch(4, 2, "b")]}


def test_heartbeat_that_names_an_old_attempt_does_not_hold_the_new_one() -> None:
    """What an evaluator names counts by trial and attempt."""
    dispatcher = started(grace_s=2)
    dispatcher.next_dispatches(0.0)
    beat(dispatcher, range(3, 4))
    (second,) = dispatcher.next_dispatches(3.0)
    beat(dispatcher, range(4, 6), Dispatch(0, 1, "a"))
    assert leases(dispatcher) == {0: [second]}
    beat(dispatcher, range(6, 7), Dispatch(0, 1, "a"))
    assert leases(dispatcher) == {0: [Dispatch(0, 1, "a")]}


def test_what_an_evaluator_holds_fills_its_places() -> None:
    """One that still works on what is no longer wanted gets no more than it has places for."""
    dispatcher = started(trials=3, slots=2)
    dispatcher.heard("a", 2, [(77, 1)], 0.0)
    assert dispatcher.next_dispatches(0.0) == [Dispatch(0, 1, "a")]
    dispatcher.answered(Dispatch(77, 1, "a"), 0.5, ok=True)
    assert dispatcher.next_dispatches(0.5) == [Dispatch(1, 1, "a")]
    dispatcher.heard("a", 2, [(0, 1)], 1.0)
    dispatcher.close(0)
    assert dispatcher.next_dispatches(1.0) == []
    dispatcher.heard("a", 2, [(1, 1)], 2.0)
    assert dispatcher.next_dispatches(2.0) == [Dispatch(2, 1, "a")]


def test_lease_that_nobody_renews() -> None:
    """A lease ends after lease_s although its evaluator is alive; heartbeats of others that name it renew nothing."""
    dispatcher = started(evaluators="a", lease_s=10, grace_s=1e9)
    (sent,) = dispatcher.next_dispatches(0.0)
    for now in range(1, 11):
        dispatcher.heard("b", 1, [(0, 1)], now)
        dispatcher.heard("a", 1, [], now)
        assert dispatcher.expire(now) == ([], [])
        assert leases(dispatcher) == {0: [sent]}
    assert dispatcher.expire(10.5) == ([], [])
    assert leases(dispatcher) == {0: []}


def test_failed_trial_goes_to_another_evaluator() -> None:
    """A trial that failed on one evaluator waits for another while there is one, and else goes to the same again."""
    dispatcher = started(evaluators="ab", max_attempts=5)
    dispatcher.open(1)
    first, second = dispatcher.next_dispatches(0.0)
    assert (first.evaluator, second.evaluator) == ("a", "b")
    assert dispatcher.answered(first, 0.0, ok=False) is Verdict.RETRY
    assert dispatcher.next_dispatches(1.0) == []  # a is free, but b has not tried
    assert dispatcher.answered(second, 0.0, ok=True) is Verdict.ACCEPTED
    assert dispatcher.next_dispatches(2.0) == [Dispatch(0, 2, "b")]
    assert dispatcher.answered(Dispatch(0, 2, "b"), 0.0, ok=False) is Verdict.RETRY
    assert dispatcher.next_dispatches(3.0) == [Dispatch(0, 3, "a")]  # failed on all: any will do
    assert dispatcher.answered(Dispatch(0, 3, "a"), 0.0, ok=True) is Verdict.ACCEPTED


def test_other_trials_pass_one_that_waits_for_another_evaluator() -> None:
    """A trial that waits for an evaluator it has not failed on does not hold up those behind it."""
    dispatcher = started(trials=2, evaluators="ab")
    first, second = dispatcher.next_dispatches(0.0)
    dispatcher.open(2)
    assert dispatcher.answered(first, 0.0, ok=False) is Verdict.RETRY
    assert dispatcher.next_dispatches(0.0) == [Dispatch(2, 1, "a")]
    assert dispatcher.answered(second, 0.0, ok=True) is Verdict.ACCEPTED
    assert dispatcher.next_dispatches(0.0) == [Dispatch(0, 2, "b")]


@pytest.mark.parametrize("told", [False, True])
def test_max_attempts(told: bool) -> None:
    """After max_attempts failures a trial is given up, once; only a good answer still counts, until it is told."""
    dispatcher = started(max_attempts=3)
    verdicts = []
    for _ in range(3):
        (sent,) = dispatcher.next_dispatches(0.0)
        verdicts.append(dispatcher.answered(sent, 0.0, ok=False))
        assert dispatcher.answered(sent, 0.0, ok=False) is Verdict.LATE  # said twice, counted once
    assert verdicts == [Verdict.RETRY, Verdict.RETRY, Verdict.EXHAUSTED]
    assert dispatcher.open_trials == set()
    assert dispatcher.next_dispatches(0.0) == []
    assert not dispatcher.matters(sent, ok=False)
    for other in (sent._replace(attempt=4), sent._replace(evaluator="b")):
        assert not dispatcher.matters(other, ok=True)
        assert dispatcher.answered(other, 0.0, ok=True) is Verdict.LATE
    assert dispatcher.matters(sent, ok=True)
    if told:
        dispatcher.close(0)
        assert not dispatcher.matters(sent, ok=True)
    else:
        assert dispatcher.answered(Dispatch(0, 1, "a"), 0.0, ok=True) is Verdict.ACCEPTED
    assert dispatcher.answered(Dispatch(0, 1, "a"), 0.0, ok=True) is Verdict.LATE


def test_heartbeats_take_up_nothing_that_is_given_up() -> None:
    """What used up its attempts is with nobody, whoever still works on it; it fills that one's places."""
    dispatcher = started(max_attempts=1, evaluators="ab")
    (first,) = dispatcher.next_dispatches(0.0)
    assert dispatcher.left("a") == [first]
    (second,) = dispatcher.next_dispatches(0.0)
    assert dispatcher.answered(second, 1.0, ok=False) is Verdict.EXHAUSTED
    dispatcher.heard("a", 1, [(0, 1)], 2.0)
    dispatcher.open(1)
    assert dispatcher.next_dispatches(2.0) == [Dispatch(1, 1, "b")]
    assert leases(dispatcher) == {1: [Dispatch(1, 1, "b")]}
    assert dispatcher.answered(first, 3.0, ok=True) is Verdict.ACCEPTED


def test_evaluations_that_take_too_long() -> None:
    """An evaluation over its time counts as failed, heartbeats or not; after max_attempts the trial is given up."""
    dispatcher = started(evaluators="ab", max_attempts=2, evaluation_timeout_s=30, silence_s=1e9, lease_s=1e9)
    (first,) = dispatcher.next_dispatches(0.0)
    beat(dispatcher, range(1, 31), first)
    dispatcher.heard("a", 1, [(0, 1)], 30.5)
    assert dispatcher.expire(30.5) == ([], [first])
    assert dispatcher.answered(first, 30.5, ok=False, overdue=True) is Verdict.RETRY
    (second,) = dispatcher.next_dispatches(30.5)
    assert second == Dispatch(0, 2, "b")
    assert dispatcher.expire(60.5) == ([], [])
    assert dispatcher.expire(60.6) == ([], [second])
    assert dispatcher.answered(second, 60.6, ok=False, overdue=True) is Verdict.EXHAUSTED
    assert dispatcher.expire(60.7) == ([], [])
    assert dispatcher.open_trials == set()
    dispatcher.close(0)
    assert dispatcher.answered(second, 0.0, ok=True) is Verdict.LATE


def test_answer_that_comes_after_its_lease_still_counts() -> None:
    """A good answer to an expired sending is accepted while the trial is open, and ends the newer sending."""
    dispatcher = started()
    (first,) = dispatcher.next_dispatches(0.0)
    dispatcher.expire(10.1)
    assert leases(dispatcher) == {0: []}
    assert dispatcher.answered(first, 0.0, ok=False) is Verdict.RETRY
    assert dispatcher.answered(first, 0.0, ok=False) is Verdict.LATE  # it failed already
    dispatcher.heard("b", 1, [], 10.1)
    (second,) = dispatcher.next_dispatches(10.1)
    assert second == Dispatch(0, 2, "b")
    assert dispatcher.answered(first, 0.0, ok=True) is Verdict.ACCEPTED
    assert dispatcher.answered(second, 0.0, ok=True) is Verdict.LATE


def test_trials_opened_from_a_record() -> None:
    """Sendings that a record knows of may still be answered, and new attempts count on from them."""
    dispatcher = started(trials=0)
    recorded = [Dispatch(4, 1, "x"), Dispatch(4, 2, "y")]
    dispatcher.open(4, recorded)
    assert dispatcher.next_dispatches(0.0) == [Dispatch(4, 3, "a")]
    assert dispatcher.answered(Dispatch(4, 2, "x"), 0.0, ok=True) is Verdict.UNKNOWN
    assert dispatcher.answered(recorded[1], 0.0, ok=True) is Verdict.ACCEPTED


def test_failures_of_a_record_count() -> None:
    """Failed answers told again after a restart use up attempts as they did before it."""
    dispatcher = started(trials=0)
    recorded = [Dispatch(4, n, f"x{n}") for n in (1, 2, 3)]
    dispatcher.open(4, recorded)
    verdicts = [dispatcher.answered(dispatch, 0.0, ok=False) for dispatch in recorded]
    assert verdicts == [Verdict.RETRY, Verdict.RETRY, Verdict.EXHAUSTED]


def test_unable_evaluators_cost_no_attempt_and_are_not_asked_again() -> None:
    """The trial waits for another evaluator, however many are unable."""
    dispatcher = started()
    for n in range(8):
        dispatcher.heard(f"u{n}", 1, [], 0.0)
    for _ in range(9):
        (sent,) = dispatcher.next_dispatches(0.0)
        assert dispatcher.answered(sent, 0.0, ok=False, unable=True) is Verdict.RETRY
    assert dispatcher.next_dispatches(0.0) == []
    dispatcher.heard("able", 1, [], 0.0)
    (sent,) = dispatcher.next_dispatches(0.0)
    assert sent.evaluator == "able"
    assert dispatcher.answered(sent, 0.0, ok=True) is Verdict.ACCEPTED


def test_closing_a_trial() -> None:
    """A trial that is closed is not sent and takes no answer; its evaluator is free when it has let go of it."""
    dispatcher = started(trials=2)
    (sent,) = dispatcher.next_dispatches(0.0)
    dispatcher.close(0)
    dispatcher.close(0)
    assert dispatcher.next_dispatches(0.0) == []
    assert dispatcher.answered(sent, 0.0, ok=True) is Verdict.LATE
    assert dispatcher.next_dispatches(0.0) == [Dispatch(1, 1, "a")]


def test_what_an_evaluator_has_from_before_is_not_taken_for_what_it_is_sent() -> None:
    """It says it has an attempt that nobody sent it, maybe of another arm: that trial goes elsewhere, or waits."""
    dispatcher = started(trials=2, evaluators="")
    dispatcher.heard("a", 3, [(0, 1)], 0.0)
    assert dispatcher.next_dispatches(0.0) == []  # trial 1 does not overtake it
    dispatcher.heard("b", 1, [], 1.0)
    assert dispatcher.next_dispatches(1.0) == [Dispatch(0, 1, "b"), Dispatch(1, 1, "a")]
    assert dispatcher.answered(Dispatch(0, 1, "a"), 1.0, ok=True) is Verdict.UNKNOWN
    alone = started(evaluators="")
    alone.heard("a", 2, [(0, 1)], 0.0)
    assert alone.next_dispatches(0.0) == []
    alone.heard("a", 2, [], 1.0)
    assert alone.next_dispatches(1.0) == [Dispatch(0, 1, "a")]
