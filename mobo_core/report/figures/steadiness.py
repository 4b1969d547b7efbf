"""The picture of what is beyond noise: how often each arm is on the front when voxels and poses are drawn anew."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from matplotlib.figure import Figure as Canvas

from mobo_core.bag.record import StudyRecord
from mobo_core.report.columns import Columns
from mobo_core.report.figures.drawing import plain
from mobo_core.report.figures.figure import Figure, Picture, View, script_beside
from mobo_core.report.table import StudyTable
from mobo_core.report.uncertainty import RESAMPLES, Steadiness, steadiness


def steadiness_figure(study: StudyRecord, table: StudyTable, found: list[Steadiness]) -> Canvas:
    """Return the arms near the front, the larger the more often they are on it; the front's own filled."""
    figure = Canvas(figsize=(9.6, 5.2), layout="constrained")
    axes = figure.add_subplot()
    axes.set_title(plain(f"{study.name}: on the front beyond noise"), loc="left", pad=12)
    axes.set(xlabel=f"reach [of {table.n_voxels} voxels]", ylabel="torque [N m, summed over voxels]")
    axes.grid(True)
    kinds = ((False, "#b0b6bc", "s", "near the front"), (True, "#0072b2", "o", "on the front"))
    for on_front, colour, marker, label in kinds:
        of = [one for one in found if one.row.on_front is on_front]
        axes.scatter(
            [one.row.reach for one in of], [one.row.torque for one in of], s=[4 + 130 * one.share for one in of],
            c=colour, marker=marker, alpha=0.75, linewidths=0.5, edgecolors="white", label=label,
        )  # fmt: skip
    axes.legend(loc="upper left", title=f"size: share of {RESAMPLES} resamples")
    return figure


def _draw(study: StudyRecord, table: StudyTable) -> Iterator[Picture]:
    found = steadiness(study, table)
    if found:
        yield Picture(steadiness_figure(study, table, found))


def _tables(study: StudyRecord, table: StudyTable) -> Mapping[str, Columns]:
    found = steadiness(study, table)
    return {
        "steadiness": {
            "trial": [one.row.trial for one in found],
            "joints": [one.row.joints for one in found],
            "reach": [one.row.reach for one in found],
            "torque": [one.row.torque for one in found],
            "on_front": [one.row.on_front for one in found],
            "share_of_resamples": [one.share for one in found],
        }
    }


def _data(study: StudyRecord, table: StudyTable) -> object:
    return {
        "resamples": RESAMPLES,
        "arms": [[one.row.trial, one.share, one.row.on_front] for one in steadiness(study, table)],
    }


FIGURE = Figure(
    name="steadiness",
    heading="Beyond noise",
    caption="Arms by how often they are on the front when voxels and poses are drawn anew (bootstrap); what the front "
    "shows once is not found yet.",
    draw=_draw,
    view=View(_data, script_beside(__file__)),
    tables=_tables,
)
