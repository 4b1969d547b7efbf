"""The space of arms that a study searches."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Annotated, Any, ClassVar, Literal

from optuna.distributions import BaseDistribution
from optuna.trial import BaseTrial, FixedTrial
from pydantic import (
    Field,
    field_validator,
    model_validator,
)

from mobo_core.design import checks
from mobo_core.design.design import Design
from mobo_core.design.joints import DEFAULT_LETTERS, JOINTS, count_built
from mobo_core.design.lengths import Interval, Links, added, nearest, text_of
from mobo_core.design.numbers import Given, Numbers, Ranges, Several, ends, middle, of_joint
from mobo_core.design.numbers import text_of as several
from mobo_core.errors import InputError
from mobo_core.settings import Settings

# m or rad, by which numbers that people write may miss a bound.
_ROUNDING = 1e-6
# What may be one value for all joints, or a list of one for each.
_BY_JOINT = (
    "joints", "fixed_lengths", "joint_limit", "joint_center", "motor_mass", "motor_radius", "motor_length",
    "slide_stroke", "slide_radius",
)  

class DesignSpace(Settings):
    """Which arms are candidates, and what their parts weigh. The defaults are the paper's 6-DOF experiment.

    ``lengths`` says how the sampler draws link lengths. Both ways span the same set of arms:

    * ``sequential``, the paper's: L_i in metres, between the shortest and the longest that leave the links after it
      a sum that they can make; the paper's is [0, min(max_length, what remains of total_length)]. So the range of
      each depends on the ones before.
    * ``fractions``: u_i in [0, 1] is the share of the way between these two. All ranges stay fixed, so that a sampler
      can model all parameters jointly.

    In both, a length that falls between 0 and ``min_length`` is put to the nearer of the two that may be, and the
    last link that is not fixed takes what remains.
    """

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
    def _fits(self) -> DesignSpace:
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

    def suggest(self, trial: BaseTrial) -> Design:
        """Draw a design from an Optuna trial."""
        joints = "".join(
            trial.suggest_categorical(f"J{i + 1}", tuple(letters)) if self._open(letters) else letters
            for i, letters in enumerate(self.places)
        )
        total = _drawn(trial, "T", self.total_length)
        links = self.links
        lengths: list[float] = []
        for i, fixed in enumerate(links.fixed):
            rest = total - added(lengths)
            if fixed is not None:
                lengths.append(fixed)
            elif i == links.last:
                lengths.append(links.remainder(rest))
            else:
                choices = links.choices(i, rest)
                low, high = choices[0][0], choices[-1][1]
                if self.lengths == "fractions":
                    lengths.append(_at_share(choices, trial.suggest_float(f"u{i + 1}", 0.0, 1.0)))
                else:
                    lengths.append(nearest(choices, trial.suggest_float(f"L{i + 1}", low, high)))
        height = _drawn(trial, "base_height", self.base_height)
        tilt = _drawn(trial, "base_tilt", self.base_tilt)
        searched = bool(self.searched_centers)
        centers = [_drawn(trial, f"c{i}", center) for i, center in enumerate(self.centers, start=1) if searched]
        return Design(joints, tuple(lengths), height, tilt, tuple(centers))

    def arm(self, joints: str, lengths: Iterable[float]) -> Design:
        """Return the design of these joints and lengths on the space's base, or in the middle of where that may be."""
        return Design(joints, tuple(lengths), middle(self.base_height), middle(self.base_tilt))

    def design(self, params: dict[str, Any]) -> Design:
        """Return the design of a sampler's parameters, as :meth:`suggest` would have built it.

        Raises:
            InputError: they are none of this space.
        """
        try:
            return self.suggest(FixedTrial(params))
        except (ValueError, KeyError, TypeError, AttributeError, ArithmeticError) as error:
            raise InputError(f"{error!r:.80}", where="parameters", expected="those of the space") from None

    def params(self, design: Design) -> dict[str, Any]:
        """Return the sampler's parameters of a design: :meth:`design` of them gives its lengths to 1e-9 m.

        The last link takes what remains of ``total_length``, from which the lengths' sum may differ by 1e-6 m.

        Raises:
            InputError: the design is none of this space.
        """
        checks.check_letters_of(design.sampled_joints, self.places)
        total = self.total_of(design)
        params: dict[str, Any] = {
            f"J{i + 1}": letter
            for i, (letter, letters) in enumerate(zip(design.sampled_joints, self.places, strict=True))
            if self._open(letters)
        }
        if isinstance(self.total_length, tuple):
            params["T"] = total
        links = self.links
        for i, (length, allowed) in enumerate(zip(design.lengths, links.allowed, strict=True), start=1):
            if abs(nearest(allowed, length) - length) > _ROUNDING:
                raise InputError(f"length {i} is {length:.9g} m", where="lengths", expected=_bounds(allowed))
        lengths: list[float] = []
        for i, length in enumerate(design.lengths[: links.last]):
            if (fixed := links.fixed[i]) is not None:
                lengths.append(fixed)
                continue
            choices = links.choices(i, total - added(lengths))
            length = nearest(choices, length)
            if self.lengths == "fractions":
                low, high = choices[0][0], choices[-1][1]
                share = (length - low) / (high - low) if high > low else 0.0
                params[f"u{i + 1}"] = share
                lengths.append(_at_share(choices, share))
            else:
                params[f"L{i + 1}"] = length
                lengths.append(length)
        for name in ("base_height", "base_tilt"):
            value = checks.check_in(name, getattr(design, name), getattr(self, name), _ROUNDING)
            if isinstance(getattr(self, name), tuple):
                params[name] = value
        own = design.joint_centers or tuple(map(middle, self.centers))
        for i, (center, within) in enumerate(zip(own, self.centers, strict=True), start=1):
            center = checks.check_in(f"joint_center {i}", center, within, _ROUNDING)
            if isinstance(within, tuple):
                params[f"c{i}"] = center
        return params

    def total_of(self, design: Design) -> float:
        """Return what the design's lengths add up to, as one of ``total_length``.

        Raises:
            InputError: it is off by more than 1e-6 m.
        """
        if not isinstance(self.total_length, tuple):
            design.check_total(self.total_length)
            return self.total_length
        low, high = self.total_length
        total = design.total_length
        if not low - _ROUNDING <= total <= high + _ROUNDING:
            raise InputError(f"lengths add up to {total:.9g} m", where="lengths", expected=f"{low:g} to {high:g} m")
        return min(max(total, low), high)

    def _open(self, letters: str) -> bool:
        # A choice of one letter is a parameter if joint_types says so, as it always was.
        return len(letters) > 1 or not self.joints

    def distributions(self, params: dict[str, Any]) -> dict[str, BaseDistribution]:
        """Return the Optuna distributions from which :meth:`suggest` would draw ``params``."""
        trial = FixedTrial(params)
        self.suggest(trial)
        return trial.distributions


_links = lru_cache(maxsize=64)(Links)


def _drawn(trial: BaseTrial, name: str, value: Several) -> float:
    return trial.suggest_float(name, *ends(value)) if isinstance(value, tuple) else value


def _at_share(choices: Sequence[Interval], share: float) -> float:
    """Return the length at a share of the way from the shortest to the longest."""
    low, high = choices[0][0], choices[-1][1]
    return high if share >= 1.0 else nearest(choices, low + share * (high - low))


def _bounds(allowed: Sequence[Interval]) -> str:
    (low, high), *others = allowed
    return f"at most {high:.9g} m" if not others and low == 0.0 else f"{text_of(allowed)} m"
