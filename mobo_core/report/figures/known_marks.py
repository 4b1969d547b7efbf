"""Real arms in a scatter of reach and torque: a diamond each, hollow if no source says its masses, and names."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from mobo_core.report.figures.drawing import INK, plain
from mobo_core.report.figures.labels import Label
from mobo_core.report.known import KnownArm

_SIZE, _LINE = 5.0, 1.1  # points
# Arms nearer to each other, as shares of the axes, have one label; it says no more than so many names.
_NEAR = (0.05, 0.04)
_MOST_NAMES = 2
_MOST_LABELS = 20
_PLACED = "#c4122f"


class Placed(NamedTuple):
    """An arm that is placed: what to call it, and its values."""

    name: str
    reach: float
    torque: float
    scaled: bool


def mark_known(axes: Axes, arms: Sequence[KnownArm]) -> list[Line2D]:
    """Draw the arms' marks, and return what the legend says of them; the limits of the axes stay."""
    handles = []
    for hollow, text in ((False, "real arm, as its twin"), (True, "likewise, masses unknown")):
        of = [arm for arm in arms if arm.estimated == hollow]
        if of:
            face = "white" if hollow else INK
            reach, torque = [arm.reach for arm in of], [arm.torque for arm in of]
            axes.scatter(
                reach, torque, s=_SIZE**2, marker="D", facecolors=face, edgecolors=INK, linewidths=_LINE, zorder=7
            )
            handles.append(
                Line2D(
                    [], [], linestyle="", marker="D", markersize=_SIZE, markerfacecolor=face, markeredgecolor=INK,
                    markeredgewidth=_LINE, label=f"{text}  ({sum(len(arm.names) for arm in of)})",
                )
            )  # fmt: skip
    return handles


def known_labels(axes: Axes, arms: Sequence[KnownArm]) -> list[Label]:
    """Return what is written at the marks: names of those that stand together, the first ones first."""
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    near = _NEAR[0] * (right - left), _NEAR[1] * (high - low)
    groups: list[list[KnownArm]] = []
    for arm in arms:
        for group in groups:
            if abs(arm.reach - group[0].reach) < near[0] and abs(arm.torque - group[0].torque) < near[1]:
                group.append(arm)
                break
        else:
            groups.append([arm])
    return [Label(group[0].reach, group[0].torque, _text(group)) for group in groups[:_MOST_LABELS]]


def _text(group: Sequence[KnownArm]) -> str:
    names = [name for arm in group for name in arm.names]
    more = f" +{len(names) - _MOST_NAMES}" if len(names) > _MOST_NAMES else ""
    return plain(", ".join(names[:_MOST_NAMES]) + more)


def mark_placed(axes: Axes, arms: Sequence[Placed]) -> list[Line2D]:
    """Draw the marks of placed arms: a star, hollow for a twin; return what the legend says of them."""
    handles = []
    for arm in arms:
        face = _PLACED if arm.scaled else "white"
        style: dict[str, Any] = {"facecolors": face, "edgecolors": _PLACED, "linewidths": _LINE, "zorder": 8}
        axes.scatter(arm.reach, arm.torque, s=11.0**2, marker="*", **style)
        handles.append(
            Line2D(
                [], [], linestyle="", marker="*", markersize=10.0, markerfacecolor=face, markeredgecolor=_PLACED,
                markeredgewidth=_LINE, label=plain(arm.name, 40),
            )
        )  # fmt: skip
    return handles


def placed_labels(arms: Sequence[Placed]) -> list[Label]:
    """Return what is written at the marks of placed arms."""
    return [Label(arm.reach, arm.torque, plain(arm.name, 40)) for arm in arms]
