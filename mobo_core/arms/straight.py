"""A real arm from a chain, and changed a little: links along the straightened arm, limits, masses, the base."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from mobo_core.arms.arm_joint import ArmJoint
from mobo_core.arms.order import order_of, upright
from mobo_core.arms.real import RealArm
from mobo_core.arms.rigid import Array, Placement, rotation, rotation_rpy
from mobo_core.evaluation.chain import Chain


def arm_of_chain(chain: Chain, name: str, source: str = "") -> RealArm:
    """Return the arm that a chain is, with its joint order; it takes a second or so.

    Args:
        chain: its joints turn about z, or slide along it.
        name: of the arm.
        source: the file it is from.
    """
    joints = tuple(
        ArmJoint(_placed(turned, at), (0.0, 0.0, 1.0), float(lower), float(upper), float(slide))
        for turned, at, lower, upper, slide in zip(
            chain.placement_r, chain.placement_p, chain.lower, chain.upper, chain.slide, strict=True
        )
    )
    bodies = tuple((float(mass), tuple(com.tolist())) for mass, com in zip(chain.mass, chain.com, strict=True))
    known = bodies if math.fsum(chain.mass) > 0 else None
    arm = RealArm(name, "", joints, _placed(chain.tip_r, chain.tip_p), known, {"path": source}, "")
    return replace(arm, order=order_of(arm))


def name_of_file(path: str) -> str:
    """Return what to call the arm of a file."""
    return Path(path).name.partition(".")[0] or "arm"


def _placed(turned: Array, at: Array) -> Placement:
    return Placement(tuple(at.tolist()), rotation_rpy(np.asarray(turned)))


def longer(arm: RealArm, link: int, by: float) -> RealArm:
    """Return the arm with a link (from 0) longer by so many m, up along the arm as it is straightened.

    What :attr:`RealArm.length` says stays, so that a scaled arm keeps its scale.
    """
    assert arm.order is not None
    turned = np.eye(3)
    for joint, q in zip(arm.joints[: link + 1], arm.order.q, strict=False):
        turned = turned @ joint.placed.matrix @ joint.rotation(q)
    up = upright(arm).T @ np.array([0.0, 0.0, 1.0])
    step = by * (turned.T @ up)
    if link == arm.n - 1:
        return replace(arm, tip=_moved(arm.tip, step))
    joints = list(arm.joints)
    joints[link + 1] = replace(joints[link + 1], placed=_moved(joints[link + 1].placed, step))
    return replace(arm, joints=tuple(joints))


def _moved(placed: Placement, step: Array) -> Placement:
    return Placement(tuple((np.array(placed.xyz) + step).tolist()), placed.rpy)


def limited(arm: RealArm, joint: int, lower: float, upper: float) -> RealArm:
    """Return the arm with other limits of a joint (from 0), rad or m."""
    joints = list(arm.joints)
    joints[joint] = replace(joints[joint], lower=lower, upper=upper)
    return replace(arm, joints=tuple(joints))


def leaning(arm: RealArm, axis: tuple[float, float, float], angle: float) -> RealArm:
    """Return the arm with its base turned about a unit axis of the base frame through the first joint, rad."""
    first = arm.joints[0]
    turned = rotation(np.array(axis), angle) @ first.placed.matrix
    placed = Placement(first.placed.xyz, rotation_rpy(turned))
    return replace(arm, joints=(replace(first, placed=placed), *arm.joints[1:]))
