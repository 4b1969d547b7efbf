"""What objectives measure at accepted configurations, many at a time. Compiled.

They have a cache of their own: an edit here compiles no kernel anew.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mobo_core.evaluation.kernel import configuration
from mobo_core.evaluation.kernel.configuration import forward, gravity_torque
from mobo_core.jit import numerics
from mobo_core.jit.cache import Cache

CACHE = Cache("measures", [__file__, configuration.__file__, numerics.__file__], nogil=True)
compiled = CACHE.compiled

Array = NDArray[np.float64]


@compiled
def joint_torques(
    placement_r: Array, placement_p: Array, tip_r: Array, tip_p: Array, slide: Array, mass: Array, com: Array,
    gravity: Array, q: Array, out: Array,
) -> None:  # fmt: skip
    """Write the torque in N m that holds each joint at each of ``q`` (m, n) into ``out`` (m, n).

    Of a joint that slides it is force times ``slide`` (n,), m, above 0 for such joints alone.
    """
    n = q.shape[1]
    axes, origins, rotations, tip = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3, 3)), np.empty((4, 3))
    for i in range(q.shape[0]):
        forward(placement_r, placement_p, tip_r, tip_p, slide, q[i], axes, origins, rotations, tip)
        gravity_torque(mass, com, slide, gravity, axes, origins, rotations, out[i])


@compiled
def manipulabilities(
    placement_r: Array, placement_p: Array, tip_r: Array, tip_p: Array, slide: Array, q: Array, out: Array
) -> None:
    """Write sqrt(det(J J^T)) at each of ``q`` (m, n) into ``out`` (m,); 0 for fewer than 6 joints.

    J (6, n) is the tip's Jacobian, m and rad, base frame; the measure is the same in any frame and for any
    point of the last link (Yoshikawa, IJRR 4(2), 1985). The root of the determinant is the product of the
    diagonal of Cholesky's factor.
    """
    n = q.shape[1]
    axes, origins, rotations, tip = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3, 3)), np.empty((4, 3))
    jac, m = np.empty((6, n)), np.empty((6, 6))
    for i in range(q.shape[0]):
        out[i] = 0.0
        if n < 6:
            continue
        forward(placement_r, placement_p, tip_r, tip_p, slide, q[i], axes, origins, rotations, tip)
        for j in range(n):
            for k in range(3):
                if slide[j] > 0.0:
                    jac[k, j], jac[k + 3, j] = axes[j, k], 0.0
                    continue
                u, v = (k + 1) % 3, (k + 2) % 3
                jac[k, j] = axes[j, u] * (tip[3, v] - origins[j, v]) - axes[j, v] * (tip[3, u] - origins[j, u])
                jac[k + 3, j] = axes[j, k]
        measure = 1.0
        for a in range(6):
            for b in range(a + 1):
                total = 0.0
                for j in range(n):
                    total += jac[a, j] * jac[b, j]
                for k in range(b):
                    total -= m[a, k] * m[b, k]
                if b < a:
                    m[a, b] = total / m[b, b]
                elif total > 0.0:
                    m[a, a] = math.sqrt(total)
                else:  # singular, to rounding
                    m[a, a] = 0.0
            measure *= m[a, a]
            if measure == 0.0:
                break
        out[i] = measure
