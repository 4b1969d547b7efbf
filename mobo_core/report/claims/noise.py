"""How sure a number of some arms is: poses drawn anew."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from mobo_core.report.claims.evidence import Arm, Array, Evidence
from mobo_core.report.claims.verdict import Number, Part

RESAMPLES = 400
_SEED = 0
_ENDS = (2.5, 97.5)
# Of an arm without voxels: the poses' noise of reach as a share of the least difference that counts, and of torque.
_REACH_SE, _TORQUE_SE = 0.35, 0.01

_STUDENT = (12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365)

# From reach and torque of arms, (arms, …), to margins, (…).
Margin = Callable[[Array, Array], Array]
# Prefixes, each with where it was searched.
Searched = Sequence[tuple[Evidence, str]]


def draws(arms: Sequence[tuple[Evidence, Arm]]) -> tuple[Array, Array]:
    """Return reach and torque of arms, (arms, RESAMPLES) each, as other poses would have them.

    The voxels stay: they are the question's own, and no sample. See
    :func:`mobo_core.report.uncertainty.standard_errors`.
    """
    chance = np.random.default_rng(_SEED)
    reach, torque = chance.standard_normal((2, len(arms), RESAMPLES))
    for i, (evidence, arm) in enumerate(arms):
        reach_se, torque_se = standard_error(evidence, arm)
        reach[i], torque[i] = arm.reach + reach_se * reach[i], arm.torque + torque_se * torque[i]
    return np.maximum(reach, 1e-9), np.maximum(torque, 1e-9)


def standard_error(evidence: Evidence, arm: Arm) -> tuple[float, float]:
    """Return by how much reach (voxels) and torque (N m) of an arm would differ with other poses."""
    maps = None if evidence.fair else evidence.maps(arm)  # an atlas holds none, and there are many arms
    if maps is None:
        return _REACH_SE * evidence.step, _TORQUE_SE * arm.torque
    p, _, deviation = maps
    poses = evidence.spec.poses_per_voxel
    reach, torque = p * (1 - p) / poses, deviation * deviation / np.maximum(p * poses, 1.0)
    return float(np.sqrt(reach.sum())), float(np.sqrt(torque.sum()))


def compared(
    name: str,
    arms: Sequence[tuple[Evidence, Arm]],
    margin: Margin,
    *,
    least: float = 0.0,
    raised_by: Searched = (),
    lowered_by: Searched = (),
    numbers: dict[str, Number] | None = None,
) -> Part:
    """Return what a number of some arms comes to.

    Args:
        name: of the part.
        arms: with the evidence they are from.
        margin: the number, from reach and torque.
        least: half of the interval, at least.
        raised_by: prefixes that, were they better than found, would raise the margin.
        lowered_by: likewise lower it.
        numbers: to be told with it.
    """
    reach, torque = (np.array([[getattr(arm, what)] for _, arm in arms]) for what in ("reach", "torque"))
    value = float(margin(np.maximum(reach, 1e-9), np.maximum(torque, 1e-9))[0])
    interval = interval_of(margin(*draws(arms)), value, least)
    told = numbers if numbers is not None else named(arms)
    return judged(name, value, interval, raised_by, lowered_by, told)


def interval_of(values: Array, value: float, least: float = 0.0) -> tuple[float, float]:
    """Return the interval of 95 % of draws, the value itself and ``least`` to both of its sides in it."""
    low, high = np.percentile(values, _ENDS)
    return min(float(low), value - least), max(float(high), value + least)


def judged(
    name: str,
    value: float,
    interval: tuple[float, float],
    raised_by: Searched = (),
    lowered_by: Searched = (),
    numbers: dict[str, Number] | None = None,
) -> Part:
    """Return a part; it is unsure if what was hardly searched could turn its verdict."""
    rests_on = lowered_by if interval[0] > 0 else raised_by if interval[1] < 0 else ()
    unknown = [prefix for evidence, prefix in rests_on if evidence.unknown([prefix])]
    return Part(name, value, interval, dict(numbers or {}), tuple(dict.fromkeys(unknown)))


def student(freedom: int) -> float:
    """Return the 97.5 % quantile of Student's t, to 1 % (the normal's, and its expansion, from eight on)."""
    if freedom < 8:
        return _STUDENT[freedom - 1]
    return 1.96 * (1 + (1.96**2 + 1) / (4 * freedom))


def named(arms: Sequence[tuple[Evidence, Arm]]) -> dict[str, Number]:
    """Return the numbers of arms by the names of their orders."""
    numbers: dict[str, Number] = {}
    for evidence, arm in arms:
        numbers[f"{arm.joints} reach"] = arm.reach
        numbers[f"{arm.joints} torque"] = arm.torque
        members = evidence.prefixes.get(arm.joints[:4])
        if members is not None:
            numbers[f"{members.prefix} trials ({evidence.n_joints} joints)"] = members.trials
    return numbers
