"""Which order gets the next trial: some of them serve the front of all, others that every order is known alike."""

from __future__ import annotations

import math
from array import array

import numpy as np
from numpy.typing import NDArray

from mobo_core.jit.numerics import sin_cos
from mobo_core.search.samplers.structured.archive import Archive

Floats = NDArray[np.float64]

DIRECTIONS = 32
# The share of trials for the front of all, while the latter half of all trials brought more than so much of the box,
# and after.
FOR_ALL, FOR_ALL_KNOWN, KNOWN = 0.5, 0.2, 0.005
# An order is known to this precision if the latter half of its trials brought no more: of the box, of an objective.
VOLUME, BEST = 0.01, 0.02
# A known order gets a trial for every so many of one that is not.
_REST = 0.25
# What t trials of an order leave unknown at least: of its best value a share of _LEAST / t. Whose best is poor may
# still surprise: it counts as _POOR.
_LEAST, _POOR = 5.0, 0.1
# By how much an order of t trials may turn out better: _HOPE / sqrt(t + 1).
_HOPE = 0.3


def directions(m: int) -> Floats:
    """Return weights (DIRECTIONS, m), spread over the positive part of the sphere.

    The mean over all directions w of the highest min_k(gain_k / w_k)^m is in proportion to the hypervolume
    (Golovin, Zhang, Random Hypervolume Scalarizations, 2020).
    """
    weights = np.empty((DIRECTIONS, m))
    for i in range(DIRECTIONS):
        share = (i + 0.5) / DIRECTIONS
        # Steps of the golden ratio spread angles whose heights ascend.
        turn = 0.5 * math.pi * (share if m == 2 else (0.6180339887498949 * i) % 1.0)
        sine, cosine = sin_cos(turn)
        if m == 2:
            weights[i] = cosine, sine
        else:
            flat = math.sqrt(1.0 - share * share)
            weights[i] = flat * cosine, flat * sine, share
    return np.maximum(weights, 1e-3)


class Policy:
    """Counts trials, and says whose turn it is.

    Args:
        count: of orders.
        m: objectives.
    """

    def __init__(self, count: int, m: int) -> None:
        self._weights = directions(m)
        self._asked = np.zeros(count, np.int64)
        self._heights = np.zeros((DIRECTIONS, count))
        self._need = np.ones(count)
        self._volumes = array("d")

    def ask(self, order: int) -> None:
        """Count a trial of an order."""
        self._asked[order] += 1

    def tell(self, order: int, gain: Floats | None, archive: Archive, volume: float) -> None:
        """Take in a trial's gains, how far its order is known by now, and what the front of all dominates."""
        self._volumes.append(volume)
        if gain is not None:
            height = (np.maximum(gain, 0.0) / self._weights).min(axis=1)
            self._heights[:, order] = np.maximum(self._heights[:, order], height)
        gained, best = archive.gained()
        hope = _LEAST * max(archive.best, _POOR) / archive.told
        self._need[order] = min(max(gained / VOLUME, best / BEST, hope / BEST, _REST), 1.0)

    def serves_all(self, u: float) -> bool:
        """Return whether the trial that drew ``u`` is one for the front of all."""
        told = len(self._volumes)
        known = told > 1 and self._volumes[-1] - self._volumes[told // 2 - 1] < KNOWN
        return u < (FOR_ALL_KNOWN if known else FOR_ALL)

    def for_all(self, u: float) -> int:
        """Return the order that may add most to the front of all in a direction drawn by ``u``."""
        direction = int(u * DIRECTIONS)
        may_be = self._heights[direction] + _HOPE / np.sqrt(self._asked + 1.0)
        return int(np.argmax(may_be))

    def for_each(self) -> int:
        """Return the order of the fewest trials for what it needs."""
        return int(np.argmin((self._asked + 1.0) / self._need))
