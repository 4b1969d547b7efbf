"""Distances between capsules, compiled."""

from __future__ import annotations

import math

from mobo_core.evaluation.kernel import compiled


@compiled
def segment_distance_squared(a0, a1, b0, b1):
    """Return the squared distance of the segments a0-a1 and b0-b1 (each end of shape (3,), m).

    The closest points of the two lines are clamped to the segments one after the other, as in Ericson,
    Real-Time Collision Detection, section 5.1.9; segments of no length are points.
    """
    ux, uy, uz = a1[0] - a0[0], a1[1] - a0[1], a1[2] - a0[2]
    vx, vy, vz = b1[0] - b0[0], b1[1] - b0[1], b1[2] - b0[2]
    wx, wy, wz = a0[0] - b0[0], a0[1] - b0[1], a0[2] - b0[2]
    uu = ux * ux + uy * uy + uz * uz
    vv = vx * vx + vy * vy + vz * vz
    uv = ux * vx + uy * vy + uz * vz
    uw = ux * wx + uy * wy + uz * wz
    vw = vx * wx + vy * wy + vz * wz
    tiny = 1e-24
    if uu <= tiny and vv <= tiny:
        s = t = 0.0
    elif uu <= tiny:
        s = 0.0
        t = min(max(vw / vv, 0.0), 1.0)
    elif vv <= tiny:
        t = 0.0
        s = min(max(-uw / uu, 0.0), 1.0)
    else:
        det = uu * vv - uv * uv
        s = uv * vw - uw * vv
        # Lines next to parallel are closest far away, in the direction of this sign; parallel ones all along.
        if det > 1e-14 * uu * vv:
            s /= det
        elif s > 0.0:
            s = 1.0
        s = min(max(s, 0.0), 1.0)
        t = (uv * s + vw) / vv
        if t < 0.0:
            t = 0.0
            s = min(max(-uw / uu, 0.0), 1.0)
        elif t > 1.0:
            t = 1.0
            s = min(max((uv - uw) / uu, 0.0), 1.0)
    x = wx + s * ux - t * vx
    y = wy + s * uy - t * vy
    z = wz + s * uz - t * vz
    return x * x + y * y + z * z


@compiled
def place_capsules(capsule_joint, capsule_a, capsule_b, origins, rotations, ends):
    """Write the ends of the capsules' segments in the base frame, shape (capsules, 2, 3).

    ``capsule_joint`` holds the joint that carries each capsule, -1 for the base.
    """
    for c in range(capsule_joint.shape[0]):
        j = capsule_joint[c]
        for e in range(2):
            p = capsule_a[c] if e == 0 else capsule_b[c]
            for k in range(3):
                if j < 0:
                    ends[c, e, k] = p[k]
                else:
                    r = rotations[j]
                    ends[c, e, k] = origins[j, k] + r[k, 0] * p[0] + r[k, 1] * p[1] + r[k, 2] * p[2]


@compiled
def any_pair_collides(capsule_joint, capsule_a, capsule_b, capsule_radius, pairs, origins, rotations, ends):
    """Return whether any of the pairs (k, 2) of capsules touches or overlaps; ``ends`` is work space."""
    place_capsules(capsule_joint, capsule_a, capsule_b, origins, rotations, ends)
    for k in range(pairs.shape[0]):
        i, j = pairs[k, 0], pairs[k, 1]
        reach = capsule_radius[i] + capsule_radius[j]
        if segment_distance_squared(ends[i, 0], ends[i, 1], ends[j, 0], ends[j, 1]) <= reach * reach:
            return True
    return False


@compiled
def any_near_pair_collides(
    capsule_joint, capsule_a, capsule_b, radius, pairs, origins, rotations, ends
):  # fmt: skip
    """Return what :func:`any_pair_collides` does, leaving out pairs whose middles are too far apart to touch."""
    place_capsules(capsule_joint, capsule_a, capsule_b, origins, rotations, ends)
    for k in range(pairs.shape[0]):
        i, j = pairs[k, 0], pairs[k, 1]
        apart = half_i = half_j = 0.0
        for axis in range(3):
            a0, a1, b0, b1 = ends[i, 0, axis], ends[i, 1, axis], ends[j, 0, axis], ends[j, 1, axis]
            apart += (a0 + a1 - b0 - b1) * (a0 + a1 - b0 - b1)
            half_i += (a1 - a0) * (a1 - a0)
            half_j += (b1 - b0) * (b1 - b0)
        reach = radius[i] + radius[j]
        # All doubled; a little more than rounding could make of it.
        most = math.sqrt(half_i) + math.sqrt(half_j) + 2.0 * reach + 1e-9
        if apart > most * most:
            continue
        if segment_distance_squared(ends[i, 0], ends[i, 1], ends[j, 0], ends[j, 1]) <= reach * reach:
            return True
    return False
