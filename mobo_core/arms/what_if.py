"""The what-if table: what small changes of an arm would do, with intervals by common random numbers."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from mobo_core.arms.arm_joint import ArmJoint, motor_place
from mobo_core.arms.real import RealArm
from mobo_core.arms.resample import Interval, Resamples, Score
from mobo_core.arms.straight import leaning, limited, longer
from mobo_core.design import DesignSpace

By = Literal["both", "reach", "torque", "peak"]

LINK_MM, LIMIT_DEG, STROKE_MM, MASS_G, TILT_DEG = 10.0, 10.0, 10.0, 100.0, 10.0


@dataclass(frozen=True)
class Altered:
    """An arm changed in one thing: in words, what kind of thing, and as URDF."""

    change: str
    kind: Literal["link", "limit", "mass", "base"]
    urdf: str


@dataclass(frozen=True)
class WhatIf:
    """What a change does.

    Attributes:
        change, kind: of :class:`Altered`.
        reach: voxels more.
        torque: N m more, summed over the voxels.
        peaks: N m more, of each joint's largest torque.
        gain: percent more reach less percent more torque.
    """

    change: str
    kind: str
    reach: Interval
    torque: Interval
    peaks: tuple[Interval, ...]
    gain: float

    def to_dict(self) -> dict[str, object]:
        """Return plain values."""
        return {
            "change": self.change, "kind": self.kind, "gain": self.gain,
            "reach": self.reach.to_dict(), "torque": self.torque.to_dict(),
            "peaks": [peak.to_dict() for peak in self.peaks],
        }  # fmt: skip


def alterations(arm: RealArm, total: float | None, space: DesignSpace | None) -> Iterator[Altered]:
    """Yield an arm with each link 10 mm longer and shorter, each limit 10° (of a slide 10 mm) farther and nearer, 100 g
    more and less at each joint's motor, and the base leaning 10° towards x, y and away from them; those that cannot be
    are left out.

    Args:
        arm: with its order; lengths and strokes are those of the arm as it is evaluated.
        total: m, as in :meth:`RealArm.urdf`.
        space: likewise.
    """
    assert arm.order is not None
    scale = arm.scale(total)
    for link, length in enumerate(arm.order.lengths):
        for mm in (LINK_MM, -LINK_MM):
            if mm > 0 or 1e3 * scale * length >= LINK_MM:
                changed = longer(arm, link, 1e-3 * mm / scale)
                yield Altered(f"link {link + 1} {mm:+.0f} mm", "link", changed.urdf(total, space))
    for i, joint in enumerate(arm.joints):
        for change, ends in _other_limits(joint, scale):
            yield Altered(f"joint {i + 1} {change}", "limit", limited(arm, i, *ends).urdf(total, space))
    masses = arm.masses(total, space)
    for i in range(arm.n):
        on, _ = motor_place(arm.joints, i)
        for grams in (-MASS_G, MASS_G):
            if on >= 0 and masses[on] + 1e-3 * grams > 0:
                yield Altered(f"joint {i + 1} {grams:+.0f} g", "mass", arm.urdf(total, space, {i: 1e-3 * grams}))
    # Right-handed: about y to lean towards x, about -x to lean towards y.
    for name, axis in (("x", (0.0, 1.0, 0.0)), ("y", (-1.0, 0.0, 0.0))):
        for degrees in (TILT_DEG, -TILT_DEG):
            leant = leaning(arm, axis, math.radians(degrees))
            yield Altered(f"base {degrees:+.0f}° towards {name}", "base", leant.urdf(total, space))


def _other_limits(joint: ArmJoint, scale: float) -> Iterator[tuple[str, tuple[float, float]]]:
    """Yield changes of a joint's limits in words, and the limits; the arm is evaluated ``scale`` times as large."""
    # A unit as it is printed, in rad or m of the arm that is changed.
    by, unit, one = (STROKE_MM, " mm", 1e-3 / scale) if joint.slides else (LIMIT_DEG, "°", math.radians(1.0))
    for end, sign in (("upper", 1.0), ("lower", -1.0)):
        for change in (sign * by, -sign * by):
            lower, upper = joint.lower, joint.upper
            if end == "upper":
                upper += change * one
            else:
                lower += change * one
            if lower < upper:
                to = (upper if end == "upper" else lower) / one
                yield f"{end} limit {change:+.0f}{unit}, to {to:.0f}{unit}", (lower, upper)


def what_if(
    base: Score, changed: Sequence[Altered], resamples: Resamples, progress: Callable[[int, int], None], by: By = "both"
) -> list[WhatIf]:
    """Return what each change does to an arm, what helps most first.

    Args:
        base: the arm as it is; it reaches something.
        changed: the arm, changed.
        resamples: that ``base`` was scored by.
        progress: called with (done, in all).
        by: what helps: percent more reach less percent more torque (both), or one of them, or the largest peak less.
    """
    found = []
    for done, one in enumerate(changed):
        progress(done, len(changed))
        score = resamples.score(one.urdf)
        reach, torque, *peaks = score.over(base)
        gain = 100.0 * (reach.value / base.reach - (torque.value / base.torque if base.torque > 0 else 0.0))
        largest = float(score.values[2:].max() - base.values[2:].max())
        key = {"both": -gain, "reach": -reach.value, "torque": torque.value, "peak": largest}[by]
        found.append((key, done, WhatIf(one.change, one.kind, reach, torque, tuple(peaks), gain)))
    progress(len(changed), len(changed))
    return [row for _, _, row in sorted(found, key=lambda each: each[:2])]
