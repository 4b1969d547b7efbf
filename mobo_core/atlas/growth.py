"""How the hypervolume of an order's arms grew, and by how much more it may be expected to grow."""

from __future__ import annotations

from bisect import bisect_left

import numpy as np
from numpy.typing import NDArray

from mobo_core.search.front import Aims, RunningFront

Floats = NDArray[np.float64]

# Exponents of the power of the trials by which gains fall off; the likely one is that of a search whose distance
# from its limit halves whenever its trials are doubled.
_LEAST, _MOST, _LIKELY = 0.0, 6.0, 2.0
_HALVINGS = 60


def volumes_added(values: Floats, aims: Aims) -> Floats:
    """Return which share of the box (see :class:`~mobo_core.search.front.Aim`) each arm adds to those before it.

    Args:
        values: (n, objectives), in the order of the trials; NaN of one that failed, which adds nothing.
        aims: of the objectives.
    """
    if len(aims) == 2:
        return _areas_added(values, aims)
    front, added, before = RunningFront(aims), np.zeros(len(values)), 0.0
    for i, row in enumerate(values.tolist()):
        if not np.isnan(row).any():
            front.add(row)
            added[i], before = front.hypervolume - before, front.hypervolume
    return added


def _areas_added(values: Floats, aims: Aims) -> Floats:
    first, second = aims
    xs: list[float] = []  # of the front so far, ascending
    ys: list[float] = []  # of the same, descending
    added = np.zeros(len(values))
    for row, (a, b) in enumerate(values.tolist()):
        x, y = first.gain(a) / first.bound, second.gain(b) / second.bound
        if not (x > 0.0 and y > 0.0):
            continue
        at = last = bisect_left(xs, x)
        height = ys[at] if at < len(xs) else 0.0
        if height >= y:
            continue
        if at < len(xs) and xs[at] == x:
            last += 1
        # From x leftwards, step by step, until the front is as high.
        area, end = 0.0, x
        while at > 0 and ys[at - 1] <= y:
            at -= 1
            area += (end - xs[at]) * (y - height)
            end, height = xs[at], ys[at]
        area += (end - (xs[at - 1] if at else 0.0)) * (y - height)
        xs[at:last], ys[at:last] = [x], [y]
        added[row] = area
    return added


def expected_gain(added: Floats) -> float:
    """Return what as many trials again may be expected to add.

    The gain of trial t is taken to be c t^-b on average, as if gains fell off as a power of the trials. b is the one
    for which the mean of log t, trials weighted by their gains, is what it is in the history, and c that of the whole
    gain: the equations of quasi-likelihood for counts (McCullagh, Nelder, Generalized Linear Models, 1989, chapter
    9), so that trials that bring nothing, most of them, need no logarithm. Each trial counts t times: how the search
    began matters little. Gains come in lumps; that one lump more lay as the likely b has it keeps b from the ends of
    its range when there were few.

    Args:
        added: what each trial added, (n,).
    """
    n = len(added)
    if not added.any():
        return 0.0
    t = np.arange(1.0, n + 1.0)
    log_t, weighted = np.log(t), t * added
    lump = float(np.square(weighted).sum() / weighted.sum())

    def mean_log(b: float) -> float:
        weights = t ** (1.0 - b)
        return float((weights * log_t).sum() / weights.sum())

    wanted = (float((weighted * log_t).sum()) + lump * mean_log(_LIKELY)) / (float(weighted.sum()) + lump)
    low, high = (_LEAST, _MOST) if n > 1 else (_LIKELY, _LIKELY)
    for _ in range(_HALVINGS):
        b = 0.5 * (low + high)
        low, high = (b, high) if mean_log(b) > wanted else (low, b)
    scale = float(weighted.sum() / (t ** (1.0 - b)).sum())
    return scale * float(((t + n) ** -b).sum())
