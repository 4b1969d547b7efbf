"""Which dead processes a study starts again, and when."""

from __future__ import annotations

from mobo_core.coordination.supervision import Restarts


def test_a_process_that_keeps_dying_is_given_up() -> None:
    """After five deaths without progress, whatever the time between them."""
    restarts = Restarts()
    assert [restarts.died("e", 3, 100.0 * i) for i in range(7)] == [True] * 5 + [False] * 2


def test_progress_makes_good_what_was_before() -> None:
    """With a trial told between deaths a process may die for ever; progress counts for all processes."""
    restarts = Restarts()
    assert all(restarts.died("e", told, 0.0) for told in range(100))
    for _ in range(5):
        assert restarts.died("f", 99, 0.0)
    assert restarts.died("e", 100, 0.0) and restarts.died("f", 100, 0.0)


def test_deaths_of_one_do_not_count_against_another() -> None:
    """Each may die five times."""
    restarts = Restarts()
    assert all(restarts.died(name, 0, 0.0) for _ in range(5) for name in "abc")
    assert not restarts.died("b", 0, 0.0) and not restarts.died("c", 0, 0.0)


def test_it_starts_again_after_a_pause() -> None:
    """Not before, and once."""
    restarts = Restarts(pause_s=1.0)
    assert not restarts.is_dead("e")
    restarts.died("e", 0, 10.0)
    assert restarts.is_dead("e") and not restarts.is_due("e", 10.9) and restarts.is_due("e", 11.1)
    restarts.started("e")
    assert not restarts.is_dead("e")
