"""What is expected of the lengths not tried, from those that were: a Gaussian process for each order.

Rasmussen, Williams, Gaussian Processes for Machine Learning, 2006, algorithm 2.1, with a Matern kernel of 5/2. All
loops run in a fixed order, innermost along rows, so that the bits are the same on every machine.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mobo_core.jit.functions import exp
from mobo_core.search.samplers.structured import compiled

Floats = NDArray[np.float64]

# Over which distance of square roots of shares of the length values become unlike, and what of the variance is no
# function of the lengths, as poses are few: of few arms from anywhere, and of many near a front. By table, see
# docs/search.md.
WIDE, NEAR = (1.2, 0.005), (0.5, 0.02)
# What an arm's mirror twin says of it: the same lengths meet other poses.
TWIN = 0.97
_ROOT_5 = 2.23606797749979
# Square of a distance within which two arms are one.
_SAME = 1e-12


@compiled
def _kernel(z: Floats, i: int, other: Floats, j: int, scale: float) -> float:
    square = 0.0
    for k in range(z.shape[1]):
        step = z[i, k] - other[j, k]
        square += step * step
    r = math.sqrt(square) * (_ROOT_5 / scale)
    return (1.0 + r + r * r * (1.0 / 3.0)) * exp(-r)


@compiled
def nearest(z: Floats, n: int, centre: Floats, count: int) -> NDArray[np.int64]:
    """Return the numbers of the ``count`` rows of the first n that are nearest to ``centre``, the nearest first."""
    square = np.zeros(n)
    for i in range(n):
        for k in range(centre.size):
            step = z[i, k] - centre[k]
            square[i] += step * step
    return np.argsort(square, kind="mergesort")[:count]


@compiled
def predict(
    z: Floats,
    gains: Floats,
    twin: NDArray[np.bool_],
    told: int,
    asked: Floats,
    scale: float,
    noise: float,
    mean: Floats,
    deviation: Floats,
) -> None:
    """Predict the gains of arms that were not tried.

    Args:
        z: (n, d) of arms tried; those from ``told`` on have no values yet, and only make less of what is unknown
            near them.
        gains: (told, m) of those told; NaN of one that failed, which counts as the mean of the others.
        twin: (n,) whether it is the twin's.
        told: 1 or more.
        asked: (q, d) of the arms asked about.
        scale: see :data:`WIDE`.
        noise: likewise.
        mean: (q, m) receives what is expected.
        deviation: (q, m) receives how far off that may be; -1 for an arm that was tried.
    """
    n, q, m = z.shape[0], asked.shape[0], gains.shape[1]
    root = np.empty((n, n))
    for i in range(n):
        root[i, i] = 1.0 + noise
        for j in range(i + 1, n):
            root[i, j] = _kernel(z, i, z, j, scale) * (1.0 if twin[i] == twin[j] else TWIN)
    cross = np.empty((n, q))
    tried = np.zeros(q, np.bool_)
    for i in range(n):
        alike = TWIN if twin[i] else 1.0
        for c in range(q):
            cross[i, c] = _kernel(z, i, asked, c, scale) * alike
            if cross[i, c] > 1.0 - _SAME:
                tried[c] = True
    # Cholesky: the upper triangle becomes R with R^T R = K.
    for j in range(n):
        pivot = 1.0 / math.sqrt(root[j, j])
        for k in range(j, n):
            root[j, k] *= pivot
        for i in range(j + 1, n):
            factor = root[j, i]
            for k in range(i, n):
                root[i, k] -= factor * root[j, k]
    # R^-T k for all arms asked about at once.
    for j in range(n):
        pivot = 1.0 / root[j, j]
        for c in range(q):
            cross[j, c] *= pivot
        for i in range(j + 1, n):
            factor = root[j, i]
            for c in range(q):
                cross[i, c] -= factor * cross[j, c]
    rest = np.ones(q)
    for i in range(n):
        for c in range(q):
            rest[c] -= cross[i, c] * cross[i, c]
    w = np.empty(told)
    for k in range(m):
        middle, spread = _moments(gains, told, k)
        for i in range(told):
            w[i] = 0.0 if np.isnan(gains[i, k]) else gains[i, k] - middle
        for j in range(told):
            w[j] /= root[j, j]
            for i in range(j + 1, told):
                w[i] -= root[j, i] * w[j]
        for c in range(q):
            mean[c, k] = middle
            deviation[c, k] = -1.0 if tried[c] else spread * math.sqrt(max(rest[c], 0.0))
        for i in range(told):
            for c in range(q):
                mean[c, k] += w[i] * cross[i, c]


@compiled
def _moments(gains: Floats, n: int, k: int) -> tuple[float, float]:
    """Return mean and standard deviation of a column's first n, those left out that are no numbers."""
    middle, square, count = 0.0, 0.0, 0
    for i in range(n):
        if not np.isnan(gains[i, k]):
            middle += gains[i, k]
            count += 1
    middle /= max(count, 1)
    for i in range(n):
        if not np.isnan(gains[i, k]):
            square += (gains[i, k] - middle) * (gains[i, k] - middle)
    return middle, max(math.sqrt(square / max(count, 1)), 1e-3)
