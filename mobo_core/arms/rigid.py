"""Placements and inertias of rigid bodies, as URDF writes them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Triple = tuple[float, ...]


def rotation(axis: Array, angle: float) -> Array:
    """Return the rotation (3, 3) about a unit ``axis`` (3,) by ``angle`` rad (Rodrigues)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turned: Array = np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * (cross @ cross)
    return turned


def rpy_rotation(rpy: Triple) -> Array:
    """Return the rotation (3, 3) of fixed-axis roll, pitch and yaw in rad."""
    roll, pitch, yaw = (rotation(axis, angle) for axis, angle in zip(np.eye(3), rpy, strict=True))
    turned: Array = yaw @ pitch @ roll
    return turned


def rotation_rpy(turned: Array) -> Triple:
    """Return roll, pitch and yaw of a rotation; exact to rounding also where the pitch is a right angle."""
    # Each angle is taken from what the ones before leave, so that none depends on a small difference.
    x, y, z = np.eye(3)
    yaw = math.atan2(turned[1, 0], turned[0, 0])
    rest = rotation(z, -yaw) @ turned
    pitch = math.atan2(-rest[2, 0], rest[0, 0])
    rest = rotation(y, -pitch) @ rest
    return math.atan2(rest[2, 1], rest[1, 1]), pitch, yaw


@dataclass(frozen=True)
class Placement:
    """Where a frame stands in another one, as an ``<origin>`` says: ``xyz`` in m, ``rpy`` in rad."""

    xyz: Triple = (0.0, 0.0, 0.0)
    rpy: Triple = (0.0, 0.0, 0.0)

    @property
    def matrix(self) -> Array:
        """The rotation, (3, 3)."""
        return rpy_rotation(self.rpy)

    def then(self, inner: Placement) -> Placement:
        """Return where ``inner``, said in this frame, stands in the outer one; what adds nothing changes nothing."""
        if self == Placement():
            return inner
        if inner == Placement():
            return self
        turned, origin = self.matrix, np.array(self.xyz)
        xyz = tuple((origin + turned @ np.array(inner.xyz)).tolist())
        return Placement(xyz, rotation_rpy(turned @ inner.matrix))


@dataclass(frozen=True)
class Inertial:
    """Mass in kg, its centre in m and the moments (3, 3) in kg m^2 about it, all in the frame of a link."""

    mass: float
    com: Array
    moments: Array

    def moved(self, placement: Placement) -> Inertial:
        """Return the same body in the frame in which ``placement`` is said."""
        turned = placement.matrix
        com = np.array(placement.xyz) + turned @ self.com
        return Inertial(self.mass, com, turned @ self.moments @ turned.T)


def joined(bodies: list[Inertial]) -> Inertial:
    """Return bodies of one frame as one (parallel axes)."""
    mass = math.fsum(body.mass for body in bodies)
    com: Array = sum((body.mass * body.com for body in bodies), np.zeros(3)) / mass
    moments = np.zeros((3, 3))
    for body in bodies:
        arm = body.com - com
        moments += body.moments + body.mass * (float(arm @ arm) * np.eye(3) - np.outer(arm, arm))
    return Inertial(mass, com, moments)
