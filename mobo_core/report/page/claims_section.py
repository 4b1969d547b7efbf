"""The part of a page on the paper's claims, without scripts."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from mobo_core.report.claims.show import MARKS, interval_text, margin_text, numbers_text, statement
from mobo_core.report.claims.verdict import Checked
from mobo_core.report.figures.claims import claims_figure
from mobo_core.report.figures.drawing import looks, picture
from mobo_core.report.page import markup

_CAPTION = "Margins with 95 % intervals, above 0 where a claim holds; what was hardly searched is inconclusive."


def claims_section(checked: Sequence[Checked], apart: Sequence[str] = ()) -> str:
    """Return checked claims as a picture and a table.

    Args:
        checked: what to show.
        apart: in what the two studies differ, so that values of one are not compared with the other's.
    """
    with looks():
        png = picture(claims_figure(checked), "png")
    rows, classes = [], []
    for one in checked:
        part = one.outcome.deciding
        rows.append([one.claim, one.text, _marked(one.outcome.verdict), margin_text(part), interval_text(part), ""])
        classes.append("")
        for part in one.outcome.parts:
            cells = ["", statement(part), _marked(part.verdict), margin_text(part), interval_text(part)]
            rows.append([*cells, numbers_text(part)])
            classes.append("low")
    head = ["claim", "what the paper says", "verdict", "margin", "95 %", "numbers"]
    table = markup.table(head, rows, right=(3, 4), wrap=(1, 5), classes=classes)
    warned = [f'<p class="bad">Values of the two studies do not compare: {escape(line)}.</p>' for line in apart]
    note = (
        '<p class="note">The others evaluate arms: <code>mobo claims BAG6 BAG7</code> checks all, with an atlas also '
        "what the structures themselves can do.</p>"
    )
    return markup.section("claims", "The paper's claims", [*warned, markup.figure(png, _CAPTION), table, note])


def _marked(verdict: str) -> str:
    return f"{MARKS[verdict]} {verdict}"
