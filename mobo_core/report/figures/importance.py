"""The picture of parameter importance: which of the sampler's parameters matter for which objective."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from matplotlib.figure import Figure as Canvas

from mobo_core.bag.record import StudyRecord
from mobo_core.report.columns import Columns
from mobo_core.report.figures.drawing import plain
from mobo_core.report.figures.figure import Figure, Picture, View, script_beside
from mobo_core.report.importance import importances
from mobo_core.report.table import StudyTable

_COLOUR = "#0072b2"


def importance_figure(study: StudyRecord, found: Mapping[str, Mapping[str, float]]) -> Canvas:
    """Return bars, the most important parameter on top, side by side for each objective."""
    rows = max(len(values) for values in found.values())
    figure = Canvas(figsize=(9.6, 1.2 + 0.26 * rows), layout="constrained")
    figure.suptitle(plain(f"{study.name}: what matters"), x=0.012, ha="left", fontsize=11)
    for k, (name, values) in enumerate(found.items(), start=1):
        axes = figure.add_subplot(1, len(found), k)
        axes.barh(range(len(values)), list(values.values()), color=_COLOUR, height=0.7)
        axes.set_yticks(range(len(values)), [plain(parameter) for parameter in values])
        axes.set(title=plain(name.replace("_", " ")), ylim=(rows - 0.4, -0.6))
        axes.tick_params(axis="y", length=0)
    return figure


def _draw(study: StudyRecord, table: StudyTable) -> Iterator[Picture]:
    found = importances(study, table)
    if found:
        yield Picture(importance_figure(study, found))


def _tables(study: StudyRecord, table: StudyTable) -> Mapping[str, Columns]:
    cells = [(o, p, v) for o, values in importances(study, table).items() for p, v in values.items()]
    names = ("objective", "parameter", "importance")
    return {"importance": {name: [cell[i] for cell in cells] for i, name in enumerate(names)}}


FIGURE = Figure(
    name="importance",
    heading="What matters",
    caption="How far the best tenth of trials differs from all in each parameter the sampler draws: J1 to Jn are the "
    "joints, u or L the lengths (PED-ANOVA of Optuna).",
    draw=_draw,
    view=View(importances, script_beside(__file__)),
    tables=_tables,
)
