"""Parzen estimators over categorical and real parameters, as arrays: fitted, drawn from, evaluated.

One estimator is a mixture of one kernel a trial and a prior. A kernel is a product over the parameters: of a
categorical distribution that favours the trial's choice, and of normal distributions around its values, cut off
at the parameter's bounds (Bergstra et al. 2011; for several parameters at once, Falkner et al. 2018).
"""

from __future__ import annotations

import numpy as np

from mobo_core.jit.functions import LOG2_E, exp2, log, power
from mobo_core.jit.normal import CENTRAL_END, CENTRAL_STEPS, TAIL_END, between, far_mass, half_mass, log_mass
from mobo_core.search.samplers.tpe import compiled

# Scott's rule has this share of the range as its bandwidth at one trial (Optuna 4's multivariate TPE).
_SCOTT = 0.2
_LEAST_SHARE = 100.0
_ROOT_HALF_LOG2_E = 0.8493218002880191  # its square is log2(e) / 2
# Real parameters that log_density takes at a time.
WIDTH = 6
_BLOCK = 1024


@compiled
def scott_bandwidths(n: int, dimensions: int, low: np.ndarray, high: np.ndarray, sigma: np.ndarray) -> None:
    """Write one bandwidth a real parameter for all of ``n`` trials into ``sigma``, shape (parameters,)."""
    share = _SCOTT * power(float(max(n, 1)), -1.0 / (dimensions + 4))
    for d in range(low.size):
        span = high[d] - low[d]
        sigma[d] = min(max(share * span, span / min(_LEAST_SHARE, n + 2.0)), span)


@compiled
def neighbour_bandwidths(mu: np.ndarray, n: int, low: np.ndarray, high: np.ndarray, sigma: np.ndarray) -> None:
    """Write the first ``n`` trials' bandwidths into ``sigma``: the wider gap to a neighbour's value.

    The rule of Optuna's univariate TPE, and in Optuna 5 of the multivariate one.
    """
    for d in range(low.size):
        value = mu[mu.shape[0] - low.size + d, :n]
        span = high[d] - low[d]
        least = span / min(_LEAST_SHARE, n + 2.0)
        order = np.argsort(value)
        for i in range(n):
            here = value[order[i]]
            left = here - (value[order[i - 1]] if i else low[d])
            right = (value[order[i + 1]] if i + 1 < n else high[d]) - here
            if n > 1 and i == 0:
                left = right
            if n > 1 and i + 1 == n:
                right = left
            sigma[d, order[i]] = min(max(max(left, right), least), span)


@compiled
def _column(i: int, n: int, sigma: np.ndarray) -> int:
    """Return the column of ``sigma`` that holds the bandwidths of kernel i of n, see :func:`volumes`."""
    last = sigma.shape[1] - 1
    column: int = last if i == n - 1 else min(i, last - 1)
    return column


@compiled
def volumes(
    mu: np.ndarray, sigma: np.ndarray, first: int, low: np.ndarray, high: np.ndarray,
    central: np.ndarray, tail: np.ndarray, volume: np.ndarray, offset: np.ndarray,
) -> None:  # fmt: skip
    """Write what the kernels from ``first`` on, to be normalised, are divided by but for powers of root 2 pi.

    It is the product over the parameters of bandwidth and share of the normal distribution within the bounds:
    ``volume``, shape (n,) for n kernels whose last one is the prior, times 2^-offset. ``mu`` has shape (real
    parameters, n), but for WIDTH rows at least, the first ones empty then; ``sigma`` has a row for each parameter and
    a column for each kernel, or two, one for all trials and one for the prior; ``low`` and ``high`` are the bounds,
    ``central`` and ``tail`` the tables of :mod:`~mobo_core.jit.normal`.
    """
    n, reals = mu.shape[1], low.size
    lead = mu.shape[0] - reals
    for i in range(first, n):
        product, off, k = 1.0, 0.0, _column(i, n, sigma)
        for d in range(reals):
            m, s = mu[lead + d, i], 1.0 / sigma[d, k]
            a, b = (low[d] - m) * s, (high[d] - m) * s
            product *= sigma[d, k]
            near = max(a, -b)
            share = half_mass(b, central) - half_mass(a, central) if near < 3.0 else 0.0
            if near <= 0.0 or share > 1e-4:
                product *= share
            # The trial's value lies outside the bounds of today, so far that the share is better a logarithm.
            elif near < TAIL_END:
                off -= log_mass(a, b, central, tail)
            else:
                near_mass, e = far_mass(a, b)
                product *= near_mass
                off -= e
        volume[i], offset[i] = product, off * LOG2_E


@compiled
def multiply_volumes(
    ascending: np.ndarray, numbers: np.ndarray, low: float, high: float, sigma: float, central: np.ndarray,
    volume: np.ndarray,
) -> None:  # fmt: skip
    """Multiply by one parameter's part of :func:`volumes`, to the bit, for one bandwidth and values within the bounds.

    ``ascending`` are the values, ``numbers`` their trials', which ``volume`` goes by. Values that share a node of
    the table lie side by side: its polynomial is taken of all of them at once.
    """
    s = 1.0 / sigma
    nodes, rest, mass = np.empty(_BLOCK, np.int32), np.empty(_BLOCK), np.empty(_BLOCK)
    for start in range(0, ascending.size, _BLOCK):
        values = ascending[start : start + _BLOCK]
        n = values.size
        mass[:] = 0.0
        for upper in range(2):
            bound = high if upper else low
            for i in range(n):
                u = abs((bound - values[i]) * s)
                node = int(min(u, CENTRAL_END) * CENTRAL_STEPS + 0.5)
                rest[i] = u - node * (1.0 / CENTRAL_STEPS)
                nodes[i] = -1 if u >= CENTRAL_END else node
            first = 0
            while first < n:
                node, last = nodes[first], first + 1
                while last < n and nodes[last] == node:
                    last += 1
                if node < 0:
                    for i in range(first, last):
                        mass[i] += 0.5
                else:
                    t = central[node]
                    t0, t1, t2, t3, t4, t5, t6, t7, t8 = t[0], t[1], t[2], t[3], t[4], t[5], t[6], t[7], t[8]
                    here, to = rest[first:last], mass[first:last]
                    for i in range(here.size):
                        r = here[i]
                        p = ((((t8 * r + t7) * r + t6) * r + t5) * r + t4) * r + t3
                        to[i] += ((p * r + t2) * r + t1) * r + t0
                first = last
        for i in range(n):
            number = numbers[start + i]
            volume[number] = volume[number] * sigma * mass[i]


@compiled
def fit(weight: np.ndarray, volume: np.ndarray, sigma: np.ndarray, factor: np.ndarray, inverse: np.ndarray) -> None:
    """Prepare n kernels from ``weight``, shape (n,) and of any sum, and :func:`volumes`.

    Kernel i is factor 2^(offset - sum ((x - mu) inverse)^2) times its categorical part, where ``inverse`` = c / sigma,
    of as many rows as ``mu``, and c = sqrt(log2(e) / 2) turns e^(-z^2/2) into a power of 2.
    """
    total, lead = 0.0, inverse.shape[0] - sigma.shape[0]
    for i in range(weight.size):
        total += weight[i]
    for i in range(weight.size):
        factor[i] = weight[i] / (total * volume[i])
    inverse[:lead] = 0.0
    for d in range(sigma.shape[0]):
        for i in range(sigma.shape[1]):
            inverse[lead + d, i] = _ROOT_HALF_LOG2_E * (1.0 / sigma[d, i])


@compiled
def draw(
    u: np.ndarray, weight: np.ndarray, mu: np.ndarray, sigma: np.ndarray, codes: np.ndarray, choices: np.ndarray,
    categorical: np.ndarray, low: np.ndarray, high: np.ndarray, central: np.ndarray, tail: np.ndarray,
    x: np.ndarray, c: np.ndarray,
) -> None:  # fmt: skip
    """Draw points from an estimator, given as to :func:`volumes` and :func:`fit`.

    ``u`` holds uniform numbers, shape (1 + parameters, points): for the kernel, for each categorical parameter
    in turn, for each real one. ``codes``, shape (categorical parameters, n), are the numbers of the trials'
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
                if codes[d, kernel] < 0:
                    sum_ += 1.0 / choices[d]
                else:
                    sum_ += categorical[d, 0] if codes[d, kernel] == choice else categorical[d, 1]
                if sum_ >= u[1 + d, p]:
                    break
                choice += 1
            c[d, p] = choice
        for d in range(low.size):
            s, m = sigma[d, _column(kernel, n, sigma)], mu[mu.shape[0] - low.size + d, kernel]
            z = between(u[1 + choices.size + d, p], (low[d] - m) / s, (high[d] - m) / s, central, tail)
            x[d, p] = min(max(z * s + m, low[d]), high[d])


@compiled
def _add_kernels(
    first: int, last: int, parts: np.ndarray, keys: np.ndarray, x: np.ndarray, mu: np.ndarray, inverse: np.ndarray,
    factor: np.ndarray, total: np.ndarray,
) -> None:  # fmt: skip
    """Add kernels ``first`` to ``last`` - 1 to ``total``, (points,), of the last WIDTH real parameters.

    Row keys[i] of ``parts`` is the power of 2 that all else of kernel i comes to.
    """
    x0, x1, x2, x3, x4, x5 = x[-6], x[-5], x[-4], x[-3], x[-2], x[-1]
    m0, m1, m2, m3, m4, m5 = mu[-6], mu[-5], mu[-4], mu[-3], mu[-2], mu[-1]
    s0, s1, s2, s3, s4, s5 = inverse[-6], inverse[-5], inverse[-4], inverse[-3], inverse[-2], inverse[-1]
    for i in range(first, last):
        part, f, k = parts[keys[i]], factor[i], _column(i, factor.size, inverse)
        a0, a1, a2, a3, a4, a5 = s0[k], s1[k], s2[k], s3[k], s4[k], s5[k]
        b0, b1, b2, b3, b4, b5 = m0[i] * a0, m1[i] * a1, m2[i] * a2, m3[i] * a3, m4[i] * a4, m5[i] * a5
        for p in range(total.size):
            z0, z1, z2 = x0[p] * a0 - b0, x1[p] * a1 - b1, x2[p] * a2 - b2
            z3, z4, z5 = x3[p] * a3 - b3, x4[p] * a4 - b4, x5[p] * a5 - b5
            total[p] += f * exp2(part[p] - z0 * z0 - z1 * z1 - z2 * z2 - z3 * z3 - z4 * z4 - z5 * z5)


@compiled
def log_density(
    x: np.ndarray, c: np.ndarray, mu: np.ndarray, inverse: np.ndarray, factor: np.ndarray, offset: np.ndarray,
    codes: np.ndarray, choices: np.ndarray, categorical: np.ndarray, out: np.ndarray,
) -> None:  # fmt: skip
    """Write the log density of an estimator at points into ``out``; arguments as in :func:`fit` and :func:`draw`.

    The kernels are added in their order, each of them to all points at once.
    """
    n, points, reals, cats, rows = factor.size, out.size, x.shape[0], choices.size, mu.shape[0]
    own, other, none, uniform = np.empty(cats), np.empty(cats), 0.0, 0.0
    stride, n_keys, keys = np.empty(cats, np.int64), 1, np.zeros(n, np.int32)
    for d in range(cats):
        other[d] = LOG2_E * log(categorical[d, 1])
        own[d] = LOG2_E * log(categorical[d, 0]) - other[d]
        none += other[d]
        uniform -= LOG2_E * log(float(choices[d]))
        stride[d] = n_keys
        n_keys = n_keys * choices[d] if n_keys <= n else n_keys
    at, total, alike = np.zeros((rows, points)), np.zeros(points), 0
    at[rows - reals :] = x
    if n_keys <= n and rows == WIDTH and not offset.any():
        # Kernels of the same choices, of which there are not many, share their part; the prior is no such kernel.
        alike = n - 1
        parts = np.empty((n_keys, points))
        for key in range(n_keys):
            parts[key] = none
            for d in range(cats):
                code, gain = key // stride[d] % choices[d], own[d]
                for p in range(points):
                    parts[key, p] += gain if c[d, p] == code else 0.0
        for d in range(cats):
            for i in range(alike):
                keys[i] += codes[d, i] * stride[d]
        _add_kernels(0, alike, parts, keys, at, mu, inverse, factor, total)
    keys[alike:] = 0
    part = np.empty((1, points))
    e = part[0]
    for i in range(alike, n):
        e[:] = offset[i] + (none if i < n - 1 else uniform)
        for d in range(cats):
            code, gain = codes[d, i], own[d]
            for p in range(points):
                e[p] += gain if c[d, p] == code else 0.0
        k = _column(i, n, inverse)
        for d in range(rows - WIDTH):
            s = inverse[d, k]
            m = mu[d, i] * s
            for p in range(points):
                z = at[d, p] * s - m
                e[p] -= z * z
        _add_kernels(i, i + 1, part, keys, at, mu, inverse, factor, total)
    root = 2.5066282746310002  # of 2 pi
    for p in range(points):
        out[p] = log(total[p]) - reals * log(root)
