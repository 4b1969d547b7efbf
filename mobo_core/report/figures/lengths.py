"""The picture of lengths: where the joints of the best arms of each prefix sit along the arm."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from matplotlib.figure import Figure as Canvas

from mobo_core.bag.record import StudyRecord
from mobo_core.report import positions
from mobo_core.report.columns import Columns
from mobo_core.report.figures.drawing import FAINT, plain
from mobo_core.report.figures.figure import Figure, Picture, View, script_beside
from mobo_core.report.prefixes import styles
from mobo_core.report.table import StudyTable


def lengths_figure(study: StudyRecord, table: StudyTable, found: list[positions.Positions]) -> Canvas:
    """Return a line for each prefix, from base to tool, with the joints of its best arms on it."""
    figure = Canvas(figsize=(9.6, 1.4 + 0.62 * len(found)), layout="constrained")
    axes = figure.add_subplot()
    axes.set_title(plain(f"{study.name}: where the joints of the best arms sit"), loc="left", pad=12)
    axes.set_xlabel("along the arm [share of its length]")
    colours = {style.prefix: style.colour for style in styles(table)}
    for line, of in enumerate(reversed(found)):
        axes.plot([0, 1], [line, line], color="#dddddd", linewidth=3, solid_capstyle="round", zorder=1)
        spread = np.linspace(-0.22, 0.22, len(of.rows))
        for joint in range(of.places.shape[1]):
            axes.scatter(of.places[:, joint], line + spread, s=9, color=colours[of.prefix], alpha=0.6, linewidths=0)
            middle = float(np.median(of.places[:, joint]))
            axes.plot([middle, middle], [line - 0.3, line + 0.3], color="#222222", linewidth=1.2)
        text, count = of.groups[0]
        axes.text(1.02, line, f"{text}  ({count} of {len(of.rows)})", va="center", fontsize=9, color=FAINT)
    axes.set(xlim=(-0.03, 1.22), ylim=(-0.6, len(found) - 0.4))
    axes.set_yticks(range(len(found)), [plain(of.prefix) for of in reversed(found)])
    axes.set_xticks([0, 0.25, 0.5, 0.75, 1.0])
    axes.tick_params(axis="y", length=0)
    return figure


def _draw(study: StudyRecord, table: StudyTable) -> Iterator[Picture]:
    found = positions.positions(table)
    if found:
        yield Picture(lengths_figure(study, table, found))


def _tables(study: StudyRecord, table: StudyTable) -> Mapping[str, Columns]:
    return {"lengths": positions.position_columns(positions.positions(table))}


def _data(study: StudyRecord, table: StudyTable) -> object:
    return {
        "prefixes": [
            {
                "prefix": of.prefix,
                "trials": [row.trial for row in of.rows],
                "places": of.places.tolist(),
                "groups": of.groups,
            }
            for of in positions.positions(table)
        ],
        "clusters": [
            {"shares": cluster.shares, "trials": [row.trial for row in cluster.rows]}
            for cluster in positions.clusters(table)
        ],
    }


FIGURE = Figure(
    name="lengths",
    heading="Lengths",
    caption="Where the joints sit along the best twentieth of each prefix's arms, five at least; bars mark medians.",
    draw=_draw,
    view=View(_data, script_beside(__file__)),
    tables=_tables,
)
