"""A joint of a real arm: it turns, or it slides."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mobo_core.arms.rigid import Array, Placement, Triple, rotation


@dataclass(frozen=True)
class ArmJoint:
    """A joint.

    Attributes:
        placed: its frame in that of the joint before.
        axis: in that frame, of length 1: what it turns about, or slides along.
        lower, upper: rad; of a joint that slides, m.
        slide: m, radius of the pinion that drives a joint that slides; 0 if it turns.
    """

    placed: Placement
    axis: Triple
    lower: float
    upper: float
    slide: float = 0.0

    @property
    def slides(self) -> bool:
        """Whether it slides."""
        return self.slide > 0

    @property
    def middle(self) -> float:
        """M, the middle of a slide's stroke: there lengths are taken."""
        return 0.5 * (self.lower + self.upper)

    def rotation(self, q: float) -> Array:
        """Return the rotation (3, 3) of what it carries, at ``q`` rad or m."""
        return np.eye(3) if self.slides else rotation(np.array(self.axis), q)

    def shift(self, q: float) -> Array:
        """Return by how much it moves the origin of what it carries, (3,) m, at ``q`` rad or m."""
        return q * np.array(self.axis) if self.slides else np.zeros(3)

    def scaled(self, scale: float, radius: float | None = None) -> ArmJoint:
        """Return the joint of an arm so many times as large; its pinion of ``radius`` m, if not None."""
        placed = Placement(tuple(scale * v for v in self.placed.xyz), self.placed.rpy)
        if not self.slides:
            return replace(self, placed=placed)
        slide = scale * self.slide if radius is None else radius
        return replace(self, placed=placed, lower=scale * self.lower, upper=scale * self.upper, slide=slide)


def motor_place(joints: Sequence[ArmJoint], joint: int) -> tuple[int, Triple]:
    """Return which joint carries the motor of a joint, both from 0, and where in its frame, m.

    That of a joint which slides sits on the link before, at the joint's origin; -1 is the base.
    """
    return (joint - 1, joints[joint].placed.xyz) if joints[joint].slides else (joint, (0.0, 0.0, 0.0))
