"""Where the lengths and the base of an arm may be, and points drawn there.

A point is the lengths of the links in m, their total in m, the base's height in m and its tilt in rad, and in rad the
middles of those joints' ranges that are searched.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mobo_core.design import DesignSpace
from mobo_core.design.numbers import ends
from mobo_core.jit.functions import log
from mobo_core.jit.numerics import uniform
from mobo_core.search.samplers.structured import compiled

Floats = NDArray[np.float64]

# Share of the total below which a link that may be zero is: the best arms have links of no length.
_SNAP = 0.004
_ZERO = 0.3  # of the links of a point drawn anywhere
_STEPS = np.array([0.015, 0.04, 0.1, 0.25])  # of square roots of shares


class Region:
    """The points of a space.

    Attributes:
        low, high: (n + m,) of each coordinate, m = 3 or more; of a link, when it is not zero.
        zero: (n,) whether a link may be zero.
    """

    def __init__(self, space: DesignSpace) -> None:
        total = space.total_ends
        links = [allowed[-1] for allowed in space.links.allowed]
        bounds = [(low, min(high, total[1])) for low, high in links]
        bounds += [total, ends(space.base_height), ends(space.base_tilt), *space.searched_centers.values()]
        self.low, self.high = np.array(bounds).T.copy()
        self.zero = np.array([allowed[0][0] == 0.0 for allowed in space.links.allowed])

    @property
    def bounds(self) -> tuple[Floats, Floats, NDArray[np.bool_]]:
        """``low``, ``high`` and ``zero``."""
        return self.low, self.high, self.zero

    def features(self, points: Floats) -> Floats:
        """Return what the model sees of points (k, n + m), shape (k, n + m - 1).

        Lengths count on the square root's scale, as no length is unlike a little.
        """
        found = np.empty((len(points), len(self.low) - 1))
        _features(points, self.low, self.high, self.zero.size, found)
        return found


@compiled
def _features(points: Floats, low: Floats, high: Floats, n: int, found: Floats) -> None:
    for i in range(points.shape[0]):
        for j in range(n):
            found[i, j] = math.sqrt(max(points[i, j], 0.0) / high[n])
        for j in range(n + 1, low.size):
            wide = high[j] - low[j]
            found[i, j - 1] = 0.5 * (points[i, j] - low[j]) / wide if wide > 0.0 else 0.0


@compiled
def repair(x: Floats, low: Floats, high: Floats, zero: NDArray[np.bool_]) -> None:
    """Put a point to one near it that may be, but for rounding and for spaces with gaps in what lengths add up to."""
    n = zero.size
    for j in range(n, low.size):
        x[j] = min(max(x[j], low[j]), high[j])
    for i in range(n):
        if zero[i] and x[i] < max(_SNAP * x[n], 0.5 * low[i]):
            x[i] = 0.0
        else:
            x[i] = min(max(x[i], low[i]), high[i])
    for _ in range(3 * n):
        rest, room = x[n], 0.0
        for i in range(n):
            rest -= x[i]
        if abs(rest) <= 1e-13 * x[n]:
            break
        # What is missing goes to the links that have some, in proportion; what is too much likewise.
        for i in range(n):
            if x[i] > 0.0 and (x[i] < high[i] if rest > 0.0 else x[i] > low[i]):
                room += x[i]
        if room > 0.0:
            for i in range(n):
                if x[i] > 0.0 and (x[i] < high[i] if rest > 0.0 else x[i] > low[i]):
                    x[i] = min(max(x[i] + rest * (x[i] / room), low[i]), high[i])
            continue
        best = -1
        for i in range(n):
            if rest > 0.0 and x[i] == 0.0 and high[i] > 0.0 and (best < 0 or high[i] > high[best]):
                best = i
            if rest < 0.0 and zero[i] and x[i] > 0.0 and (best < 0 or x[i] < x[best]):
                best = i
        if best < 0:
            break
        x[best] = min(max(rest, low[best]), high[best]) if rest > 0.0 else 0.0


@compiled
def _normal(state: np.uint64, k: int) -> float:
    """Return a number of mean 0 and variance 1, nearly normal: the sum of three."""
    return 2.0 * (uniform(state, k) + uniform(state, k + 1) + uniform(state, k + 2)) - 3.0


@compiled
def spread(state: np.uint64, low: Floats, high: Floats, zero: NDArray[np.bool_], x: Floats) -> None:
    """Draw a point anywhere, faces included."""
    n = zero.size
    whole = 0.0
    for i in range(n):
        nothing = zero[i] and uniform(state, 2 * i) < _ZERO
        x[i] = 0.0 if nothing else -log(1.0 - uniform(state, 2 * i + 1))
        whole += x[i]
    for j in range(n, low.size):
        x[j] = low[j] + uniform(state, n + j) * (high[j] - low[j])
    for i in range(n):
        x[i] *= x[n] / max(whole, 1e-9)
    repair(x, low, high, zero)


@compiled
def _other(state: np.uint64, k: int, i: int, n: int) -> int:
    """Return one of 0 to n - 1 that is not i, if there is one."""
    j = int(uniform(state, k) * (n - 1)) if n > 1 else i
    return j + 1 if n > 1 and j >= i else j


@compiled
def vary(
    state: np.uint64, front: Floats, tried: Floats, low: Floats, high: Floats, zero: NDArray[np.bool_], x: Floats
) -> None:
    """Change a point a little, or let a link go.

    Args:
        state: of the random numbers.
        front: (k, n + m) of its order, one or more.
        tried: (t, n + m) of its order, one or more.
        low: see :class:`Region`.
        high: likewise.
        zero: likewise.
        x: the point, changed.
    """
    n = zero.size
    which = uniform(state, 0)
    total = x[n]
    if which < 0.3:
        # Differential evolution (Storn, Price 1997): along the difference of two others.
        a = int(uniform(state, 1) * front.shape[0])
        b = int(uniform(state, 2) * tried.shape[0])
        f = 0.2 + 0.8 * uniform(state, 3)
        for i in range(n):
            x[i] += f * (front[a, i] - tried[b, i])
    elif which < 0.65:
        step = _STEPS[int(uniform(state, 1) * _STEPS.size)]
        for i in range(n):
            if x[i] > 0.0 or uniform(state, 4 * i + 2) < 0.15:
                root = math.sqrt(x[i] / total) + step * _normal(state, 4 * i + 3)
                x[i] = total * root * root if root > 0.0 else 0.0
    elif which < 0.75:
        a = int(uniform(state, 1) * front.shape[0])
        for i in range(n):
            if uniform(state, i + 2) < 0.5:
                x[i] = front[a, i]
    else:
        # From one link to another: some, or all.
        i = int(uniform(state, 1) * n)
        j = _other(state, 2, i, n)
        share = 1.0 if which > 0.88 else uniform(state, 3)
        x[j] += share * x[i]
        x[i] -= share * x[i]
    for j in range(n, low.size):
        k = 100 + 6 * (j - n)
        if high[j] > low[j] and uniform(state, k) < 0.4:
            x[j] += 0.1 * (high[j] - low[j]) * _normal(state, k + 1)
            if uniform(state, k + 4) < 0.1:
                x[j] = low[j] if uniform(state, k + 5) < 0.5 else high[j]
    if x[n] != total:
        for i in range(n):
            x[i] *= x[n] / total
    repair(x, low, high, zero)
