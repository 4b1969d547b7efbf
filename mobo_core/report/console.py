"""The tables of the report for a terminal."""

from __future__ import annotations

from rich.box import Box
from rich.cells import cell_len
from rich.console import Console
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from mobo_core.errors import visible
from mobo_core.report.lengths import lengths_text
from mobo_core.report.prefixes import Group
from mobo_core.report.row import Row
from mobo_core.report.table import StudyTable

# A line below the headings, and one at the end of a section.
_LINES = Box("    \n    \n ── \n    \n ── \n    \n    \n    \n")

_FOLDS = "known as"


def console_for(*tables: Table) -> Console:
    """Return a console in which no number of the tables is broken over lines: all of a row on one if it is no terminal.

    A terminal's lines are folded between numbers, by itself if it is narrower than one of them.
    """
    console = Console(highlight=False)
    for column in (column for table in tables for column in table.columns if column.header != _FOLDS):
        column.min_width = max(map(cell_len, map(str, column.cells)))
    wide = console.options.update(max_width=10_000)
    sizes = [Measurement.get(console, wide, table) for table in tables]
    needed = max(size.minimum if console.is_terminal else size.maximum for size in sizes)
    return Console(width=max(console.width, needed), highlight=False)


def front_table(table: StudyTable) -> Table:
    """Return the raw Pareto front by falling reach, a line drawn at the reach floor."""
    out = Table(
        title="Pareto front: the highest reach for the least torque",
        title_justify="left",
        title_style="bold",
        box=_LINES,
        pad_edge=False,
    )
    for heading in ("trial", "joints", f"reach of {table.n_voxels}", "torque N m"):
        out.add_column(heading, justify="left" if heading == "joints" else "right")
    for heading in table.further.values():
        out.add_column(heading.replace("[", "").replace("]", ""), justify="right")
    for heading in ("lengths m", _FOLDS):
        out.add_column(heading)
    useful = table.useful_front
    for row in useful:
        out.add_row(*_cells(row), end_section=row is useful[-1])
    for row in table.front[len(useful) :]:
        out.add_row(*_cells(row), style="dim")
    if len(useful) < len(table.front):
        out.caption = f"below the line: less than a tenth of the voxels ({table.floor:g}) reached"
        out.caption_justify = "left"
    return out


def prefix_table(groups: list[Group], n_voxels: int) -> Table:
    """Return the best arm of each prefix; those that the paper names come first, in bold."""
    out = Table(
        title="The highest reach of each order of the first four joints",
        title_justify="left",
        title_style="bold",
        box=_LINES,
        pad_edge=False,
    )
    for heading in ("prefix", "arms", "on front", "trial", "joints", f"reach of {n_voxels}", "torque N m", "lengths m"):
        out.add_column(heading, justify="left" if heading in ("prefix", "joints", "lengths m") else "right")
    for i, group in enumerate(groups):
        prefix = Text(visible(group.prefix), style="bold" if group.in_paper else "")
        last_named = group.in_paper and (i + 1 == len(groups) or not groups[i + 1].in_paper)
        best = group.best
        cells = [*_cells(best)[:4], _cells(best)[-2]] if best is not None else [Text("-")] * 5
        out.add_row(prefix, str(len(group.rows)), str(group.n_on_front), *cells, end_section=last_named)
    return out


def _cells(row: Row) -> list[Text]:
    lengths = lengths_text(row.lengths)
    further = [f"{value:.4g}" for _, value in row.extra]
    known = ", ".join(row.known_as)
    values = (str(row.trial), row.joints, f"{row.reach:.2f}", f"{row.torque:.1f}", *further, lengths, known)
    return [Text(visible(value)) for value in values]
