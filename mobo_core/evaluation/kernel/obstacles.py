"""Whether an arm touches the floor, or boxes that stand around it. Compiled.

A box is a row of 15 numbers: its centre (m), its rotation row by row, and half of its sides (m), base frame.
``against`` (capsules, 1 + boxes) says which capsules count against the floor, in its first column, and each box.
All distances are exact, to rounding.
"""

from __future__ import annotations

import numpy as np

from mobo_core.evaluation.kernel import compiled
from mobo_core.evaluation.kernel.configuration import forward
from mobo_core.evaluation.kernel.geometry import place_capsules


@compiled
def box_distance_squared(a, b, box):
    """Return the squared distance (m^2) of the segment from ``a`` to ``b`` (each (3,) m) from a box, 0 inside it.

    Along the segment the squared distance is convex. Its slope grows with the way t along it, linear between the
    places where the segment crosses the planes of the box's sides: two of them hold the zero between them.
    """
    p0 = p1 = p2 = d0 = d1 = d2 = 0.0
    for i in range(3):
        start, along = a[i] - box[i], b[i] - a[i]
        p0 += box[3 + 3 * i] * start
        p1 += box[4 + 3 * i] * start
        p2 += box[5 + 3 * i] * start
        d0 += box[3 + 3 * i] * along
        d1 += box[4 + 3 * i] * along
        d2 += box[5 + 3 * i] * along
    h0, h1, h2 = box[12], box[13], box[14]
    low, high = 0.0, 1.0
    slope_low = _slope(0.0, p0, p1, p2, d0, d1, d2, h0, h1, h2)
    slope_high = _slope(1.0, p0, p1, p2, d0, d1, d2, h0, h1, h2)
    if slope_low >= 0.0:
        high = 0.0
    elif slope_high <= 0.0:
        low = 1.0
    else:
        for side in range(6):
            p, d, h = (p0, d0, h0) if side < 2 else (p1, d1, h1) if side < 4 else (p2, d2, h2)
            if d == 0.0:
                continue
            t = ((h if side % 2 == 0 else -h) - p) / d
            if low < t < high:
                slope = _slope(t, p0, p1, p2, d0, d1, d2, h0, h1, h2)
                if slope <= 0.0:
                    low, slope_low = t, slope
                else:
                    high, slope_high = t, slope
    t = low
    if low < high:
        t = min(max(low - slope_low * (high - low) / (slope_high - slope_low), low), high)
    x, y, z = _beyond(p0 + t * d0, h0), _beyond(p1 + t * d1, h1), _beyond(p2 + t * d2, h2)
    return x * x + y * y + z * z


@compiled
def _beyond(x, half):
    """Return how far ``x`` is beyond -half to half, with its sign."""
    return x - half if x > half else x + half if x < -half else 0.0


@compiled
def _slope(t, p0, p1, p2, d0, d1, d2, h0, h1, h2):
    """Return half of the slope of the squared distance at ``t``."""
    return (
        d0 * _beyond(p0 + t * d0, h0) + d1 * _beyond(p1 + t * d1, h1) + d2 * _beyond(p2 + t * d2, h2)
    )  # fmt: skip


@compiled
def touches_floor(ends, radius, floor_z):
    """Return whether a capsule around the segment ``ends`` (2, 3) touches or crosses the floor at ``floor_z`` m."""
    return min(ends[0, 2], ends[1, 2]) - radius <= floor_z


@compiled
def touches_box(ends, radius, box):
    """Return whether a capsule around the segment ``ends`` (2, 3) touches or overlaps a box."""
    return box_distance_squared(ends[0], ends[1], box) <= radius * radius


@compiled
def touches_anything(capsule_joint, capsule_a, capsule_b, radius, obstacles, origins, rotations, ends):
    """Return whether any capsule touches what it counts against; ``ends`` is work space."""
    against, floor_z, boxes = obstacles.against, obstacles.floor_z, obstacles.boxes
    if against.shape[0] == 0:
        return False
    place_capsules(capsule_joint, capsule_a, capsule_b, origins, rotations, ends)
    for c in range(against.shape[0]):
        if against[c, 0] and touches_floor(ends[c], radius[c], floor_z):
            return True
        for k in range(boxes.shape[0]):
            if against[c, k + 1] and touches_box(ends[c], radius[c], boxes[k]):
                return True
    return False


@compiled
def count_touches(arm, obstacles, q, counts):
    """Write how many of the configurations ``q`` (m, n) have each capsule touch each thing, into ``counts``.

    ``counts`` has the shape of ``obstacles.against``.
    """
    n = q.shape[1]
    axes, origins, rotations, tip = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3, 3)), np.empty((4, 3))
    ends = np.empty((arm.capsule_joint.shape[0], 2, 3))
    counts[:] = 0
    for i in range(q.shape[0]):
        forward(
            arm.placement_r, arm.placement_p, arm.tip_r, arm.tip_p, arm.slide, q[i], axes, origins, rotations, tip
        )  # fmt: skip
        place_capsules(arm.capsule_joint, arm.capsule_a, arm.capsule_b, origins, rotations, ends)
        for c in range(counts.shape[0]):
            counts[c, 0] += touches_floor(ends[c], arm.capsule_radius[c], obstacles.floor_z)
            for k in range(obstacles.boxes.shape[0]):
                counts[c, k + 1] += touches_box(ends[c], arm.capsule_radius[c], obstacles.boxes[k])
