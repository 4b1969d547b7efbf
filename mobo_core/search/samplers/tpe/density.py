"""Parzen estimators over categorical and real parameters, as arrays: fitted, drawn from, evaluated.

One estimator is a mixture of one kernel a trial and a prior. A kernel is a product over the parameters: of a
categorical distribution that favours the trial's choice, and of normal distributions around its values, cut off
at the parameter's bounds (Bergstra et al. 2011; for several parameters at once, Falkner et al. 2018).
"""

from __future__ import annotations

import numpy as np

from mobo_core.jit.functions import LOG2_E, exp2, log, power
from mobo_core.jit.normal import TAIL_END, between, far_mass, half_mass, log_mass
from mobo_core.search.samplers.tpe import compiled

# Scott's rule has this share of the range as its bandwidth at one trial (Optuna 4's multivariate TPE).
_SCOTT = 0.2
_LEAST_SHARE = 100.0
_ROOT_HALF_LOG2_E = 0.8493218002880191  # its square is log2(e) / 2


@compiled
def scott_bandwidths(n: int, dimensions: int, low: np.ndarray, high: np.ndarray, sigma: np.ndarray) -> None:
    """Write one bandwidth a real parameter for all of ``n`` trials into ``sigma``, shape (n, parameters)."""
    share = _SCOTT * power(float(max(n, 1)), -1.0 / (dimensions + 4))
    for d in range(low.size):
        span = high[d] - low[d]
        sigma[:, d] = min(max(share * span, span / min(_LEAST_SHARE, n + 2.0)), span)


@compiled
def neighbour_bandwidths(mu: np.ndarray, low: np.ndarray, high: np.ndarray, sigma: np.ndarray) -> None:
    """Write bandwidths into ``sigma``, like ``mu`` of shape (n, parameters): the wider gap to a neighbour's value.

    The rule of Optuna's univariate TPE, and in Optuna 5 of the multivariate one.
    """
    n = mu.shape[0]
    for d in range(low.size):
        span = high[d] - low[d]
        least = span / min(_LEAST_SHARE, n + 2.0)
        order = np.argsort(mu[:, d])
        for i in range(n):
            here = mu[order[i], d]
            left = here - (mu[order[i - 1], d] if i else low[d])
            right = (mu[order[i + 1], d] if i + 1 < n else high[d]) - here
            if n > 1 and i == 0:
                left = right
            if n > 1 and i + 1 == n:
                right = left
            sigma[order[i], d] = min(max(max(left, right), least), span)


@compiled
def fit(
    mu: np.ndarray, sigma: np.ndarray, weight: np.ndarray, low: np.ndarray, high: np.ndarray,
    central: np.ndarray, tail: np.ndarray, inverse: np.ndarray, scaled: np.ndarray,
    factor: np.ndarray, offset: np.ndarray,
) -> None:  # fmt: skip
    """Prepare n kernels whose last one is the prior.

    ``mu`` and ``sigma`` have shape (n, real parameters); ``weight`` (n,) may have any sum; ``low`` and ``high``
    are the parameters' bounds, ``central`` and ``tail`` the tables of :mod:`~mobo_core.jit.normal`.

    Written are ``inverse`` = c / sigma and ``scaled`` = c mu / sigma, and ``factor`` and ``offset``, shape (n,).
    Kernel i is factor 2^(offset - sum (x inverse - scaled)^2) times its categorical part, where c = sqrt(log2(e) / 2)
    turns e^(-z^2/2) into a power of 2.
    """
    n, reals = mu.shape
    total = 0.0
    for i in range(n):
        total += weight[i]
    seen, reciprocal = np.zeros(reals), np.zeros(reals)  # most kernels have the bandwidth of the one before
    for i in range(n):
        mass, off = 1.0, 0.0
        for d in range(reals):
            if sigma[i, d] != seen[d]:
                seen[d], reciprocal[d] = sigma[i, d], 1.0 / sigma[i, d]
            s = reciprocal[d]
            a, b = (low[d] - mu[i, d]) * s, (high[d] - mu[i, d]) * s
            inverse[i, d], scaled[i, d] = _ROOT_HALF_LOG2_E * s, mu[i, d] * (_ROOT_HALF_LOG2_E * s)
            mass *= sigma[i, d]
            near = max(a, -b)
            share = half_mass(b, central) - half_mass(a, central) if near < 3.0 else 0.0
            if near <= 0.0 or share > 1e-4:
                mass *= share
            # The trial's value lies outside the bounds of today, so far that the share is better a logarithm.
            elif near < TAIL_END:
                off -= log_mass(a, b, central, tail)
            else:
                m, e = far_mass(a, b)
                mass *= m
                off -= e
        factor[i], offset[i] = weight[i] / (total * mass), off * LOG2_E


@compiled
def draw(
    u: np.ndarray, weight: np.ndarray, mu: np.ndarray, sigma: np.ndarray, codes: np.ndarray, choices: np.ndarray,
    categorical: np.ndarray, low: np.ndarray, high: np.ndarray, central: np.ndarray, tail: np.ndarray,
    x: np.ndarray, c: np.ndarray,
) -> None:  # fmt: skip
    """Draw points from an estimator, given as to :func:`fit`.

    ``u`` holds uniform numbers, shape (1 + parameters, points): for the kernel, for each categorical parameter
    in turn, for each real one. ``codes``, shape (n, categorical parameters), are the numbers of the trials'
    choices, -1 for the prior, ``choices`` how many there are, and ``categorical``, shape (categorical
    parameters, 2), the probabilities of a kernel's own choice and of each other one.

    Written are the real values ``x``, shape (real parameters, points), and the choices ``c``, likewise.
    """
    n, points = weight.size, u.shape[1]
    share = np.empty(n)
    total = 0.0
    for i in range(n):
        total += weight[i]
        share[i] = total
    for p in range(points):
        kernel = min(np.searchsorted(share, u[0, p] * total, side="right"), n - 1)
        for d in range(choices.size):
            sum_, choice = 0.0, 0
            while choice < choices[d] - 1:
                if codes[kernel, d] < 0:
                    sum_ += 1.0 / choices[d]
                else:
                    sum_ += categorical[d, 0] if codes[kernel, d] == choice else categorical[d, 1]
                if sum_ >= u[1 + d, p]:
                    break
                choice += 1
            c[d, p] = choice
        for d in range(low.size):
            s, m = sigma[kernel, d], mu[kernel, d]
            z = between(u[1 + choices.size + d, p], (low[d] - m) / s, (high[d] - m) / s, central, tail)
            x[d, p] = min(max(z * s + m, low[d]), high[d])


@compiled
def log_density(
    x: np.ndarray, c: np.ndarray, inverse: np.ndarray, scaled: np.ndarray, factor: np.ndarray, offset: np.ndarray,
    codes: np.ndarray, choices: np.ndarray, categorical: np.ndarray, out: np.ndarray,
) -> None:  # fmt: skip
    """Write the log density of an estimator at points into ``out``; arguments as in :func:`fit` and :func:`draw`."""
    n, points, reals, cats = factor.size, out.size, x.shape[0], choices.size
    total, e = np.zeros(points), np.empty(points)
    own, other, none, uniform = np.empty(cats), np.empty(cats), 0.0, 0.0
    for d in range(cats):
        other[d] = LOG2_E * log(categorical[d, 1])
        own[d] = LOG2_E * log(categorical[d, 0]) - other[d]
        none += other[d]
        uniform -= LOG2_E * log(float(choices[d]))
    for i in range(n):
        base = offset[i] + (none if i < n - 1 else uniform)
        for p in range(points):
            e[p] = base
        for d in range(cats):
            code, gain = codes[i, d], own[d]
            for p in range(points):
                e[p] += gain if c[d, p] == code else 0.0
        for d in range(reals):
            s, m = inverse[i, d], scaled[i, d]
            for p in range(points):
                z = x[d, p] * s - m
                e[p] -= z * z
        f = factor[i]
        for p in range(points):
            total[p] += f * exp2(e[p])
    root = 2.5066282746310002  # of 2 pi
    for p in range(points):
        out[p] = log(total[p]) - reals * log(root)
