"""Best reach of each prefix in each study."""

from __future__ import annotations

import math

from matplotlib.figure import Figure as Canvas

from mobo_core.report.compare.comparison import Comparison
from mobo_core.report.compare.figures.picture import ComparisonPicture, style
from mobo_core.report.figures.drawing import plain


def _draw(comparison: Comparison) -> Canvas | None:
    prefixes = comparison.prefixes
    if not prefixes:
        return None
    figure = Canvas(figsize=(9.6, 1.6 + 0.34 * len(prefixes)), layout="constrained")
    axes = figure.add_subplot()
    shares = len({one.settings.spec.n_voxels for one in comparison.studies}) > 1
    axes.set(xlabel="best reach [share of the voxels]" if shares else "best reach [voxels]")
    axes.set_yticks(range(len(prefixes)), [plain(prefix) for prefix in prefixes])
    axes.invert_yaxis()
    axes.grid(True)
    for i, group in enumerate(comparison.groups):
        colour, marker, _ = style(i)
        axes.plot([], [], marker, color=colour, label=plain(group.label))
    axes.plot([], [], "o", color="#767676", markerfacecolor="white", label="hardly searched")
    group_of = {one.label: i for i, group in enumerate(comparison.groups) for one in group.members}
    for k, one in enumerate(comparison.studies):
        i = group_of[one.label]
        colour, marker, _ = style(i)
        n = one.settings.spec.n_voxels if shares else 1
        for place, prefix in enumerate(prefixes):
            of = one.prefixes.get(prefix)
            if of is None:
                continue
            at = place + 0.5 * ((k + 0.5) / len(comparison.studies) - 0.5)
            half = of.half / n if math.isfinite(of.half) else 0.0
            axes.errorbar(of.row.reach / n, at, xerr=half, fmt=marker, color=colour, markersize=6, elinewidth=1,
                          markerfacecolor=colour if of.known else "white")  # fmt: skip
    figure.legend(loc="outside upper left", ncols=3, fontsize=9)
    return figure


PICTURE = ComparisonPicture(
    "structures",
    "Structures",
    "The highest reach of each order of the first four joints, with the 95 % interval of drawing other poses. Hollow: "
    "hardly searched, which says something of the search and nothing of the structure.",
    _draw,
)
