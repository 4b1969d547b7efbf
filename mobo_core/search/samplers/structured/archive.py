"""What is known of one joint order: its front, its arms of late, and how its front grew."""

from __future__ import annotations

from array import array
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mobo_core.search.samplers.structured.volume import added, insert

Floats = NDArray[np.float64]

FRONT = 96  # arms of a front that are kept
KEPT = 512  # arms of late that are kept


class Front:
    """The best arms of one order or of all, and the share of the box that they dominate.

    Args:
        m: objectives.
        d: numbers that go with each arm.
        capacity: arms.
    """

    def __init__(self, m: int, d: int, capacity: int = FRONT) -> None:
        self._gains, self._arms = np.empty((8, m)), np.empty((8, d))
        self._capacity, self._k = capacity, 0
        self.volume = 0.0

    def __len__(self) -> int:
        """Return the number of arms on the front."""
        return self._k

    @property
    def gains(self) -> Floats:
        """Gains of the arms, (k, m)."""
        return self._gains[: self._k]

    @property
    def arms(self) -> Floats:
        """What goes with each arm, (k, d)."""
        return self._arms[: self._k]

    def add(self, gain: Floats, arm: Floats) -> None:
        """Take in an arm, if no other is better."""
        if self._k == len(self._gains) < self._capacity:
            size = min(2 * self._k, self._capacity)
            self._gains, self._arms = _longer(self._gains, size), _longer(self._arms, size)
        self.volume += float(added(self._gains, self._k, gain))
        self._k = int(insert(self._gains, self._arms, self._k, gain, arm))

    def best(self, objective: int) -> int:
        """Return the number of the arm that is the best in an objective."""
        return int(np.argmax(self.gains[:, objective]))


class Archive:
    """One order's arms.

    Attributes:
        front: with each arm its point.
        told: trials told.
        pending: features of the arms asked and not told, by trial.
        volumes: what its front dominates, after each trial told.
        bests: for each objective that is maximised its best gain, likewise, one after the other.
    """

    def __init__(self, m: int, maximized: Sequence[int], d: int, features: int) -> None:
        self.front = Front(m, d)
        self.told = 0
        self.pending: dict[int, Floats] = {}
        self.volumes, self.bests = array("d"), array("d")
        self._maximized = maximized
        self._points, self._features, self._gains = np.empty((8, d)), np.empty((8, features)), np.empty((8, m))

    @property
    def points(self) -> Floats:
        """Points of the arms of late, (t, d)."""
        return self._points[: min(self.told, KEPT)]

    @property
    def features(self) -> Floats:
        """Features of the same, (t, f)."""
        return self._features[: min(self.told, KEPT)]

    @property
    def gains(self) -> Floats:
        """Gains of the same, (t, m); NaN of one that failed."""
        return self._gains[: min(self.told, KEPT)]

    @property
    def best(self) -> float:
        """The highest gain in any maximised objective; what the front dominates, if none is."""
        width = len(self._maximized)
        if not self.told or not width:
            return self.front.volume
        return max(self.bests[-width:])

    def tried(self, features: Floats) -> bool:
        """Return whether an arm of these features is in flight, or among those of late."""
        known = [self.features, *(each[None] for each in self.pending.values())]
        return any(bool((np.abs(rows - features).max(axis=1) < 1e-6).any()) for rows in known)

    def tell(self, trial: int, point: Floats, features: Floats, gain: Floats | None) -> None:
        """Take in what a trial came to; None if it failed."""
        self.pending.pop(trial, None)
        if self.told == len(self._points) < KEPT:
            size = 2 * self.told
            self._points, self._features = _longer(self._points, size), _longer(self._features, size)
            self._gains = _longer(self._gains, size)
        row = self.told % KEPT
        self._points[row], self._features[row] = point, features
        self._gains[row] = np.nan if gain is None else gain
        self.told += 1
        if gain is not None:
            self.front.add(gain, point)
        self.volumes.append(self.front.volume)
        for j in self._maximized:
            before = self.bests[-len(self._maximized)] if self.told > 1 else 0.0
            self.bests.append(before if gain is None else max(float(gain[j]), before))

    def gained(self) -> tuple[float, float]:
        """Return what the latter half of its trials brought: of the box, and the most of any maximised objective.

        Gains that fall off as a power of the trials make it an upper estimate of what as many trials more will bring.
        """
        width, half = len(self._maximized), self.told // 2
        if half == 0:
            return 1.0, 1.0
        now, then = self.bests[width * (self.told - 1) :], self.bests[width * (half - 1) : width * half]
        best = max((a - b for a, b in zip(now, then, strict=True)), default=0.0)
        return self.volumes[-1] - self.volumes[half - 1], best


def _longer(rows: Floats, size: int) -> Floats:
    longer = np.empty((size, rows.shape[1]))
    longer[: len(rows)] = rows
    return longer
