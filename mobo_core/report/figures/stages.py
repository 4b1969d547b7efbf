"""The picture of time: per stage of a trial, and how the evaluators shared the work."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from matplotlib.figure import Figure as Canvas

from mobo_core.bag.record import StudyRecord
from mobo_core.report.columns import Columns
from mobo_core.report.figures.drawing import INK, plain
from mobo_core.report.figures.figure import Figure, Picture, View, script_beside
from mobo_core.report.stages import STAGES, Stages, shares, stages
from mobo_core.report.table import StudyTable

_COLOURS = {"ask": "#e69f00", "evaluate": "#0072b2", "wait": "#b3bac1", "record": "#009e73"}


def stages_figure(study: StudyRecord, found: Stages) -> Canvas:
    """Return the median time of each stage as bars."""
    figure = Canvas(figsize=(9.6, 2.8), layout="constrained")
    axes = figure.add_subplot()
    axes.set_title(plain(f"{study.name}: time of a trial, by stage"), loc="left", pad=12)
    names = [name for name in STAGES if name in found.median]
    values = [1e3 * found.median[name] for name in names]
    axes.barh(names, values, color=[_COLOURS[name] for name in names], height=0.7)
    for i, value in enumerate(values):
        axes.text(value, i, f"  {value:.3g} ms", va="center", color=INK, fontsize=9)
    axes.set(xlabel="median [ms]", xlim=(0, 1.15 * max([*values, 1e-3])))
    axes.invert_yaxis()
    axes.tick_params(axis="y", length=0)
    return figure


def _draw(study: StudyRecord, table: StudyTable) -> Iterator[Picture]:
    found = stages(study)
    if found.median:
        yield Picture(stages_figure(study, found))


def _tables(study: StudyRecord, table: StudyTable) -> Mapping[str, Columns]:
    found = stages(study)
    names = list(found.median)
    return {
        "stages": {
            "stage": list(names),
            "trials": [found.trials[name] for name in names],
            "median_seconds": [found.median[name] for name in names],
            "total_seconds": [found.total[name] for name in names],
        }
    }


def _data(study: StudyRecord, table: StudyTable) -> object:
    found = stages(study)
    return {
        "stages": [
            {"name": name, "meaning": STAGES[name], "median": found.median[name], "total": found.total[name],
             "trials": found.trials[name], "colour": _COLOURS[name]}
            for name in found.median
        ],
        # Their names tell hosts: not here.
        "shares": [count for _, count in shares([row.evaluator for row in table.complete])],
    }  # fmt: skip


FIGURE = Figure(
    name="stages",
    heading="Time",
    caption="The median time of each stage of a trial; stages of several trials run side by side.",
    draw=_draw,
    view=View(_data, script_beside(__file__)),
    tables=_tables,
)
