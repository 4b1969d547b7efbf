"""Hypervolume over the trials."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure as Canvas

from mobo_core.report.compare.comparison import Comparison
from mobo_core.report.compare.figures.picture import ComparisonPicture, style
from mobo_core.report.figures.drawing import plain


def _draw(comparison: Comparison) -> Canvas | None:
    groups = [group for group in comparison.groups if group.members[0].volumes]
    if not groups:
        return None
    figure = Canvas(figsize=(9.6, 4.4), layout="constrained")
    axes = figure.add_subplot()
    axes.set(xlabel="trials told", ylabel="hypervolume [share of the box]")
    axes.grid(True, axis="y")
    for i, group in enumerate(groups):
        colour, marker, dashes = style(i)
        n = len(group.members[0].table.rows)
        x = np.linspace(0, n, 51)
        values = np.array([[0.0, *one.volumes] for one in group.members])
        axes.plot(x, values.mean(axis=0), color=colour, linestyle=dashes, marker=marker, markevery=10, markersize=5,
                  linewidth=1.8, label=plain(group.label))  # fmt: skip
        if len(values) > 1:
            axes.fill_between(x, values.min(axis=0), values.max(axis=0), color=colour, alpha=0.15, linewidth=0)
    axes.legend(loc="lower right")
    return figure


PICTURE = ComparisonPicture(
    "progress",
    "Progress",
    "Share of the box between (reach 0, torque 10 N m a voxel) and (full reach, no torque) that is dominated; of "
    "several seeds the mean, and the band from the least to the most.",
    _draw,
)
