"""The normal distribution, of the functions in :mod:`mobo_core.jit.functions`: the same bits on every x86-64 machine.

Phi is the share of a standard normal distribution below a number, phi its density. Near the middle and in the tail
they come from tables of Taylor series, far out from an asymptotic series.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mobo_core.jit import functions
from mobo_core.jit.cache import Cache
from mobo_core.jit.functions import exp, log

compiled = Cache("normal", [__file__, functions.__file__]).compiled

_LOG_ROOT_2_PI, _ROOT_2_PI = 0.9189385332046727, 2.5066282746310002

# Tables of Taylor series around t = i / steps. Central: Phi(t) - 1/2. Tail: log Phi(-t).
CENTRAL_STEPS, CENTRAL_END, CENTRAL_TERMS = 32, 8.5, 9
TAIL_STEPS, TAIL_END, TAIL_TERMS = 16, 40.0, 10


@compiled
def _central_table() -> NDArray[np.float64]:
    nodes = int(CENTRAL_END * CENTRAL_STEPS) + 1
    table = np.empty((nodes, CENTRAL_TERMS))
    value, step = 0.0, 1.0 / CENTRAL_STEPS
    series = np.empty(24)
    for i in range(nodes):
        t = i * step
        # phi' = -t phi, so with s the way from t: (j + 1) c[j+1] = -(t c[j] + c[j-1]) for phi(t + s) = sum c[j] s^j.
        series[0] = exp(-0.5 * t * t - _LOG_ROOT_2_PI)
        series[1] = -t * series[0]
        for j in range(1, series.size - 1):
            series[j + 1] = -(t * series[j] + series[j - 1]) / (j + 1)
        table[i, 0] = value
        for j in range(1, CENTRAL_TERMS):
            table[i, j] = series[j - 1] / j
        increment = 0.0
        for j in range(series.size - 1, -1, -1):
            increment = (increment + series[j] / (j + 1)) * step
        value += increment
    return table


@compiled
def _tail_table() -> NDArray[np.float64]:
    nodes = int(TAIL_END * TAIL_STEPS) + 1
    table = np.empty((nodes, TAIL_TERMS))
    step = 1.0 / TAIL_STEPS
    # m(t) = phi(t) / Phi(-t), at the far end by its continued fraction; m' = m (m - t) is stable going down.
    m = TAIL_END
    for j in range(60, 0, -1):
        m = TAIL_END + j / m
    series = np.empty(30)
    for i in range(nodes - 1, -1, -1):
        t = i * step
        series[0] = m
        for j in range(series.size - 1):
            total = -t * series[j] - (series[j - 1] if j else 0.0)
            for k in range(j + 1):
                total += series[k] * series[j - k]
            series[j + 1] = total / (j + 1)
        table[i, 0] = -0.5 * t * t - _LOG_ROOT_2_PI - log(m)
        for j in range(1, TAIL_TERMS):
            table[i, j] = -series[j - 1] / j
        m = 0.0
        for j in range(series.size - 1, -1, -1):
            m = series[j] - step * m
    return table


CENTRAL, TAIL = _central_table(), _tail_table()


@compiled
def half_mass(t: float, central: NDArray[np.float64]) -> float:
    """Return Phi(t) - 1/2, the probability of a standard normal number between 0 and t; ``central`` is CENTRAL."""
    u = abs(t)
    if u >= CENTRAL_END:
        return 0.5 if t > 0.0 else -0.5
    i = int(u * CENTRAL_STEPS + 0.5)
    s = u - i * (1.0 / CENTRAL_STEPS)
    p: float = central[i, CENTRAL_TERMS - 1]
    for j in range(CENTRAL_TERMS - 2, -1, -1):
        p = p * s + central[i, j]
    return p if t > 0.0 else -p


@compiled
def _far_series(t: float) -> float:
    """Return Phi(-t) t / phi(t) for t >= TAIL_END, by its asymptotic series."""
    w = 1.0 / (t * t)
    return 1.0 - w * (1.0 - 3.0 * w * (1.0 - 5.0 * w * (1.0 - 7.0 * w * (1.0 - 9.0 * w))))


@compiled
def log_tail(t: float, tail: NDArray[np.float64]) -> tuple[float, float]:
    """Return log Phi(-t) and its slope, for t >= 0; ``tail`` is TAIL."""
    if t >= TAIL_END:
        p = _far_series(t)
        return -0.5 * t * t - _LOG_ROOT_2_PI - log(t) + log(p), -t / p
    i = int(t * TAIL_STEPS + 0.5)
    s = t - i * (1.0 / TAIL_STEPS)
    p, slope = tail[i, TAIL_TERMS - 1], 0.0
    for j in range(TAIL_TERMS - 2, -1, -1):
        slope = slope * s + p
        p = p * s + tail[i, j]
    return p, slope


@compiled
def tail_at(log_p: float, tail: NDArray[np.float64]) -> float:
    """Return t with log Phi(-t) = ``log_p``, for log_p <= log(1/2)."""
    last = tail.shape[0] - 1
    if log_p <= tail[last, 0]:
        t = math.sqrt(-2.0 * (log_p + _LOG_ROOT_2_PI))
    else:
        low, high = 0, last
        while high - low > 1:
            middle = (low + high) // 2
            if tail[middle, 0] >= log_p:
                low = middle
            else:
                high = middle
        t = low * (1.0 / TAIL_STEPS)
    # Concave and falling: from either side Newton's steps come down upon the root.
    for _ in range(8):
        value, slope = log_tail(t, tail)
        t = max(0.0, t - (value - log_p) / slope)
    return t


@compiled
def log_mass(a: float, b: float, central: NDArray[np.float64], tail: NDArray[np.float64]) -> float:
    """Return the logarithm of the probability of a standard normal number between a and b > a."""
    if a <= 0.0 <= b:
        return log(half_mass(b, central) - half_mass(a, central))
    near, far = (a, b) if a > 0.0 else (-b, -a)
    high = log_tail(near, tail)[0]
    if (far - near) * (far + near) > 80.0:  # what lies beyond is less than e^-40 of it
        return high
    return high + log(1.0 - exp(log_tail(far, tail)[0] - high))


@compiled
def far_mass(a: float, b: float) -> tuple[float, float]:
    """Return (m, e): what :func:`log_mass` takes the logarithm of is m e^e; both bounds beyond TAIL_END on one side."""
    near, far = (a, b) if a > 0.0 else (-b, -a)
    return (_far_series(near) / near - _beyond(near, far)) / _ROOT_2_PI, -0.5 * near * near


@compiled
def _beyond(near: float, far: float) -> float:
    """Return Phi(-far) as a multiple of the density at ``near``."""
    gap = 0.5 * (far - near) * (far + near)
    return exp(-gap) * _far_series(far) / far if gap < 40.0 else 0.0


@compiled
def between(q: float, a: float, b: float, central: NDArray[np.float64], tail: NDArray[np.float64]) -> float:
    """Return the number below which the share ``q`` of a standard normal distribution cut off at a and b lies."""
    if q <= 0.0 or q >= 1.0:
        return a if q <= 0.0 else b
    if a > 0.0:
        return -_between_left(1.0 - q, -b, -a, central, tail)
    return _between_left(q, a, b, central, tail)


@compiled
def _between_left(q: float, a: float, b: float, central: NDArray[np.float64], tail: NDArray[np.float64]) -> float:
    """Return what :func:`between` does for a <= 0."""
    if b < 0.0:
        # Both in the lower tail: p = Phi(a) + q (Phi(b) - Phi(a)), relative to Phi(b).
        high, low = log_tail(-b, tail)[0], log_tail(-a, tail)[0]
        ratio = exp(low - high)
        return min(max(-tail_at(high + log(max(ratio + q * (1.0 - ratio), 1e-300)), tail), a), b)
    at_a, at_b = half_mass(a, central), half_mass(b, central)
    p = at_a + q * (at_b - at_a)  # from the middle
    if p < 0.0:
        rest = _lower_tail(a, at_a, tail) + q * (at_b - at_a)
        x = -tail_at(log(max(rest, 1e-300)), tail)
    else:
        rest = _lower_tail(-b, -at_b, tail) + (1.0 - q) * (at_b - at_a)
        x = tail_at(min(log(max(rest, 1e-300)), -0.6931471805599453), tail)
    return min(max(x, a), b)


@compiled
def _lower_tail(a: float, at_a: float, tail: NDArray[np.float64]) -> float:
    """Return Phi(a) for a <= 0, where ``at_a`` = Phi(a) - 1/2 is known: exact in the far tail too."""
    return 0.5 + at_a if a > -3.0 else exp(log_tail(-a, tail)[0])
