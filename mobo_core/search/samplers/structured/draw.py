"""Random numbers of a trial, and the points that they make."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mobo_core.jit.numerics import mix, uniform
from mobo_core.search.samplers.structured import compiled
from mobo_core.search.samplers.structured.region import repair, spread, vary

Floats = NDArray[np.float64]


class Stream:
    """Random numbers, one after the other."""

    def __init__(self, state: np.uint64) -> None:
        self._state, self._k = state, 0

    def uniform(self) -> float:
        """Return a number in [0, 1)."""
        self._k += 1
        return float(uniform(self._state, self._k))

    def below(self, count: int) -> int:
        """Return one of 0 to count - 1."""
        return int(self.uniform() * count)

    def fork(self) -> np.uint64:
        """Return the state of another stream."""
        self._k += 1
        return np.uint64(mix(self._state, 1 << 40 | self._k))


@compiled
def draw(
    state: np.uint64, anywhere: int, lent: int, front: Floats, tried: Floats, low: Floats, high: Floats,
    zero: NDArray[np.bool_], points: Floats,
) -> None:  # fmt: skip
    """Draw the first points anywhere; leave the first half of those lent as they are; change all others."""
    for c in range(points.shape[0]):
        own = mix(state, 1000 + c)
        if c < anywhere:
            spread(own, low, high, zero, points[c])
        elif c < anywhere + lent // 2:
            repair(points[c], low, high, zero)
        else:
            vary(own, front, tried, low, high, zero, points[c])
