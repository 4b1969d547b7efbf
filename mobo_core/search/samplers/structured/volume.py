"""Small Pareto fronts of two or three gains, compiled: what a point adds to the hypervolume, and taking it in.

Gains are shares of the hypervolume's box: 0 at the reference point, 1 at the best end, more is better. A front is an
array of gains, shape (capacity, m), of which the first k rows hold. Two objectives: the first ascends, so that the
second descends. Three: the last descends.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mobo_core.search.samplers.structured import compiled

Floats = NDArray[np.float64]


@compiled
def _strip(xs: Floats, ys: Floats, k: int, x: float, y: float) -> float:
    """Return the area of [0, x] x [0, y] that k points do not cover, whose xs ascend and whose ys descend."""
    area: float = 0.0
    covered: float = 0.0
    for i in range(k):
        if covered >= x:
            break
        end = min(xs[i], x)
        if end > covered:
            area += (end - covered) * max(0.0, y - max(ys[i], 0.0))
            covered = end
    area += max(0.0, x - covered) * y
    return area


@compiled
def added(front: Floats, k: int, gain: Floats) -> float:
    """Return the share of the box that a point of these gains dominates and the front does not."""
    m = gain.size
    for j in range(m):
        if gain[j] <= 0.0:
            return 0.0
    if m == 2:
        only: float = _strip(front[:, 0], front[:, 1], k, gain[0], gain[1])
        return only
    xs, ys, size = np.empty(k), np.empty(k), 0
    volume: float = 0.0
    top = gain[2]
    for i in range(k):
        level = min(front[i, 2], gain[2])
        if level <= 0.0:
            break
        volume += _strip(xs, ys, size, gain[0], gain[1]) * (top - level)
        top = level
        # The staircase of all points above this level takes in the next one.
        x, y = front[i, 0], front[i, 1]
        first = 0
        while first < size and xs[first] < x:
            first += 1
        if first < size and ys[first] >= y:
            continue
        kept = first
        while kept > 0 and ys[kept - 1] <= y:
            kept -= 1
        while first < size and xs[first] <= x:
            first += 1
        gone = first - kept
        if gone == 0:
            for j in range(size, kept, -1):
                xs[j], ys[j] = xs[j - 1], ys[j - 1]
        else:
            for j in range(first, size):
                xs[j - gone + 1], ys[j - gone + 1] = xs[j], ys[j]
        xs[kept], ys[kept] = x, y
        size += 1 - gone
    volume += _strip(xs, ys, size, gain[0], gain[1]) * top
    return volume


@compiled
def _move(front: Floats, arms: Floats, source: int, to: int) -> None:
    for j in range(front.shape[1]):
        front[to, j] = front[source, j]
    for j in range(arms.shape[1]):
        arms[to, j] = arms[source, j]


@compiled
def _drop(front: Floats, arms: Floats, k: int) -> None:
    """Take out the row that adds least, of those that are not the best in an objective."""
    m = front.shape[1]
    least, out = np.inf, 0
    others, point = np.empty((k - 1, m)), np.empty(m)
    for i in range(k):
        best = False
        for j in range(m):
            point[j] = front[i, j]
            highest = True
            for other in range(k):
                highest = highest and front[other, j] <= point[j]
            best = best or highest
        if best and k > m:
            continue
        row = 0
        for other in range(k):
            if other != i:
                for j in range(m):
                    others[row, j] = front[other, j]
                row += 1
        alone = added(others, k - 1, point)
        if alone < least:
            least, out = alone, i
    for i in range(out, k - 1):
        _move(front, arms, i + 1, i)


@compiled
def insert(front: Floats, arms: Floats, k: int, gain: Floats, arm: Floats) -> int:
    """Take a point and what goes with it into a front, if no other dominates or equals it; return the new size.

    What it dominates goes. One that is full loses the one that adds least.

    Args:
        front: gains (capacity, m).
        arms: what goes with each (capacity, d).
        k: rows that hold.
        gain: (m,).
        arm: (d,).
    """
    m = gain.size
    kept = 0
    for i in range(k):
        no_better, no_worse = True, True
        for j in range(m):
            no_better = no_better and gain[j] <= front[i, j]
            no_worse = no_worse and gain[j] >= front[i, j]
        if no_better:
            return k
        if not no_worse:
            if kept < i:
                _move(front, arms, i, kept)
            kept += 1
    k = kept
    if k == front.shape[0]:
        _drop(front, arms, k)
        k -= 1
    at = k
    while at > 0 and (front[at - 1, 0] > gain[0] if m == 2 else front[at - 1, 2] < gain[m - 1]):
        _move(front, arms, at - 1, at)
        at -= 1
    for j in range(m):
        front[at, j] = gain[j]
    for j in range(arms.shape[1]):
        arms[at, j] = arm[j]
    return k + 1


@compiled
def most_adding(front: Floats, mean: Floats, deviation: Floats, hope: float, extreme: int) -> int:
    """Return the point that, by so many deviations better than expected, adds most to a front.

    No gain is taken to be above 1, the end of the box, or the best so far. What adds nothing counts below zero, by how
    low the product of its gains is. With ``extreme`` it is that gain that counts.
    """
    q, m = mean.shape
    best, highest = 0, -np.inf
    may_be, ceiling = np.empty(m), np.ones(m)
    for i in range(front.shape[0]):
        for k in range(m):
            ceiling[k] = max(ceiling[k], front[i, k])
    for c in range(q):
        if deviation[c, 0] < 0.0:
            continue
        product = 1.0
        for k in range(m):
            may_be[k] = mean[c, k] + hope * deviation[c, k]
            if extreme < 0:
                may_be[k] = min(may_be[k], ceiling[k])
            product *= min(max(may_be[k], 1e-6), 1.0)
        value = may_be[extreme] if extreme >= 0 else added(front, front.shape[0], may_be)
        if extreme < 0 and value <= 0.0:
            value = product - 1.0
        if value > highest:
            best, highest = c, value
    return best
