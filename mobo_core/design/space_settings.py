"""What may be set of the arms that a study searches."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, field_validator, model_validator

from mobo_core.design import checks
from mobo_core.design.joints import DEFAULT_LETTERS, JOINTS, count_built
from mobo_core.design.lengths import Links
from mobo_core.design.numbers import Given, Numbers, Ranges, Several, ends, of_joint
from mobo_core.design.numbers import text_of as several
from mobo_core.settings import Settings

# What may be one value for all joints, or a list of one for each.
_BY_JOINT = (
    "joints", "fixed_lengths", "joint_limit", "joint_center", "motor_mass", "motor_radius", "motor_length",
    "slide_stroke", "slide_radius",
)  # fmt: skip


class SpaceSettings(Settings):
    """The settings of a :class:`~mobo_core.design.space.DesignSpace`, and what follows from them alone."""

    later: ClassVar[tuple[str, ...]] = ("joint_center", "slide_stroke", "slide_radius")

    n_joints: int = Field(6, ge=1, le=12, description="joints of an arm")
    joint_types: str = Field(DEFAULT_LETTERS, description="letters of the joint types to choose from")
    joints: tuple[str, ...] = Field(
        (), description="the letters to choose from joint by joint, such as [Y, P, RPY], over joint_types"
    )
    lengths: Literal["fractions", "sequential"] = Field(
        "fractions", description="how link lengths are drawn: fractions or sequential (the paper's)"
    )
    total_length: Annotated[Several, Numbers(0, 1e3, above=True, many="range")] = Field(
        0.6, description="m, of the stretched arm; a range is searched"
    )
    max_length: float = Field(0.3, gt=0, le=1e3, description="m, of one link; of the last one see last_link")
    last_link: Literal["remainder", "bounded"] = Field(
        "remainder", description="whether max_length binds the last link too: it takes what remains, or is bounded"
    )
    min_length: float = Field(0.0, ge=0, le=1e3, description="m, of every link that is not zero")
    zero_lengths: Literal["allowed", "wrist", "never"] = Field(
        "allowed",
        description="links that may be zero: all, none, or the two between the last three joints, whose axes then "
        "meet in one point as in a spherical wrist",
    )
    fixed_lengths: Annotated[Given, Numbers(0, 1e3, many="given")] = Field(
        (), description="m, of each link, null where it is searched; they need not keep to the bounds"
    )
    joint_limit: Annotated[Several, Numbers(0, 2 * math.pi, above=True, angle=True)] = Field(
        0.75 * math.pi, description="rad, or text such as 135deg; either way"
    )
    joint_center: Annotated[Ranges, Numbers(-math.pi, math.pi, many="ranges", angle=True)] = Field(
        0.0, description="rad, or text such as 90deg, the middle of each joint's range; a range is searched"
    )
    motor_mass: Annotated[Several, Numbers(0, 1e4, above=True)] = Field(0.5, description="kg, a point at each joint")
    motor_radius: Annotated[Several, Numbers(0, 10)] = Field(
        0.0, description="m, of the motor's body, a cylinder along the joint axis that must not collide; 0: none"
    )
    motor_length: Annotated[Several, Numbers(0, 10)] = Field(
        0.0, description="m, of that cylinder; as for all cylinders, half-balls stand out beyond its ends"
    )
    link_radius: float = Field(0.015, gt=0, le=10, description="m, of the links, which are cylinders")
    link_density: float = Field(1000.0, gt=0, le=1e5, description="kg/m^3, of the links, as if solid")
    base_height: Annotated[Several, Numbers(-100, 100, many="range")] = Field(
        0.0, description="m, of the first joint above the base frame; a range is searched"
    )
    base_tilt: Annotated[Several, Numbers(-math.pi, math.pi, many="range", angle=True)] = Field(
        0.0, description="rad, or text such as 45deg, by which the straight arm leans towards x; a range is searched"
    )

    slide_stroke: Annotated[Several, Numbers(0, 10, above=True)] = Field(
        0.2, description="m, of a joint that slides (S): half of it either way, no more than its own link is long"
    )
    slide_radius: Annotated[Several, Numbers(0, 1e3, above=True)] = Field(
        0.05, description="m, of the pinion that drives a joint that slides: its force counts as torque at it"
    )

    @model_validator(mode="before")
    @classmethod
    def _count(cls, values: object) -> object:
        if isinstance(values, dict) and "n_joints" not in values and isinstance(values.get("joints"), list | tuple):
            return values | ({"n_joints": len(values["joints"])} if values["joints"] else {})
        return values

    @field_validator("joints", mode="before")
    @classmethod
    def _listed(cls, joints: object) -> object:
        if not isinstance(joints, list | tuple):
            raise ValueError("a list of letters joint by joint, such as [Y, P, RPY]; their number is n_joints")
        return joints

    @field_validator("joints")
    @classmethod
    def _letters_of_places(cls, joints: tuple[str, ...]) -> tuple[str, ...]:
        for letters in joints:
            checks.check_letters("each", letters)
        return joints

    @model_validator(mode="after")
    def _fits(self) -> Self:
        checks.check_letters("joint_types", self.joint_types)
        checks.check_counts(self.n_joints, {name: getattr(self, name) for name in _BY_JOINT})
        checks.check_motors(self.n_joints, self.motor_radius, self.motor_length)
        checks.check_bounds(self.min_length, self.max_length, self.zero_lengths)
        checks.check_total(self.links, self.total_length)
        return self

    @property
    def places(self) -> tuple[str, ...]:
        """For each joint, the letters that may be drawn."""
        return self.joints or (self.joint_types,) * self.n_joints

    @property
    def letters(self) -> str:
        """All letters that may be drawn."""
        return "".join(dict.fromkeys("".join(self.places)))

    @property
    def n_orders(self) -> int:
        """The number of joint orders as built."""
        return count_built(self.places)

    @property
    def total_ends(self) -> tuple[float, float]:
        """The least and the largest total length in m."""
        return ends(self.total_length)

    @property
    def total_text(self) -> str:
        """The total length in m for people, such as ``0.6`` or ``0.4 to 0.8``."""
        return several(self.total_length)

    @property
    def longest_reach(self) -> float:
        """A bound on m from the first joint, where that slides from its middle, to the tip: with all slides run out."""
        sliding = [
            0.5 * of_joint(self.slide_stroke, i)
            for i, letters in enumerate(self.places)
            if any(JOINTS[letter].motion == "prismatic" for letter in letters)
        ]
        return self.total_ends[1] + math.fsum(sliding)

    @property
    def longest_total(self) -> float:
        """The largest total length, in m, of links none of which is longer than ``max_length`` or as fixed."""
        if self.n_joints == 1:
            return math.inf  # one link is all that remains
        return replace(self.links, bounded=True).totals[-1][1]

    @property
    def links(self) -> Links:
        """What lengths the links may have."""
        n = self.n_joints
        zero = self.zero_lengths
        may_be_zero = tuple(zero == "allowed" or (zero == "wrist" and n - 3 <= i < n - 1) for i in range(n))
        fixed = self.fixed_lengths or (None,) * n
        return _links(self.min_length, self.max_length, may_be_zero, fixed, self.last_link == "bounded")

    @property
    def centers(self) -> tuple[Several, ...]:
        """The middle of each joint's range in rad, or from where to where it is searched."""
        return self.joint_center if isinstance(self.joint_center, tuple) else (self.joint_center,) * self.n_joints

    @property
    def searched_centers(self) -> dict[str, tuple[float, float]]:
        """The ends of those that are searched, by the names of their parameters, ``c1`` for the first joint."""
        return {f"c{i}": ends(center) for i, center in enumerate(self.centers, start=1) if isinstance(center, tuple)}


_links = lru_cache(maxsize=64)(Links)
