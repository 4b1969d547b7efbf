"""What the links of a real arm weigh where no source says, and the tubes that stand for their shapes."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from mobo_core.arms.arm_joint import ArmJoint, motor_place
from mobo_core.arms.rigid import Array, Triple
from mobo_core.design import DesignSpace
from mobo_core.design.numbers import of_joint
from mobo_core.evaluation.urdf_xml import text

Body = tuple[float, Triple]


def tubes_of(joint: ArmJoint, end: Triple) -> list[tuple[Array, Array]]:
    """Return the straight pieces of the link that a joint carries, each from (3,) to (3,) m in the joint's frame.

    One goes from the joint's origin to ``end``, where the next joint is. What slides is a tube in a guide at the
    joint's origin: it is long enough to be held at either limit, and from it another piece leads aside to ``end``.
    """
    at = np.array(end)
    if not joint.slides:
        return [(np.zeros(3), at)]
    axis = np.array(joint.axis)
    along = float(axis @ at)
    low, high = min(-joint.upper, along), max(-joint.lower, along)
    return [(low * axis, high * axis), (along * axis, at)]


def bodies_of(
    joints: Sequence[ArmJoint], ends: Sequence[Triple], space: DesignSpace, radius: float, grown: float
) -> list[Body]:
    """Return kg and centre (m) of what each joint carries, by the masses of a design space.

    Args:
        joints: of the arm.
        ends: m, where each joint's link ends, in its frame.
        space: whose motors they get, and whose density their links, as if solid.
        radius: m, of the links.
        grown: how much larger than the space's the motors are.
    """
    parts: list[list[tuple[float, Array]]] = [[] for _ in joints]
    for i, (joint, end) in enumerate(zip(joints, ends, strict=True)):
        which = i if len(joints) == space.n_joints else 0
        for a, b in tubes_of(joint, end):
            link = math.pi * radius**2 * of_joint(space.link_density, which) * math.dist(a, b)
            parts[i].append((link, 0.5 * (a + b)))
        on, at = motor_place(joints, i)
        if on >= 0:
            parts[on].append((of_joint(space.motor_mass, which) * grown**3, np.array(at)))
    return [_joined(each) for each in parts]


def _joined(parts: list[tuple[float, Array]]) -> Body:
    mass = math.fsum(mass for mass, _ in parts)
    if mass <= 0:
        return 0.0, (0.0, 0.0, 0.0)
    return mass, tuple((sum((m * at for m, at in parts), np.zeros(3)) / mass).tolist())


def heavier(body: Body, by: float, at: Triple) -> Body:
    """Return a body with so many kg more, or less, at a place, m; what is left is above 0."""
    mass, com = body
    whole = mass + by
    return whole, tuple((mass * c + by * a) / whole for c, a in zip(com, at, strict=True))


def inertial_text(body: Body) -> str:
    """Return a body as URDF's ``<inertial>``, without moments; "" if it has no mass."""
    mass, com = body
    if mass <= 0:
        return ""
    moments = '<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>'
    return f'<inertial><origin xyz="{text(com)}" rpy="0 0 0"/><mass value="{mass!r}"/>{moments}</inertial>'


def tube_text(a: Array, b: Array, radius: float) -> str:
    """Return a tube as URDF's ``<collision>``; "" if it has no length."""
    length = math.dist(a, b)
    if length <= 1e-6:
        return ""
    x, y, z = (b - a).tolist()
    xyz, rpy = tuple((0.5 * (a + b)).tolist()), (0.0, math.atan2(math.hypot(x, y), z), math.atan2(y, x))
    place = f'<origin xyz="{text(xyz)}" rpy="{text(rpy)}"/>'
    return f'<collision>{place}<geometry><cylinder radius="{radius!r}" length="{length!r}"/></geometry></collision>'
