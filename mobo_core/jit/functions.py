"""Exponential, logarithm and power that give the same bits on every x86-64 machine.

As in :mod:`mobo_core.jit.numerics`, everything is made of + - * /, square root and integers: what a
mathematics library returns in the last digit depends on its version and on the processor.
"""

from __future__ import annotations

import math

import numpy as np

from mobo_core.jit.cache import Cache

compiled = Cache("functions", [__file__]).compiled

LOG2_E = 1.4426950408889634
# log 2 in two parts: products of the first with a small whole number are exact.
_LOG_2_HIGH, _LOG_2_LOW = 0.6931471803691238, 1.9082149292705877e-10
_SQRT_HALF = 0.7071067811865476
_SHIFT, _BIAS = np.int64(52), np.int64(1023)
_MANTISSA, _ONE = np.int64((1 << 52) - 1), np.int64(1023 << 52)

# A number as large as this has no binary places left: adding it rounds to the nearest whole number.
_ROUND = 6755399441055744.0  # 1.5 * 2^52
# Taylor coefficients of exp: the first term left out is below 2e-16 for |r| <= log(2) / 2.
_EXP = tuple(1.0 / math.factorial(k) for k in range(13))
# And of 2^r, |r| <= 1/2: the first term left out is below 7e-15.
_EXP2 = tuple(0.6931471805599453**k / math.factorial(k) for k in range(12))
# log((1 + s) / (1 - s)) = 2 s (1 + s^2/3 + s^4/5 + ...), highest power first, |s| < 0.172.
_LOG_TERMS = tuple(1.0 / (2 * k + 1) for k in range(11, -1, -1))


@compiled
def exp(x: float) -> float:
    """Return e^x for x < 700, within 5e-16 of itself; what would be smaller than e^-700 counts as that."""
    x = max(x, -700.0)
    shifted = x * LOG2_E + _ROUND
    k = shifted - _ROUND
    r = (x - k * _LOG_2_HIGH) - k * _LOG_2_LOW
    # In pairs (Estrin's scheme), so that the processor need not wait for one product after the other.
    r2 = r * r
    r4 = r2 * r2
    p = ((_EXP[0] + _EXP[1] * r) + (_EXP[2] + _EXP[3] * r) * r2) + (
        (_EXP[4] + _EXP[5] * r) + (_EXP[6] + _EXP[7] * r) * r2
    ) * r4
    p += (((_EXP[8] + _EXP[9] * r) + (_EXP[10] + _EXP[11] * r) * r2) + _EXP[12] * r4) * (r4 * r4)
    # The last bits of `shifted` are k: as the exponent of a float they are 2^k.
    return p * np.int64((np.float64(shifted).view(np.int64) << _SHIFT) + _ONE).view(np.float64)


@compiled
def exp2(x: float) -> float:
    """Return 2^x for x < 1000, within 1e-14 of itself; what would be smaller than 2^-1000 counts as that.

    A third cheaper than :func:`exp`, for sums of many.
    """
    x = max(x, -1000.0)
    shifted = x + _ROUND
    r = x - (shifted - _ROUND)
    r2 = r * r
    r4 = r2 * r2
    p = ((_EXP2[0] + _EXP2[1] * r) + (_EXP2[2] + _EXP2[3] * r) * r2) + (
        (_EXP2[4] + _EXP2[5] * r) + (_EXP2[6] + _EXP2[7] * r) * r2
    ) * r4
    p += ((_EXP2[8] + _EXP2[9] * r) + (_EXP2[10] + _EXP2[11] * r) * r2) * (r4 * r4)
    return p * np.int64((np.float64(shifted).view(np.int64) << _SHIFT) + _ONE).view(np.float64)


@compiled
def log(x: float) -> float:
    """Return the natural logarithm of a normal number above 0, within 3e-16 or so."""
    bits = np.float64(x).view(np.int64)
    k = (bits >> _SHIFT) - _BIAS
    m = np.int64((bits & _MANTISSA) | _ONE).view(np.float64)
    if m > 2.0 * _SQRT_HALF:
        m *= 0.5
        k += 1
    s = (m - 1.0) / (m + 1.0)
    t = s * s
    p = _LOG_TERMS[0]
    for i in range(1, len(_LOG_TERMS)):
        p = p * t + _LOG_TERMS[i]
    return k * _LOG_2_HIGH + (k * _LOG_2_LOW + 2.0 * s * p)


@compiled
def power(x: float, y: float) -> float:
    """Return x^y for x > 0."""
    return exp(y * log(x))
