"""The space of arms that a study searches."""

from __future__ import annotations

import math
from typing import Any, Literal

from optuna.distributions import BaseDistribution
from optuna.trial import BaseTrial, FixedTrial
from pydantic import Field, model_validator

from mobo_core.design.design import Design
from mobo_core.design.joints import JOINTS, count_orders
from mobo_core.errors import InputError
from mobo_core.settings import Settings

# m, by which lengths that people write may miss a bound.
_ROUNDING = 1e-6
_DEFAULT_TYPES = "".join(joint.letter for joint in JOINTS.built_in)


class DesignSpace(Settings):
    """Which arms are candidates, and what their parts weigh. The defaults are the paper's 6-DOF experiment.

    ``lengths`` says how the sampler draws link lengths. Both ways span the same set of arms:

    * ``sequential``, the paper's: L_i in [0, min(max_length, what remains of total_length)] in metres,
      so the range of each depends on the ones before.
    * ``fractions``: u_i in [0, 1] is the share of that same upper bound. All ranges stay fixed, so that a
      sampler can model all parameters jointly.

    In both, the last link takes what remains and may exceed ``max_length``.
    """

    n_joints: int = Field(6, ge=1, le=12, description="joints of an arm")
    joint_types: str = Field(_DEFAULT_TYPES, description="letters of the joint types to choose from")
    lengths: Literal["fractions", "sequential"] = Field(
        "fractions", description="how link lengths are drawn: fractions or sequential (the paper's)"
    )
    total_length: float = Field(0.6, gt=0, le=1e3, description="m, of the stretched arm")
    max_length: float = Field(0.3, gt=0, le=1e3, description="m, of one link but the last")
    joint_limit: float = Field(0.75 * math.pi, gt=0, le=2 * math.pi, description="rad, either way")
    motor_mass: float = Field(0.5, gt=0, le=1e4, description="kg, a point at each joint")
    link_radius: float = Field(0.015, gt=0, le=10, description="m")
    link_density: float = Field(1000.0, gt=0, le=1e5, description="kg/m^3")

    @model_validator(mode="after")
    def _letters(self) -> DesignSpace:
        letters = self.joint_types
        if not letters or len(set(letters)) != len(letters) or any(letter not in JOINTS for letter in letters):
            raise ValueError(f"joint_types to be distinct letters of {''.join(JOINTS)}")
        return self

    @property
    def n_orders(self) -> int:
        """The number of joint orders as built."""
        return count_orders(self.n_joints, self.joint_types)

    def suggest(self, trial: BaseTrial) -> Design:
        """Draw a design from an Optuna trial."""
        joints = "".join(
            trial.suggest_categorical(f"J{i + 1}", tuple(self.joint_types)) for i in range(self.n_joints)
        )
        lengths: list[float] = []
        for i in range(self.n_joints - 1):
            longest = self._longest(lengths)
            if self.lengths == "fractions":
                lengths.append(trial.suggest_float(f"u{i + 1}", 0.0, 1.0) * longest)
            else:
                lengths.append(trial.suggest_float(f"L{i + 1}", 0.0, longest))
        lengths.append(max(0.0, self.total_length - sum(lengths)))
        return Design(joints, tuple(lengths))

    def design(self, params: dict[str, Any]) -> Design:
        """Return the design of a sampler's parameters, as :meth:`suggest` would have built it."""
        return self.suggest(FixedTrial(params))

    def params(self, design: Design) -> dict[str, Any]:
        """Return the sampler's parameters of a design: :meth:`design` of them gives its lengths to 1e-9 m.

        The last link takes what remains of ``total_length``, from which the lengths' sum may differ by 1e-6 m.

        Raises:
            InputError: the design is none of this space.
        """
        if len(design.sampled_joints) != self.n_joints:
            expected = f"{self.n_joints}"
            raise InputError(f"{len(design.sampled_joints)} joints", where="joints", expected=expected)
        for letter in design.sampled_joints:
            if letter not in self.joint_types:
                raise InputError(f"joint {letter!r}", where="joints", expected=f"letters of {self.joint_types}")
        design.check_total(self.total_length)
        params: dict[str, Any] = {f"J{i + 1}": letter for i, letter in enumerate(design.sampled_joints)}
        lengths: list[float] = []
        for i, length in enumerate(design.lengths[:-1]):
            longest = self._longest(lengths)
            if length > longest + _ROUNDING:
                expected = f"at most {longest:.9g} m"
                raise InputError(f"length {i + 1} is {length:.9g} m", where="lengths", expected=expected)
            length = min(length, longest)
            if self.lengths == "fractions":
                share = length / longest if longest > 0.0 else 0.0
                params[f"u{i + 1}"] = share
                lengths.append(share * longest)
            else:
                params[f"L{i + 1}"] = length
                lengths.append(length)
        return params

    def _longest(self, lengths: list[float]) -> float:
        """Return the upper bound, in m, of the link that follows ``lengths``."""
        # Rounding can leave a remainder a little below zero.
        return min(self.max_length, max(0.0, self.total_length - sum(lengths)))

    def distributions(self, params: dict[str, Any]) -> dict[str, BaseDistribution]:
        """Return the Optuna distributions from which :meth:`suggest` would draw ``params``."""
        trial = FixedTrial(params)
        self.suggest(trial)
        return trial.distributions
