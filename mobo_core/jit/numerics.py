"""The arithmetic that must give the same bits on every x86-64 machine: random numbers, sine and cosine.

Everything here uses + - * /, square root and integers alone, all of which IEEE 754 fixes to the bit.
Calls into a mathematics library would not be fixed, and neither would fused multiply-adds: Numba is
used without fastmath throughout, so that it neither reorders nor contracts.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mobo_core.jit.cache import Cache

compiled = Cache("numerics", [__file__]).compiled

# Independent streams of random numbers; the first word of the counter that is hashed.
STREAM_ORIENTATION = 1
STREAM_START = 2
STREAM_AUDIT = 3
STREAM_TABLE = 4

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_MIX_1 = np.uint64(0xBF58476D1CE4E5B9)
_MIX_2 = np.uint64(0x94D049BB133111EB)
_S27, _S30, _S31, _S11 = np.uint64(27), np.uint64(30), np.uint64(31), np.uint64(11)
_TO_UNIT = 1.0 / 9007199254740992.0  # 2**-53


@compiled
def mix(state: np.uint64, word: int | np.uint64) -> np.uint64:
    """Fold one 64-bit word into a 64-bit state (the finaliser of SplitMix64, Steele et al. 2014)."""
    z = (np.uint64(state) ^ np.uint64(word)) + _GOLDEN
    z = (z ^ (z >> _S30)) * _MIX_1
    z = (z ^ (z >> _S27)) * _MIX_2
    return z ^ (z >> _S31)


@compiled
def stream(seed: int, kind: int, a: int, b: int, c: int) -> np.uint64:
    """Return the state that starts the stream of random numbers for (seed, kind, a, b, c)."""
    return mix(mix(mix(mix(mix(np.uint64(0), seed), kind), a), b), c)


@compiled
def uniform(state: np.uint64, k: int) -> float:
    """Return number k of a stream, uniform in [0, 1) with 53 bits."""
    return (mix(state, k) >> _S11) * _TO_UNIT


@compiled
def pick(seed: int, kind: int, a: int, k: int, count: int) -> int:
    """Return choice number ``k`` of the stream (seed, kind, a), one of 0 to ``count`` - 1."""
    return int(uniform(stream(seed, kind, a, count, 0), k) * count)


# pi/2 in three parts: products of the first two with a small whole number are exact.
HALF_PI_PARTS = (1.5707963267341256, 6.077100506303966e-11, 2.0222662487959506e-21)
TWO_OVER_PI = 0.6366197723675814

# Taylor coefficients, highest power first: sin r = r + r^3 P(r^2), cos r = 1 + r^2 U(r^2).
SIN_TERMS = tuple((-1.0) ** k / math.factorial(2 * k + 1) for k in range(7, 0, -1))
COS_TERMS = tuple((-1.0) ** k / math.factorial(2 * k) for k in range(8, 0, -1))


@compiled
def sin_cos(x: float) -> tuple[float, float]:
    """Return sine and cosine of ``x`` (rad, |x| < 1e5), each within 2e-16 or so.

    Quarter turns are taken off, the rest is a Taylor series in [-pi/4, pi/4], whose first term left out
    is below 5e-17.
    """
    k = math.floor(x * TWO_OVER_PI + 0.5)
    r = ((x - k * HALF_PI_PARTS[0]) - k * HALF_PI_PARTS[1]) - k * HALF_PI_PARTS[2]
    t = r * r
    p = SIN_TERMS[0]
    for i in range(1, len(SIN_TERMS)):
        p = p * t + SIN_TERMS[i]
    s = r + r * t * p
    p = COS_TERMS[0]
    for i in range(1, len(COS_TERMS)):
        p = p * t + COS_TERMS[i]
    c = 1.0 + t * p
    quarter = int(k) & 3
    if quarter == 0:
        return s, c
    if quarter == 1:
        return c, -s
    if quarter == 2:
        return -s, -c
    return -c, s


@compiled
def target_rotation(seed: int, voxel: int, pose: int, rotation: NDArray[np.float64]) -> None:
    """Write the target orientation of (seed, voxel, pose) into ``rotation``, shape (3, 3), base frame.

    Uniform on SO(3): a point drawn uniformly in the ball of dimension 4 by rejection, projected onto the
    sphere, read as a unit quaternion.
    """
    state = stream(seed, STREAM_ORIENTATION, voxel, pose, 0)
    k = 0
    while True:
        w = 2.0 * uniform(state, k) - 1.0
        x = 2.0 * uniform(state, k + 1) - 1.0
        y = 2.0 * uniform(state, k + 2) - 1.0
        z = 2.0 * uniform(state, k + 3) - 1.0
        k += 4
        n = w * w + x * x + y * y + z * z
        if 1e-4 < n <= 1.0:
            break
    f = 1.0 / math.sqrt(n)
    w, x, y, z = w * f, x * f, y * f, z * f
    rotation[0, 0] = 1.0 - 2.0 * (y * y + z * z)
    rotation[0, 1] = 2.0 * (x * y - z * w)
    rotation[0, 2] = 2.0 * (x * z + y * w)
    rotation[1, 0] = 2.0 * (x * y + z * w)
    rotation[1, 1] = 1.0 - 2.0 * (x * x + z * z)
    rotation[1, 2] = 2.0 * (y * z - x * w)
    rotation[2, 0] = 2.0 * (x * z - y * w)
    rotation[2, 1] = 2.0 * (y * z + x * w)
    rotation[2, 2] = 1.0 - 2.0 * (x * x + y * y)


@compiled
def random_start(
    seed: int, voxel: int, pose: int, attempt: int,
    lower: NDArray[np.float64], upper: NDArray[np.float64], q: NDArray[np.float64],
) -> None:  # fmt: skip
    """Write the start of an IK attempt into ``q`` (rad), uniform between the joint limits."""
    state = stream(seed, STREAM_START, voxel, pose, attempt)
    for i in range(q.shape[0]):
        q[i] = lower[i] + uniform(state, i) * (upper[i] - lower[i])
