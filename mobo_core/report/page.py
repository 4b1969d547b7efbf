"""The report as one HTML page with everything in it: no script, nothing loaded from elsewhere."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from html import escape

from mobo_core.bag.record import StudyRecord
from mobo_core.evaluation.objectives import OBJECTIVES
from mobo_core.report import markup
from mobo_core.report.figures.render import Rendered
from mobo_core.report.joint_torques import MOST_ARMS, HeldArm, torque_rows
from mobo_core.report.lengths import lengths_text
from mobo_core.report.prefixes import PAPER_COLOURS, Group, found
from mobo_core.report.row import Row
from mobo_core.report.table import StudyTable

TABLES = ("front.csv", "trials.csv", "joint_torques.csv")
_MOST_FAILED = 50


def study_page(
    study: StudyRecord,
    table: StudyTable,
    groups: Sequence[Group],
    figures: Sequence[Rendered],
    arms: Sequence[HeldArm] = (),
) -> str:
    """Return the page of one study.

    Args:
        study: what it is of.
        table: its trials.
        groups: its arms by prefix.
        figures: what is shown, in the order of the page.
        arms: those evaluated again for the torques of their joints.
    """
    settings = study.settings
    space, spec = settings.space, settings.spec
    open_trials = len({int(candidate.trial) for candidate in study.candidates} - set(study.trials))
    reach = [row.reach for row in table.complete]
    cards = [
        (len(table.complete), "arms evaluated"),
        (len(table.failed), "failed"),
        (open_trials, "not finished"),
        (len(table.front), "on the front"),
        (f"{max(reach, default=0.0):.1f}", f"best reach of {table.n_voxels}"),
        (f"{table.hypervolume(len(table.rows)):.4f}", "hypervolume"),
    ]
    body = [
        f"<h1>{escape(study.name)}</h1>",
        f'<p class="sub">Robot arms of {space.n_joints} joints and {space.total_text} m, searched for '
        f"{escape(_wanted(settings.objectives))}: {escape(settings.sampler)}, seed {settings.seed}, "
        f"{spec.n_voxels} voxels of {spec.voxel_size:g} m, {spec.poses_per_voxel} poses each.</p>",
        *[f'<p class="bad">{escape(fault)}: the report holds what could be read.</p>' for fault in study.faults],
        '<ul class="cards">' + "".join(f"<li><b>{n}</b><span>{escape(t)}</span></li>" for n, t in cards) + "</ul>",
        *_figures(rendered for rendered in figures if not rendered.figure.heading),
        "<h2>Pareto front</h2>",
        _front(table),
        "<h2>Best arm of each prefix</h2>",
        _prefixes(found(groups), table.n_joints),
        '<p class="note">A prefix is the order of the first four joints; named in bold by the paper this follows '
        "(Kawaharazuka et al., Advanced Robotics 2025).</p>",
        *_joint_torques(arms, table.n_joints),
        *_figures(rendered for rendered in figures if rendered.figure.heading),
    ]
    if table.failed:
        rows = [[str(row.trial), row.joints, row.reason] for row in table.failed[:_MOST_FAILED]]
        body.append("<h2>Failed trials</h2>")
        body.append(markup.table(["trial", "joints", "reason"], rows, right=(0,), wrap=(2,)))
        if len(table.failed) > _MOST_FAILED:
            body.append(f"<p>and {len(table.failed) - _MOST_FAILED} more, see trials.csv</p>")
    body += ["<h2>Settings</h2>", markup.settings({"study": study.name, **settings.to_dict()})]
    body += ["<h2>Versions</h2>", markup.settings(_json(study.record.get("versions", "{}")))]
    body += ["<h2>Files</h2>", _files(figures)]
    return markup.html(f"{study.name}: report", body)


def _figures(figures: Iterable[Rendered]) -> Iterator[str]:
    for rendered in figures:
        if rendered.figure.heading:
            yield f"<h2>{escape(rendered.figure.heading)}</h2>"
        for caption, png in rendered.shown:
            yield markup.figure(png, caption)


def _files(figures: Iterable[Rendered]) -> str:
    vector = [name for rendered in figures for name in rendered.files if name.endswith(".svg")]
    links = [", ".join(f'<a href="{name}">{name}</a>' for name in names) for names in (TABLES, vector)]
    pictures = f" Picture{'s' if len(vector) > 1 else ''}: {links[1]}." if vector else ""
    return f"<p>Tables: {links[0]}.{pictures}</p>"


def index_page(links: Iterable[tuple[str, StudyRecord, StudyTable]]) -> str:
    """Return the page that leads to the pages of several studies, each in a folder of its own."""
    head = ("study", "joints", "trials", "on the front", "best reach")
    lines = [f"<tr>{''.join(f'<th>{title}</th>' for title in head)}</tr>"]
    for folder, study, table in links:
        best = max((row.reach for row in table.complete), default=0.0)
        cells = (
            str(table.n_joints),
            str(len(table.rows)),
            str(len(table.front)),
            f"{best:.2f} of {table.n_voxels}",
        )
        link = f'<a href="{escape(folder)}/index.html">{escape(study.name)}</a>'
        lines.append(f"<tr><td>{link}</td>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>")
    body = f'<div class="wide"><table>{"".join(lines)}</table></div>'
    return markup.html("Reports", ["<h1>Reports</h1>", body])


def _wanted(objectives: Sequence[str]) -> str:
    """Return what a study wants, in words: ``high reach and low joint torque``."""
    words = []
    for name in objectives:
        high = name not in OBJECTIVES or OBJECTIVES[name].direction == "maximize"
        words.append(f"{'high' if high else 'low'} {'joint torque' if name == 'torque' else name.replace('_', ' ')}")
    return " and ".join([", ".join(words[:-1]), words[-1]])


def _front(table: StudyTable) -> str:
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
    return markup.table(head, rows, right=numbers, classes=classes) + note


def _joint_torques(arms: Sequence[HeldArm], n_joints: int) -> Iterator[str]:
    if not arms:
        return
    yield "<h2>Torque per joint</h2>"
    head = ["trial", "joints", "a reached voxel [N m]", *(f"joint {i + 1}" for i in range(n_joints))]
    rows = [(row + ["-"] * n_joints)[: len(head)] for row in torque_rows(arms)]
    yield markup.table(head, rows, right=(0, *range(2, len(head))))
    others = sum(not arm.same for arm in arms)
    differ = f" Of {others} of them, reach or torque is not what was recorded." if others else ""
    yield (
        '<p class="note">Mean / 95 % / peak in N m, over the configurations at which the arm reaches a pose, of what '
        "each joint, from the base up, holds against gravity. These arms (the front, then the best of other orders, "
        f"up to {MOST_ARMS}, above the reach floor) were evaluated again for this page.{differ}</p>"
    )


def _cells(row: Row) -> list[str]:
    return [
        str(row.trial),
        row.joints,
        f"{row.reach:.2f}",
        f"{row.torque:.1f}",
        lengths_text(row.lengths),
    ]


def _prefixes(groups: Sequence[Group], n_joints: int) -> str:
    colours = PAPER_COLOURS.get(n_joints, {})
    lines = []
    for group in groups:
        best = group.best
        if best is None:
            continue
        colour = colours[group.prefix][0] if group.in_paper else "#cfcfcf"
        name = f"<b>{escape(group.prefix)}</b>" if group.in_paper else escape(group.prefix)
        cells = [str(len(group.rows)), str(group.n_on_front), *_cells(best)]
        numbers = (0, 1, 2, 4, 5)
        lines.append(
            f'<tr><td><span class="key" style="background:{colour}"></span>{name}</td>'
            + "".join(f"<td{' class=n' if i in numbers else ''}>{escape(cell)}</td>" for i, cell in enumerate(cells))
            + "</tr>"
        )
    head = ("arms", "on the front", "best: trial", "joints", "reach", "torque [N m]", "lengths [m]")
    titles = "<th>prefix</th>" + "".join(
        f"<th{' class=n' if i in (0, 1, 2, 4, 5) else ''}>{title}</th>" for i, title in enumerate(head)
    )
    return f'<div class="wide"><table><tr>{titles}</tr>{"".join(lines)}</table></div>'


def _json(text: str) -> dict[str, object]:
    try:
        values = json.loads(text)
    except ValueError:
        return {"": text}
    return values if isinstance(values, dict) else {"": text}
