"""Which trials count as good when there are two objectives: non-dominated rank, hypervolume for ties, weights.

The rules are those of Optuna's TPESampler. The best fronts are good as a whole. Of the first front that does not
fit, a greedy hypervolume subset selection (Guerreiro et al. 2016) takes the good ones. In Optuna 4 a good trial
weighs as much as the hypervolume that it alone adds (Ozaki et al. 2022).
Losses are to be minimised. Lists of trials are sorted by (first loss, second loss) throughout.
"""

from __future__ import annotations

import numpy as np

from mobo_core.search.samplers.tpe import compiled

# The least weight of a good trial, and what stands for a reference coordinate of zero.
EPS = 1e-12


@compiled
def insert_sorted(order: np.ndarray, count: int, loss: np.ndarray, trial: int) -> None:
    """Insert ``trial`` into the first ``count`` entries of ``order``, which are sorted by loss, shape (trials, 2)."""
    low, high = 0, count
    while low < high:
        middle = (low + high) // 2
        other = order[middle]
        if loss[other, 0] < loss[trial, 0] or (
            loss[other, 0] == loss[trial, 0] and loss[other, 1] <= loss[trial, 1]
        ):
            low = middle + 1
        else:
            high = middle
    for i in range(count, low, -1):
        order[i] = order[i - 1]
    order[low] = trial


@compiled
def _reference(worst: float) -> float:
    point = max(1.1 * worst, 0.9 * worst)
    return point if point != 0.0 else EPS


@compiled
def _select(x: np.ndarray, y: np.ndarray, size: int, chosen: np.ndarray) -> None:
    """Choose ``size`` points of one front, greedily by the hypervolume each adds to those chosen before."""
    n = x.size
    right, top = np.empty(n), np.empty(n)
    right[:], top[:] = _reference(x.max()), _reference(y.max())
    chosen[:] = False
    for _ in range(size):
        best, most = -1, -np.inf
        for i in range(n):
            if not chosen[i]:
                volume = (right[i] - x[i]) * (top[i] - y[i])
                if volume > most:
                    best, most = i, volume
        chosen[best] = True
        for i in range(best):
            right[i] = min(right[i], x[best])
        for i in range(best + 1, n):
            top[i] = min(top[i], y[best])


@compiled
def good_trials(order: np.ndarray, count: int, loss: np.ndarray, n_good: int, good: np.ndarray) -> None:
    """Mark the ``n_good`` best of ``count`` trials in ``good`` (one flag a trial number, all clear on entry)."""
    if n_good >= count:
        for i in range(count):
            good[order[i]] = True
        return
    # Ranks by patience sorting: a front takes a point that its last one does not dominate. Ranks from `cap` on
    # count as one; only if the fronts before do not hold enough are they told apart.
    rank, last = np.empty(count, np.int64), np.empty(count)
    size = np.zeros(count + 1, np.int64)
    cap = 16
    while True:
        size[:] = 0
        fronts, before = 0, 0
        for i in range(count):
            trial = order[i]
            y = loss[trial, 1]
            if i and loss[order[i - 1], 0] == loss[trial, 0] and loss[order[i - 1], 1] == y:
                rank[i] = rank[i - 1]  # equal points share their rank
            elif fronts == cap and last[cap - 1] <= y:
                rank[i] = cap
            else:
                low, high = 0, fronts
                while low < high:
                    middle = (low + high) // 2
                    if last[middle] > y:
                        high = middle
                    else:
                        low = middle + 1
                rank[i], last[low] = low, y
                fronts = max(fronts, low + 1)
            size[rank[i]] += 1
            before += rank[i] < cap
        if before > n_good or cap >= count:
            break
        cap = min(4 * cap, count)
    whole, taken = 0, 0
    while taken + size[whole] <= n_good:
        taken += size[whole]
        whole += 1
    tied = np.empty(size[whole], np.int64)
    n_tied = 0
    for i in range(count):
        if rank[i] < whole:
            good[order[i]] = True
        elif rank[i] == whole:
            tied[n_tied] = order[i]
            n_tied += 1
    if taken < n_good:
        _break_tie(tied, loss, n_good - taken, good)


@compiled
def _break_tie(tied: np.ndarray, loss: np.ndarray, size: int, good: np.ndarray) -> None:
    """Mark ``size`` of the trials of one front; of equal points the one of the lowest number stands for all."""
    first = np.empty(tied.size, np.int64)
    n = 0
    for i in range(tied.size):
        if n and loss[tied[i], 0] == loss[first[n - 1], 0] and loss[tied[i], 1] == loss[first[n - 1], 1]:
            first[n - 1] = min(first[n - 1], tied[i])
        else:
            first[n] = tied[i]
            n += 1
    first = first[:n]
    if n < size:
        for i in range(n):
            good[first[i]] = True
        rest = np.sort(tied)
        left = size - n
        for trial in rest:
            if left and not good[trial]:
                good[trial] = True
                left -= 1
        return
    x, y = np.empty(n), np.empty(n)
    for i in range(n):
        x[i], y[i] = loss[first[i], 0], loss[first[i], 1]
    chosen = np.ones(n, np.bool_)
    if n > size:
        _select(x, y, size, chosen)
    for i in range(n):
        if chosen[i]:
            good[first[i]] = True


@compiled
def hypervolume_weights(order: np.ndarray, count: int, loss: np.ndarray, good: np.ndarray, weight: np.ndarray) -> None:
    """Write the weight of every good trial into ``weight`` (by trial number): the hypervolume it alone adds."""
    front, n_good = np.empty(count, np.int64), 0
    n, least, worst_x, worst_y = 0, np.inf, -np.inf, -np.inf
    for i in range(count):
        trial = order[i]
        if not good[trial]:
            continue
        n_good += 1
        weight[trial] = EPS
        worst_x, worst_y = max(worst_x, loss[trial, 0]), max(worst_y, loss[trial, 1])
        same = n > 0 and loss[front[n - 1], 0] == loss[trial, 0] and loss[front[n - 1], 1] == loss[trial, 1]
        if loss[trial, 1] < least or same:  # equal points are on the front together, and add nothing each
            front[n] = trial
            n += 1
            least = loss[trial, 1]
    if n_good <= 1:
        for i in range(n):
            weight[front[i]] = 1.0
        return
    most = EPS
    right, top = _reference(worst_x), _reference(worst_y)
    for i in range(n):
        trial = front[i]
        x = loss[front[i + 1], 0] if i + 1 < n else right
        y = loss[front[i - 1], 1] if i else top
        weight[trial] = (x - loss[trial, 0]) * (y - loss[trial, 1])
        most = max(most, weight[trial])
    for i in range(n):
        weight[front[i]] = max(weight[front[i]] / most, EPS)
