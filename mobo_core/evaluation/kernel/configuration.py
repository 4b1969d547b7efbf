"""What the compiled kernel is made of besides its lanes: its constants, and one configuration at a time.

The algorithm, shared step by step with :mod:`mobo_core.evaluation.reference`: damped least squares on the six
errors of the tool (position in m, orientation as twice the sine of half the angle, along its axis), with joints
at their limits frozen while the gradient pushes them further. An attempt ends with a configuration within both
tolerances, which counts unless it is in self-collision.

All functions take flat arrays (see :class:`mobo_core.evaluation.chain.Chain`), release the GIL, and give the
same bits on every x86-64 machine: no fastmath, no calls into a mathematics library.
"""

from __future__ import annotations

import math

from mobo_core.evaluation.kernel import compiled
from mobo_core.jit.numerics import sin_cos

# Outcome of a pose.
REACHED = 0
OUT_OF_RANGE = 1
NOT_CONVERGED = 2
IN_COLLISION = 3

# Damping grows with the squared error (Sugihara, IEEE T-RO 2011) from a floor that keeps the matrix regular.
DAMPING_FLOOR = 1e-5
DAMPING_GAIN = 0.02
# Largest step of a joint in one iteration, rad or m.
MAX_STEP = 1.0
# 1 + trace of the rotation between tool and target below which they are half a turn apart.
HALF_TURN = 1e-8


@compiled
def forward(placement_r, placement_p, tip_r, tip_p, slide, q, axes, origins, rotations, tip):
    """Write joint axes (n, 3), joint origins (n, 3) and joint rotations (n, 3, 3) at ``q``, base frame.

    ``slide`` (n,) is above 0 for joints that slide along their axis, by ``q`` m, and take their origin along.
    ``tip``, shape (4, 3), receives the rotation of the tip in rows 0-2 and its position in row 3.
    """
    n = q.shape[0]
    a00, a01, a02 = 1.0, 0.0, 0.0
    a10, a11, a12 = 0.0, 1.0, 0.0
    a20, a21, a22 = 0.0, 0.0, 1.0
    x = y = z = 0.0
    for i in range(n + 1):
        if i < n:
            b, t = placement_r[i], placement_p[i]
        else:
            b, t = tip_r, tip_p
        x += a00 * t[0] + a01 * t[1] + a02 * t[2]
        y += a10 * t[0] + a11 * t[1] + a12 * t[2]
        z += a20 * t[0] + a21 * t[1] + a22 * t[2]
        c00 = a00 * b[0, 0] + a01 * b[1, 0] + a02 * b[2, 0]
        c01 = a00 * b[0, 1] + a01 * b[1, 1] + a02 * b[2, 1]
        c02 = a00 * b[0, 2] + a01 * b[1, 2] + a02 * b[2, 2]
        c10 = a10 * b[0, 0] + a11 * b[1, 0] + a12 * b[2, 0]
        c11 = a10 * b[0, 1] + a11 * b[1, 1] + a12 * b[2, 1]
        c12 = a10 * b[0, 2] + a11 * b[1, 2] + a12 * b[2, 2]
        c20 = a20 * b[0, 0] + a21 * b[1, 0] + a22 * b[2, 0]
        c21 = a20 * b[0, 1] + a21 * b[1, 1] + a22 * b[2, 1]
        c22 = a20 * b[0, 2] + a21 * b[1, 2] + a22 * b[2, 2]
        if i == n:
            tip[0, 0], tip[0, 1], tip[0, 2] = c00, c01, c02
            tip[1, 0], tip[1, 1], tip[1, 2] = c10, c11, c12
            tip[2, 0], tip[2, 1], tip[2, 2] = c20, c21, c22
            tip[3, 0], tip[3, 1], tip[3, 2] = x, y, z
            return
        if slide[i] > 0.0:
            s, c = 0.0, 1.0
            x, y, z = x + c02 * q[i], y + c12 * q[i], z + c22 * q[i]
        else:
            s, c = sin_cos(q[i])
        a00, a01, a02 = c00 * c + c01 * s, c01 * c - c00 * s, c02
        a10, a11, a12 = c10 * c + c11 * s, c11 * c - c10 * s, c12
        a20, a21, a22 = c20 * c + c21 * s, c21 * c - c20 * s, c22
        axes[i, 0], axes[i, 1], axes[i, 2] = a02, a12, a22
        origins[i, 0], origins[i, 1], origins[i, 2] = x, y, z
        r = rotations[i]
        r[0, 0], r[0, 1], r[0, 2] = a00, a01, a02
        r[1, 0], r[1, 1], r[1, 2] = a10, a11, a12
        r[2, 0], r[2, 1], r[2, 2] = a20, a21, a22


@compiled
def gravity_torque(mass, com, slide, gravity, axes, origins, rotations, torque):
    """Write the torque in N m that holds each joint against gravity; return its L2 norm.

    ``mass`` (n,) in kg and ``com`` (n, 3) in m, joint frame, belong to the bodies that joint i moves. The force of a
    joint that slides counts times ``slide`` (n,), m: the torque of a pinion of that radius, which drives it.
    """
    weight = wx = wy = wz = 0.0
    total = 0.0
    for i in range(mass.shape[0] - 1, -1, -1):
        r, c = rotations[i], com[i]
        weight += mass[i]
        wx += mass[i] * (origins[i, 0] + r[0, 0] * c[0] + r[0, 1] * c[1] + r[0, 2] * c[2])
        wy += mass[i] * (origins[i, 1] + r[1, 0] * c[0] + r[1, 1] * c[1] + r[1, 2] * c[2])
        wz += mass[i] * (origins[i, 2] + r[2, 0] * c[0] + r[2, 1] * c[1] + r[2, 2] * c[2])
        dx = wx - weight * origins[i, 0]
        dy = wy - weight * origins[i, 1]
        dz = wz - weight * origins[i, 2]
        t = -(
            axes[i, 0] * (dy * gravity[2] - dz * gravity[1])
            + axes[i, 1] * (dz * gravity[0] - dx * gravity[2])
            + axes[i, 2] * (dx * gravity[1] - dy * gravity[0])
        )
        if slide[i] > 0.0:
            along = axes[i, 0] * gravity[0] + axes[i, 1] * gravity[1] + axes[i, 2] * gravity[2]
            t = -(weight * along) * slide[i]
        torque[i] = t
        total += t * t
    return math.sqrt(total)
