"""The stretched arm with its joints along it."""

from __future__ import annotations

import math
from functools import partial

from matplotlib.axes import Axes

from mobo_core.design.joints import JOINTS
from mobo_core.report.figures.drawing import FAINT, plain
from mobo_core.report.row import Row

_JOINT_WIDTH = 17.0  # points, of a joint's letter in its circle


def arm_line(axes: Axes, row: Row, width: float) -> None:
    """Draw the stretched arm with its joints along it; joints at (nearly) the same place side by side.

    Args:
        axes: to draw in.
        row: the arm.
        width: of the picture in points.
    """
    total = max(sum(row.lengths), 1e-9)
    step = _JOINT_WIDTH / (0.75 * width) * total
    places: list[tuple[float, str]] = []
    at = 0.0
    for joint, length in zip(row.joints, row.lengths, strict=False):
        if places and at - places[-1][0] < step * len(places[-1][1]):
            places[-1] = (places[-1][0], places[-1][1] + joint)
        else:
            places.append((at, joint))
        at += length
    axes.plot([0, total], [0, 0], color="#555555", linewidth=3.2, solid_capstyle="round", zorder=1)
    write = partial(axes.annotate, textcoords="offset points", va="center", fontsize=8, color="#555555")
    last, low = -math.inf, False
    for x, joints in places:
        first = min(x, total - step * (len(joints) - 1))
        for i, joint in enumerate(joints):
            colour = JOINTS[joint].colour if joint in JOINTS else FAINT
            axes.text(
                first + step * i, 0, plain(joint), ha="center", va="center", fontsize=9, fontweight="bold",
                color="white", zorder=3 + i,
                bbox={"boxstyle": "circle,pad=0.22", "facecolor": colour, "edgecolor": "white"},
            )  # fmt: skip
        low = x - last < 2 * step and not low
        write(f"{x:.3f}", (x, 0), xytext=(0, -28 if low else -17), ha="center")
        last = x
    write(f"{total:.3f} m", (total, 0), xytext=(16, 0), ha="left")
    axes.set(xlim=(-0.04 * total, 1.13 * total), ylim=(-1.9, 1))
    axes.set_axis_off()
