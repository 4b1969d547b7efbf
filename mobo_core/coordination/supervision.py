"""Whether a child process that died is started again, and when. Pure logic: time comes in as an argument."""

from __future__ import annotations

from collections import Counter


class Restarts:
    """Counts the deaths of a study's processes, by name.

    One that keeps dying while no trial is told in between will not come up: after more than ``most_deaths`` it
    is given up. A trial told since the last death of any of them makes good all earlier ones.

    Args:
        most_deaths: that a process may die without progress.
        pause_s: s before it is started again.
    """

    def __init__(self, most_deaths: int = 5, pause_s: float = 1.0) -> None:
        self._most, self._pause_s = most_deaths, pause_s
        self._deaths: Counter[str] = Counter()
        self._died_at: dict[str, float] = {}
        self._told = -1

    def died(self, name: str, told: int, now: float) -> bool:
        """Take a death at ``now`` (s), ``told`` trials being told; return whether to start the process again."""
        if told > self._told:
            self._deaths.clear()
        self._told = told
        self._deaths[name] += 1
        self._died_at[name] = now
        return self._deaths[name] <= self._most

    def is_dead(self, name: str) -> bool:
        """Return whether its death is taken, and its restart still to come."""
        return name in self._died_at

    def is_due(self, name: str, now: float) -> bool:
        """Return whether the pause after its death is over."""
        return now - self._died_at[name] > self._pause_s

    def started(self, name: str) -> None:
        """Take that it runs again."""
        self._died_at.pop(name, None)
