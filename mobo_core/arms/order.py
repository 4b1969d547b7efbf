"""The joint order of a real arm in our letters: straightened as far as its axes let it.

A search over postures in which each joint's axis, or the way to the next joint, points along x, y or z finds the one in
which the axes are nearest to right angles and the arm reaches highest. There an axis that is upright is a yaw; of
those that lie, the first, and each first one after a yaw, is a pitch (where a yaw is at zero, nothing says), one along
it a pitch too, one across it a roll. A wrist that can stand in two ways, as the UR arms' can, is named by the higher.
A joint that slides stands in the middle of its stroke, and is a slide whichever way it goes.
"""

from __future__ import annotations

import math

import numpy as np

from mobo_core.arms.real import Order, RealArm
from mobo_core.arms.rigid import Array, rotation
from mobo_core.design.joints import effective_joints

_WIDTH = 400  # postures kept from joint to joint
_SKEW = 1.0  # lengths of the arm that a radian off right angles costs


def order_of(arm: RealArm) -> Order:
    """Return the joint order of an arm; it takes a second or so."""
    q = _straightened(arm)
    axes, origins, _ = arm.frames(q)
    base = upright(arm)
    axes, origins = axes @ base.T, origins @ base.T
    letters, heading = "", None
    skews = []
    for joint, axis in zip(arm.joints, axes, strict=True):
        if joint.slides:
            letters += "S"
            skews.append(math.acos(min(1.0, abs(axis[2]))))
            continue
        if abs(axis[2]) > math.sqrt(0.5):
            letters, heading = letters + "Y", None
            skews.append(math.acos(min(1.0, abs(axis[2]))))
            continue
        flat = axis[:2] / math.hypot(axis[0], axis[1])
        heading = flat if heading is None else heading
        along = abs(float(flat @ heading))
        letters += "P" if along > math.sqrt(0.5) else "R"
        across = math.acos(min(1.0, max(along, math.sqrt(max(0.0, 1.0 - along * along)))))
        skews.append(max(math.asin(min(1.0, abs(axis[2]))), across))
    heights = np.diff(origins[:, 2])
    flat_way = np.linalg.norm(origins[:, :2] - origins[0, :2], axis=1)
    built, lengths = _buildable(letters, [float(max(0.0, height)) for height in heights])
    return Order(built, tuple(q.tolist()), max(skews), float(flat_way.max()), lengths)


def _buildable(letters: str, lengths: list[float]) -> tuple[str, tuple[float, ...]]:
    """Return the order as built, and its lengths. A slide right after a yaw is put before it: it does the same."""
    rows = list(zip(letters, lengths, strict=True))
    for i in range(1, len(rows)):
        before = effective_joints("".join(letter for letter, _ in rows[:i]))
        if rows[i][0] == "S" and before[-1] == "Y":
            rows[i - 1], rows[i] = rows[i], rows[i - 1]
    return effective_joints("".join(letter for letter, _ in rows)), tuple(length for _, length in rows)


def upright(arm: RealArm) -> Array:
    """Return the rotation of the base that makes the first axis upright or level, whichever is nearer."""
    axis = arm.joints[0].placed.matrix @ np.array(arm.joints[0].axis)
    upright = abs(axis[2]) > math.sqrt(0.5)
    goal = np.array([0.0, 0.0, math.copysign(1.0, axis[2])]) if upright else axis * (1.0, 1.0, 0.0)
    goal = goal / np.linalg.norm(goal)
    cross = np.cross(axis, goal)
    sine = float(np.linalg.norm(cross))
    if sine < 1e-12:
        return np.eye(3)
    return rotation(cross / sine, math.atan2(sine, float(axis @ goal)))


def _straightened(arm: RealArm) -> Array:
    base = upright(arm)
    skewed = _SKEW * arm.length
    # Postures so far: cost, q, rotation before the joint turns, height.
    first = arm.joints[0]
    states: list[tuple[float, tuple[float, ...], Array, float]] = [(0.0, (), base @ first.placed.matrix, 0.0)]
    for i, joint in enumerate(arm.joints):
        axis = np.array(joint.axis)
        after = arm.joints[i + 1] if i + 1 < arm.n else None
        way = joint.shift(joint.middle) + np.array(arm.ends[i])
        following = after.placed.matrix @ np.array(after.axis) if after else None
        grown = []
        for cost, q, turned, height in states:
            wanted = [v for v in (way, following) if v is not None]
            for angle in [joint.middle] if joint.slides else _angles(turned, axis, wanted):
                now = turned @ joint.rotation(angle)
                high = height + float((now @ way)[2])
                off = 0.0 if following is None else _off(now @ following)
                more = cost + skewed * off
                grown.append((more, (*q, angle), now @ after.placed.matrix if after else now, high))
        # The best of each way of standing: the same rotation again with less height or more skew is of no use.
        best: dict[bytes, tuple[float, tuple[float, ...], Array, float]] = {}
        for state in grown:
            key = np.round(state[2], 3).tobytes()
            if key not in best or state[0] - state[3] < best[key][0] - best[key][3] - 1e-9:
                best[key] = state
        states = sorted(best.values(), key=lambda state: state[0] - state[3])[:_WIDTH]
    return np.array(states[0][1])


def _off(axis: Array) -> float:
    return math.acos(min(1.0, float(np.abs(axis).max())))


def _angles(turned: Array, axis: Array, vectors: list[Array]) -> list[float]:
    """Return the angles about ``axis`` that bring one of ``vectors`` nearest to one of the six main directions."""
    world = turned @ axis
    found = {0.0: None}
    for vector in vectors:
        across = turned @ vector
        across = across - world * float(world @ across)
        if np.linalg.norm(across) < 1e-6:
            continue
        for goal in (*np.eye(3), *-np.eye(3)):
            flat = goal - world * float(world @ goal)
            if np.linalg.norm(flat) < 1e-6:
                continue
            angle = math.atan2(float(world @ np.cross(across, flat)), float(across @ flat))
            found[round(angle, 6)] = None
    return list(found)
