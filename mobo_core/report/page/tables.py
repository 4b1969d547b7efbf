"""The tables of the page that stand in it as text."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape

from mobo_core.report.joint_torques import MOST_ARMS, HeldArm, torque_rows
from mobo_core.report.lengths import lengths_text
from mobo_core.report.page import markup
from mobo_core.report.page.palette import page_style
from mobo_core.report.prefixes import Group, styles
from mobo_core.report.row import Row
from mobo_core.report.table import StudyTable

_MOST_FAILED = 50
_MOST_OPEN = 40  # rows that a table shows before it is asked for
_NUMBERS = (0, 1, 2, 4, 5)  # columns of the table of prefixes


def front_table(table: StudyTable) -> str:
    """Return the raw Pareto front by falling reach, what is below the reach floor in grey."""
    if not table.front:
        return "<p>No complete trial yet.</p>"
    useful = len(table.useful_front)
    further = list(table.further.values())
    head = ["trial", "joints", f"reach of {table.n_voxels}", "torque [N m]", *further, "lengths [m]", "known as"]
    rows = []
    for row in table.front:
        *values, lengths = _cells(row)
        rows.append([*values, *(f"{value:.4g}" for _, value in row.extra), lengths, ", ".join(row.known_as)])
    numbers = (0, *range(2, 4 + len(further)))
    classes = ["" if i < useful else "low line" if i == useful and useful else "low" for i in range(len(rows))]
    note = (
        f'<p class="note">An arm that reaches nothing takes no torque, so the raw front runs down to zero reach. '
        f"Grey: below the reach floor of a tenth of the voxels ({table.floor:g}). Lengths are rounded so that they "
        "still add up, and <code>mobo evaluate --joints … --lengths …</code> takes them as they stand; "
        "<code>mobo evaluate BAG --trial N</code> evaluates the very arm.</p>"
    )
    return markup.table(head, rows, right=numbers, classes=classes, trial=0) + note


def torques_section(arms: Sequence[HeldArm], n_joints: int) -> Iterator[str]:
    """Yield the part on what the joints of the arms evaluated again hold; nothing if there are none."""
    if not arms:
        return
    yield '<section id="torques" data-nav="Torques" tabindex="-1"><h2>Torque per joint</h2>'
    head = ["trial", "joints", "a reached voxel [N m]", *(f"joint {i + 1}" for i in range(n_joints))]
    rows = [(row + ["-"] * n_joints)[: len(head)] for row in torque_rows(arms)]
    table = markup.table(head, rows, right=(0, *range(2, len(head))), trial=0)
    yield markup.fold(f"{len(arms)} arms", [table]) if len(arms) > _MOST_OPEN else table
    others = sum(not arm.same for arm in arms)
    differ = f" Of {others} of them, reach or torque is not what was recorded." if others else ""
    yield (
        '<p class="note">Mean / 95 % / peak in N m, over the configurations at which the arm reaches a pose, of what '
        "each joint, from the base up, holds against gravity. These arms (the front, then the best of other orders, "
        f"up to {MOST_ARMS}, above the reach floor) were evaluated again for this page.{differ}</p></section>"
    )


def _cells(row: Row) -> list[str]:
    return [
        str(row.trial),
        row.joints,
        f"{row.reach:.2f}",
        f"{row.torque:.1f}",
        lengths_text(row.lengths),
    ]


def prefix_table(groups: Sequence[Group], table: StudyTable) -> str:
    """Return the arm of the highest reach of each prefix."""
    colours = {style.prefix: page_style(style)["colour"] for style in styles(table)}
    lines = []
    for group in groups:
        best = group.best
        if best is None:
            continue
        colour = colours.get(group.prefix, "#9aa0a6")
        name = f"<b>{escape(group.prefix)}</b>" if group.in_paper else escape(group.prefix)
        cells = [str(len(group.rows)), str(group.n_on_front), *_cells(best)]
        marks = [" class=n" if i in _NUMBERS else "" for i in range(len(cells))]
        marks[2] += f" data-trial={best.trial}"
        lines.append(
            f'<tr><td><span class="key" style="background:{colour}"></span>{name}</td>'
            + "".join(f"<td{mark}>{escape(cell)}</td>" for mark, cell in zip(marks, cells, strict=True))
            + "</tr>"
        )
    head = ("arms", "on the front", "best: trial", "joints", "reach", "torque [N m]", "lengths [m]")
    titles = "<th>prefix</th>" + "".join(
        f"<th{' class=n' if i in _NUMBERS else ''}>{title}</th>" for i, title in enumerate(head)
    )
    return f'<div class="wide tall" tabindex="0"><table><tr>{titles}</tr>{"".join(lines)}</table></div>'


def failed_section(table: StudyTable) -> Iterator[str]:
    """Yield the part on the trials that failed, the first of them; nothing if none did."""
    if not table.failed:
        return
    rows = [[str(row.trial), row.joints, row.reason] for row in table.failed[:_MOST_FAILED]]
    body = [markup.table(["trial", "joints", "reason"], rows, right=(0,), wrap=(2,))]
    if len(table.failed) > _MOST_FAILED:
        body.append(f"<p>and {len(table.failed) - _MOST_FAILED} more, see trials.csv</p>")
    yield markup.section("failed", "Failed trials", body, nav="Failed")
