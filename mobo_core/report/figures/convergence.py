"""The picture of a study's progress: hypervolume over trials."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from matplotlib.figure import Figure as Canvas

from mobo_core.bag.record import StudyRecord
from mobo_core.report.columns import Columns
from mobo_core.report.figures.drawing import FAINT, plain
from mobo_core.report.figures.figure import Figure, Picture, View, script_beside
from mobo_core.report.table import StudyTable, running_hypervolume

_LINE = "#0072b2"


def hypervolume_figure(table: StudyTable, n_startup_trials: int, title: str) -> Canvas:
    """Return the hypervolume of the trials told so far, failed ones counted, at about a hundred points."""
    figure = Canvas(figsize=(9.6, 4.0), layout="constrained")
    axes = figure.add_subplot()
    axes.set_title(plain(title), loc="left", pad=12)
    axes.set_xlabel("trials told")
    axes.set_ylabel("hypervolume [share of the box]")
    axes.grid(True, axis="y")
    counts, volumes = running_hypervolume(table)
    n = max(len(table.rows), 1)
    axes.set_xlim(0, n)
    if volumes:
        axes.plot([0, *counts], [0.0, *volumes], color=_LINE, linewidth=1.8, drawstyle="steps-post")
        axes.fill_between([0, *counts], [0.0, *volumes], step="post", color=_LINE, alpha=0.10, linewidth=0)
        axes.annotate(
            f"{volumes[-1]:.4f}", (counts[-1], volumes[-1]), xytext=(-4, 6), textcoords="offset points",
            ha="right", color=_LINE, fontweight="bold",
        )  # fmt: skip
        axes.set_ylim(0, 1.14 * volumes[-1] if volumes[-1] > 0 else 1.0)
    else:
        axes.text(0.5, 0.5, "no trial told", transform=axes.transAxes, ha="center", color=FAINT)
    startup = min(n_startup_trials, n)
    axes.axvspan(0, startup, color="#f1f1f1", zorder=0)
    axes.text(
        0.5 * startup, 0.03, "drawn at random" if startup > 0.15 * n else "random",
        transform=axes.get_xaxis_transform(), ha="center", color=FAINT, fontsize=9,
    )  # fmt: skip
    return figure


def _draw(study: StudyRecord, table: StudyTable) -> Iterator[Picture]:
    title = f"{study.name}: hypervolume of the front"
    usual = study.settings.objectives == ("reach", "torque")
    caption = "" if usual else f"Share of the box of {', '.join(study.settings.objectives)} that is dominated."
    yield Picture(hypervolume_figure(table, study.settings.n_startup_trials, title), caption=caption)


def _data(study: StudyRecord, table: StudyTable) -> object:
    counts, volumes = running_hypervolume(table)
    return {"counts": counts, "volumes": volumes, "startup": study.settings.n_startup_trials}


def _tables(study: StudyRecord, table: StudyTable) -> Mapping[str, Columns]:
    counts, volumes = running_hypervolume(table)
    return {"hypervolume": {"trials": list(counts), "hypervolume": list(volumes)}}


FIGURE = Figure(
    name="hypervolume",
    heading="Progress",
    caption="Share of the box between (reach 0, torque 10 N m a voxel) and (full reach, no torque) that is dominated.",
    draw=_draw,
    view=View(_data, script_beside(__file__)),
    tables=_tables,
)
