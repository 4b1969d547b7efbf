"""The report of one study as one HTML page with everything in it; nothing is loaded from elsewhere."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from html import escape

from mobo_core.bag.record import StudyRecord
from mobo_core.evaluation.objectives import OBJECTIVES
from mobo_core.evaluation.wording import further_asked, poses_text
from mobo_core.report import reproduce
from mobo_core.report.figures.render import Rendered
from mobo_core.report.joint_torques import HeldArm
from mobo_core.report.page import markup
from mobo_core.report.page.meta import elements
from mobo_core.report.page.tables import failed_section, front_table, prefix_table, torques_section
from mobo_core.report.prefixes import Group, found
from mobo_core.report.table import StudyTable

# In the order in which they are run; figures' own come before the last.
_LIBRARY = (
    "base", "study", "marks", "ticks", "brief", "known", "scatter_input", "scatter_axes", "scatter", "parallel", "urdf",
    "robot", "scene", "viewer", "voxels", "card", "chart", "tables",
)  # fmt: skip


def study_page(
    study: StudyRecord,
    table: StudyTable,
    groups: Sequence[Group],
    figures: Sequence[Rendered],
    arms: Sequence[HeldArm] = (),
    *,
    bag: str = "",
    files: Sequence[str] = (),
    orders: Sequence[str] = (),
) -> str:
    """Return the page of one study.

    Args:
        study: what it is of.
        table: its trials.
        groups: its arms by prefix.
        figures: what is shown, in the order of the page.
        arms: those evaluated again for the torques of their joints.
        bag: as commands name it.
        files: names of the files beside it.
        orders: HTML of the part on how well each order is known.
    """
    data, large = elements(study, table, arms, bag)
    views = [one for one in figures if one.figure.view is not None] if data else []
    body = [
        *_header(study, table),
        "<main>",
        '<div class="explorer">',
        '<div class="left">',
        *(_figure(one, bool(data)) for one in figures if not one.figure.heading),
        markup.section("front", "Pareto front", [front_table(table)], nav="Front"),
        "</div>",
        '<aside id="arm" aria-label="the chosen arm"></aside>' if data else "",
        "</div>",
        '<section id="pinned" data-nav="Pinned" tabindex="-1" hidden><h2>Side by side</h2>'
        '<p class="note" id="pinnote">Pin a second arm to compare.</p><div id="pins"></div></section>',
        *(_figure(one, bool(data)) for one in figures if one.figure.heading),
        markup.section("prefixes", "Best arm of each prefix", [prefix_table(found(groups), table), _PREFIX_NOTE]),
        *orders,
        *torques_section(arms, table.n_joints),
        *failed_section(table),
        *_provenance(study, table),
        markup.section("files", "Files", [_files(files)], nav="Files"),
        "</main>",
        *data,
        *(markup.data(f"data-{one.figure.name}", one.data) for one in views),
    ]
    own = "\n".join(markup.script(name) for name in _LIBRARY)
    scripts = [own, *(one.figure.view.script for one in views if one.figure.view is not None), markup.script("page")]
    return markup.html(f"{study.name}: report", [part for part in body if part], scripts, large)


_PREFIX_NOTE = (
    '<p class="note">A prefix is the order of the first four joints; named in bold by the paper this follows '
    "(Kawaharazuka et al., Advanced Robotics 2025).</p>"
)


def _header(study: StudyRecord, table: StudyTable) -> Iterator[str]:
    settings = study.settings
    space, spec = settings.space, settings.spec
    open_trials = len({int(candidate.trial) for candidate in study.candidates} - set(study.trials))
    reach = [row.reach for row in table.complete]
    cards = [
        (f"{len(table.complete):,}", "arms evaluated"),
        (f"{len(table.failed):,}", "failed"),
        (open_trials, "not finished"),
        (len(table.front), "on the front"),
        (f"{max(reach, default=0.0):.1f}", f"best reach of {table.n_voxels}"),
        (f"{table.hypervolume(len(table.rows)):.4f}", "hypervolume"),
    ]
    further = "".join(f", {escape(phrase)}" for phrase in further_asked(spec))
    yield "<header>"
    yield f'<div class="top"><h1>{escape(study.name)}</h1><button type="button" id="theme">Dark</button></div>'
    yield (
        f'<p class="sub">Robot arms of {space.n_joints} joints and {space.total_text} m, searched for '
        f"{escape(_wanted(settings.objectives))}: {escape(settings.sampler)}, seed {settings.seed}, "
        f"{poses_text(spec)}{further}.</p>"
    )
    for fault in study.faults:
        yield f'<p class="bad">{escape(fault)}: the report holds what could be read.</p>'
    yield '<ul class="cards">' + "".join(f"<li><b>{n}</b><span>{escape(t)}</span></li>" for n, t in cards) + "</ul>"
    yield '<nav id="nav" aria-label="parts of the report"></nav>'
    yield '<div id="said" role="status" aria-live="polite"></div>'
    yield "<noscript><p>Without scripts this page shows its tables, and its pictures in folds.</p></noscript>"
    yield "</header>"


def _figure(one: Rendered, has_data: bool) -> str:
    figure = one.figure
    pictures = [markup.figure(png, caption) for caption, png in one.shown]
    svg = [name for name in one.files if name.endswith(".svg")]
    links = "".join(f' <a href="{name}">{name}</a>' for name in svg)
    nav = figure.name.replace("_", " ").capitalize()
    below = f'<p class="note">Vector pictures:{links}</p>' if svg else ""
    if figure.view is None or not has_data:
        return markup.section(figure.name, figure.heading, [*pictures, below], nav=nav)
    note = f'<p class="note">{escape(figure.caption)}</p>' if figure.heading else ""
    fold = markup.fold("As a picture" if len(pictures) == 1 else "As pictures", [*pictures, below])
    return markup.section(figure.name, figure.heading, [note], nav=nav, view=figure.name).removesuffix("</section>") + (
        f'<div class="below">{fold}</div></section>'
    )


def _provenance(study: StudyRecord, table: StudyTable) -> Iterator[str]:
    again = reproduce.command(study.settings, len(table.rows))
    body = [
        "<p>The same study again, run in the folder of this report; its values are the same on every machine:</p>",
        f'<pre tabindex="0"><code>{escape(again)}</code></pre>',
    ]
    yield markup.section("provenance", "Provenance", body, nav="Provenance")
    settings = markup.settings({"study": study.name, **study.settings.to_dict()})
    yield markup.section("settings", "Settings", [markup.fold("All settings", [settings])])
    yield markup.section("versions", "Versions", [markup.settings(_json(study.record.get("versions", "{}")))])


def _files(files: Sequence[str]) -> str:
    kinds = {
        "Tables": (".csv", ".parquet"), "Pictures": (".svg",), "Settings": (".yaml",)
    }  # fmt: skip
    lines = []
    for kind, suffixes in kinds.items():
        names = [name for name in files if name.endswith(suffixes)]
        links = ", ".join(f'<a href="{escape(name)}">{escape(name)}</a>' for name in names)
        lines += [f"<p>{kind}: {links}.</p>"] if names else []
    if not any(name.endswith(".parquet") for name in files):
        lines.append('<p class="note">Tables as Parquet too: pip install pyarrow, and the report again.</p>')
    return "".join(lines)


def _wanted(objectives: Sequence[str]) -> str:
    """Return what a study wants, in words: ``high reach and low joint torque``."""
    words = []
    for name in objectives:
        high = name not in OBJECTIVES or OBJECTIVES[name].direction == "maximize"
        few = "few" if name == "axes" else "low"
        words.append(f"{'high' if high else few} {'joint torque' if name == 'torque' else name.replace('_', ' ')}")
    return " and ".join([", ".join(words[:-1]), words[-1]])


def _json(text: str) -> dict[str, object]:
    try:
        values = json.loads(text)
    except (ValueError, RecursionError):
        return {"": text}
    return values if isinstance(values, dict) else {"": text}
