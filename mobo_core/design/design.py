"""One arm: the order of its joints and the lengths of its links."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

from mobo_core.design.joints import JOINTS, effective_joints, joint_letters
from mobo_core.errors import InputError

MAX_JOINTS = 64


@dataclass(frozen=True)
class Design:
    """A serial arm of joints of the types in :data:`JOINTS`, straight up when all joints are at zero.

    Attributes:
        sampled_joints: joint order as drawn, such as ``YRPYPR``.
        lengths: metres; link i follows joint i, the last one ends in the tool.
        base_height: metres, of the first joint above the base frame.
        base_tilt: rad, by which the straight arm leans from z towards x, turned about y at the first joint.
        joint_centers: rad, the middle of each joint's range; empty where the space says it.

    Raises:
        InputError: an unknown joint letter, a length that is negative or not finite, or numbers that differ.
    """

    sampled_joints: str
    lengths: tuple[float, ...]
    base_height: float = 0.0
    base_tilt: float = 0.0
    joint_centers: tuple[float, ...] = field(default=(), repr=False)  # the text of other designs is as it was

    def __post_init__(self) -> None:
        """Check letters, counts and lengths."""
        object.__setattr__(self, "lengths", tuple(float(length) for length in self.lengths))
        n = len(self.sampled_joints)
        if not 1 <= n <= MAX_JOINTS:
            raise InputError(f"{n} joints", where="joints", expected=f"1 to {MAX_JOINTS}")
        for i, joint in enumerate(self.sampled_joints):
            if joint not in JOINTS:
                raise InputError(
                    f"unknown joint {joint!r} at place {i + 1} of {self.sampled_joints!r}",
                    where="joints",
                    expected=joint_letters(),
                )
        if len(self.lengths) != n:
            raise InputError(
                f"{len(self.lengths)} lengths for {n} joints", where="lengths", expected=f"{n} lengths in metres"
            )
        for i, length in enumerate(self.lengths):
            if not (math.isfinite(length) and length >= 0):
                raise InputError(f"length {i + 1} is {length!r}", where="lengths", expected="metres, 0 or more")
        if len(self.joint_centers) not in (0, n):
            raise InputError(f"{len(self.joint_centers)} numbers", where="joint_centers", expected=f"{n}, or none")
        named = [("base_height", self.base_height), ("base_tilt", self.base_tilt)]
        for name, value in (*named, *(("joint_centers", center) for center in self.joint_centers)):
            if not math.isfinite(value):
                raise InputError(repr(value), where=name, expected="a finite number")

    @cached_property
    def joints(self) -> str:
        """The joint order as built, redundant neighbours replaced; also the name of the structure."""
        return effective_joints(self.sampled_joints)

    @property
    def name(self) -> str:
        """The canonical name, such as ``YPPYPY``."""
        return self.joints

    @property
    def total_length(self) -> float:
        """The length of the stretched arm in metres."""
        return math.fsum(self.lengths)

    def check_total(self, total_length: float, tolerance: float = 1e-6) -> None:
        """Raise InputError unless the lengths add up to ``total_length`` metres."""
        if abs(self.total_length - total_length) > tolerance:
            raise InputError(
                f"lengths add up to {self.total_length:.9g} m",
                where="lengths",
                expected=f"{total_length:.9g} m within {tolerance:g}",
            )
