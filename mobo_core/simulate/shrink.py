"""A smaller plan that breaks the same rule: fewer faults, shorter ones, fewer trials."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

from mobo_core.simulate.faults import Plan
from mobo_core.simulate.simulation import Outcome, simulate

_MOST_RUNS = 150


def shrink(outcome: Outcome, progress: Callable[[int, int], None] = lambda done, total: None) -> Outcome:
    """Return an outcome with the same violation of a plan with as little in it as can be found in some runs.

    Args:
        outcome: one with a violation.
        progress: called with (runs done, at most).
    """
    runs, found = 0, True
    while found:
        found = False
        for plan in _smaller(outcome):
            if runs == _MOST_RUNS:
                return outcome
            runs += 1
            progress(runs, _MOST_RUNS)
            tried = simulate(plan)
            if _rule(tried) == _rule(outcome):
                outcome, found = tried, True
                break
    return outcome


def _rule(outcome: Outcome) -> str | None:
    return None if outcome.violation is None else outcome.violation.rule


def _smaller(outcome: Outcome) -> Iterator[Plan]:
    """Yield smaller plans, those that leave out the most first."""
    plan, faults = outcome.plan, outcome.plan.faults
    begun = tuple(fault for fault in faults if fault.at <= outcome.seconds)
    if len(begun) < len(faults):
        yield replace(plan, faults=begun)
        return
    size = len(faults) // 2
    while size:
        for at in range(0, len(faults), size):
            yield replace(plan, faults=faults[:at] + faults[at + size :])
        size //= 2
    if len(plan.workers) > 1:
        yield replace(plan, workers=plan.workers[:1])
        yield replace(plan, workers=plan.workers[:-1])
    for n_trials in (plan.n_trials // 2, plan.n_trials - 1):
        if 0 < n_trials < plan.n_trials:
            yield replace(plan, n_trials=n_trials)
