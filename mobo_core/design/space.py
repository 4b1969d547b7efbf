"""The space of arms that a study searches."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from optuna.distributions import BaseDistribution
from optuna.trial import BaseTrial, FixedTrial

from mobo_core.design import checks
from mobo_core.design.design import Design
from mobo_core.design.lengths import Interval, added, nearest, text_of
from mobo_core.design.numbers import Several, ends, middle
from mobo_core.design.space_settings import SpaceSettings
from mobo_core.errors import InputError

# m or rad, by which numbers that people write may miss a bound.
_ROUNDING = 1e-6


class DesignSpace(SpaceSettings):
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


def _drawn(trial: BaseTrial, name: str, value: Several) -> float:
    return trial.suggest_float(name, *ends(value)) if isinstance(value, tuple) else value


def _at_share(choices: Sequence[Interval], share: float) -> float:
    """Return the length at a share of the way from the shortest to the longest."""
    low, high = choices[0][0], choices[-1][1]
    return high if share >= 1.0 else nearest(choices, low + share * (high - low))


def _bounds(allowed: Sequence[Interval]) -> str:
    (low, high), *others = allowed
    return f"at most {high:.9g} m" if not others and low == 0.0 else f"{text_of(allowed)} m"
