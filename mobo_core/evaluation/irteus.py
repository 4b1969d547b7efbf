"""Inverse kinematics as in EusLisp's irteus, which the paper's authors most likely used; for the reference engine.

Weighted least norm (Chan and Dubey, IEEE T-RA 1995): a joint that comes nearer to a limit moves less. Singularity
robust inverse (Nakamura and Hanafusa, ASME JDSMC 1986) where manipulability is below ``LIMIT``. The first start is the
zero posture. Left out: motion in the null space, which irteus uses to keep joints in the middle of their ranges.
"""

from __future__ import annotations

import math

import numpy as np

from mobo_core.evaluation.chain import Array, Chain
from mobo_core.evaluation.reference import Advance
from mobo_core.jit.numerics import random_start

# Of manipulability, below which the inverse is damped, by up to GAIN.
LIMIT, GAIN = 0.1, 1e-3
# m and rad of the tool, in one step.
MOST_WAY, MOST_TURN = 0.1, 0.5
_NEAREST = 1e-6  # rad, to a limit: at it the weight is not finite


def start(chain: Chain, seed: int, voxel: int, pose: int, attempt: int, q: Array) -> None:
    """Write an attempt's first configuration to ``q``: all joints at zero, or nearest to it; after that at random."""
    if attempt == 0:
        q[:] = np.clip(0.0, chain.lower, chain.upper)
    else:
        random_start(seed, voxel, pose, attempt, chain.lower, chain.upper, q)


def advance(chain: Chain) -> Advance:
    """Return what takes an attempt from a configuration to the next."""
    nearness = np.zeros(chain.n)

    def advance(q: Array, jac: Array, error: Array, squared: float) -> Array:
        nonlocal nearness
        before, nearness = nearness, _nearness(q, chain.lower, chain.upper)
        weight = np.where(nearness > before, 1.0 / (1.0 + nearness), 1.0)
        return np.clip(q + step(jac, weight, _limited(error)), chain.lower, chain.upper)

    return advance


def step(jac: Array, weight: Array, error: Array) -> Array:
    """Return the joints' step in rad towards ``error`` (6,), for a Jacobian (6, n) and weights of the joints (n,)."""
    square = jac @ jac.T
    manipulability = math.sqrt(max(0.0, float(np.linalg.det(square))))
    damping = GAIN * (1.0 - manipulability / LIMIT) ** 2 if manipulability < LIMIT else 0.0
    weighted = weight[:, None] * jac.T
    found: Array = weighted @ np.linalg.lstsq(jac @ weighted + damping * np.eye(6), error, rcond=None)[0]
    return found


def _nearness(q: Array, lower: Array, upper: Array) -> Array:
    """Return how steeply Chan and Dubey's measure of the distance from the limits changes with each joint."""
    above, below = np.maximum(upper - q, _NEAREST), np.maximum(q - lower, _NEAREST)
    found: Array = np.abs((upper - lower) ** 2 * (2.0 * q - upper - lower) / (4.0 * above**2 * below**2))
    return found


def _limited(error: Array) -> Array:
    way, turn = float(np.linalg.norm(error[:3])), float(np.linalg.norm(error[3:]))
    return np.concatenate([error[:3] * min(1.0, MOST_WAY / way if way > 0 else 1.0),
                           error[3:] * min(1.0, MOST_TURN / turn if turn > 0 else 1.0)])  # fmt: skip
