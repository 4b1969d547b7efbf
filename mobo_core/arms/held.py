"""Joints that are held, and where the links that hang on them stand."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mobo_core.arms.rigid import Placement, rotation, rotation_rpy
from mobo_core.arms.robot import Joint, Robot
from mobo_core.errors import InputError


def held_at(robot: Robot, way: list[Joint], given: Mapping[str, float]) -> dict[str, float]:
    """Return where each joint that does not move is held, rad or m.

    Args:
        robot: the whole.
        way: its joints on the way to the tip.
        given: those that are set, and where.

    Raises:
        InputError: no such joint, or beyond its limits.
    """
    joints = {joint.name: joint for joint in robot.joints.values() if joint.moves}
    for name, value in given.items():
        if name not in joints:
            known = ", ".join(list(joints)[:8]) or "a robot with joints that move"
            raise InputError(f"no joint {name!r} that moves", where="--set", expected=known)
        joint = joints[name]
        if joint.lower < joint.upper and not joint.lower - 1e-9 <= value <= joint.upper + 1e-9:
            expected = f"{joint.lower:g} to {joint.upper:g}, its limits"
            raise InputError(f"{value:g}", where=f"--set {name}", expected=expected)
    on_way = {joint.name for joint in way}
    at: dict[str, float] = {}

    def place(name: str, seen: tuple[str, ...] = ()) -> float:
        joint = joints[name]
        if name in given:
            return given[name]
        if not joint.leader or joint.leader in on_way or joint.leader not in joints or name in seen:
            return min(max(0.0, joint.lower), joint.upper)
        return joint.multiplier * place(joint.leader, (*seen, name)) + joint.offset

    for name in joints:
        if name in given or name not in on_way:
            at[name] = place(name)
    return at


def placed_at(joint: Joint, at: Mapping[str, float]) -> Placement:
    """Return where the child of a joint that is held stands in the parent."""
    value = at.get(joint.name, 0.0)
    if value == 0.0:
        return joint.placed
    if joint.kind == "prismatic":
        return joint.placed.then(Placement(tuple(value * a for a in joint.axis)))
    length = sum(a * a for a in joint.axis) ** 0.5
    return joint.placed.then(Placement(rpy=rotation_rpy(rotation(np.array(joint.axis) / length, value))))


def homes_of(robot: Robot, way: list[str], at: Mapping[str, float]) -> dict[str, tuple[str, Placement]]:
    """Return for each link the link of the way that it is part of, and where it stands in that."""
    homes = {link: (link, Placement()) for link in way}
    for link in robot.links:
        above = []
        while link not in homes:
            above.append(robot.joints[link])
            link = above[-1].parent
        for joint in reversed(above):
            home, placed = homes[joint.parent]
            homes[joint.child] = home, placed.then(placed_at(joint, at))
    return homes
