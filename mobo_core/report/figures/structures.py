"""The picture of structures: the front of each prefix; on the page with tables, and the best arms side by side."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from matplotlib.figure import Figure as Canvas

from mobo_core.bag.record import StudyRecord
from mobo_core.report import structures
from mobo_core.report.columns import Columns
from mobo_core.report.figures.drawing import plain
from mobo_core.report.figures.figure import Figure, Picture, View, script_beside
from mobo_core.report.prefixes import styles
from mobo_core.report.structures import Structure
from mobo_core.report.table import StudyTable

_FAINT = "#b0b6bc"


def fronts_figure(study: StudyRecord, table: StudyTable, found: list[Structure]) -> Canvas:
    """Return the front of each prefix, reach against torque, as steps."""
    figure = Canvas(figsize=(9.6, 5.6), layout="constrained")
    axes = figure.add_subplot()
    axes.set_title(plain(f"{study.name}: the front of each prefix"), loc="left", pad=12)
    axes.set(xlabel=f"reach [of {table.n_voxels} voxels]", ylabel="least torque [N m, summed over voxels]")
    axes.grid(True)
    drawn = {style.prefix: style for style in styles(table)}
    for structure in reversed(found):
        steps = steps_of(structure, table)
        if not steps:
            continue
        reach, torque = zip(*steps, strict=True)
        style = drawn.get(structure.name)
        colour, width, label = (style.colour, 1.8, structure.name) if style else (_FAINT, 0.7, None)
        marker = style.marker if style else ""
        axes.plot(
            reach, torque, color=colour, linewidth=width, marker=marker, markersize=5, markeredgecolor="white",
            markeredgewidth=0.4, drawstyle="steps-pre", label=plain(label) if label else None, zorder=3 if style else 1,
        )  # fmt: skip
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        figure.legend(handles[::-1], labels[::-1], loc="outside right upper", title="first four joints")
    return figure


def steps_of(structure: Structure, table: StudyTable) -> list[tuple[float, float]]:
    """Return the structure's arms, above the reach floor, that no other one of it beats in reach and torque."""
    best: list[tuple[float, float]] = []
    for row in sorted((row for row in structure.rows if row.above_floor), key=lambda row: (-row.reach, row.torque)):
        if not best or row.torque < best[-1][1]:
            best.append((row.reach, row.torque))
    return best[::-1]


def _draw(study: StudyRecord, table: StudyTable) -> Iterator[Picture]:
    found = structures.prefixes(table)
    if found:
        yield Picture(fronts_figure(study, table, found))


def _tables(study: StudyRecord, table: StudyTable) -> Mapping[str, Columns]:
    return {
        "prefixes": structures.structure_columns(structures.prefixes(table), table),
        "orders": structures.structure_columns(structures.orders(table, study.settings), table),
    }


def _data(study: StudyRecord, table: StudyTable) -> object:
    total = max(len(table.useful_front), 1)

    def plain_data(structure: Structure) -> dict[str, object]:
        return {
            "name": structure.name,
            "arms": len(structure.rows),
            "best": structure.best.trial,
            "share": structure.on_front / total,
            "hypervolume": structure.hypervolume,
            "contribution": structure.contribution,
            "zero": structure.zero_lengths,
            "axes": structure.axes,
            "twin": structure.twin,
        }

    return {
        "prefixes": [plain_data(one) | {"steps": steps_of(one, table)} for one in structures.prefixes(table)],
        "orders": [plain_data(one) for one in structures.orders(table, study.settings)],
    }


FIGURE = Figure(
    name="structures",
    heading="Structures",
    caption="The front of each order of the first four joints: the least torque for a reach.",
    draw=_draw,
    svg=True,
    view=View(_data, script_beside(__file__)),
    tables=_tables,
)
