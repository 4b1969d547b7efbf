"""The page that leads to the reports of several studies."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from mobo_core.bag.record import StudyRecord
from mobo_core.report.page import markup
from mobo_core.report.table import StudyTable


def index_page(links: Iterable[tuple[str, StudyRecord, StudyTable]], sections: Sequence[str] = ()) -> str:
    """Return the page that leads to the pages of several studies, each in a folder of its own; ``sections`` follow."""
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
    title = "<header><h1>Reports</h1></header>"
    return markup.html("Reports", [title, "<main>", f"<section>{body}</section>", *sections, "</main>"])
