"""Checked claims as tables: for a terminal, for files, for pages."""

from __future__ import annotations

from collections.abc import Sequence

from rich.table import Table
from rich.text import Text

from mobo_core.report.claims.verdict import INCONCLUSIVE, NOT_REPRODUCED, REPRODUCED, Checked, Outcome, Part
from mobo_core.report.columns import Cell, Columns

MARKS = {REPRODUCED: "✓", NOT_REPRODUCED: "✗", INCONCLUSIVE: "?"}
_STYLES = {REPRODUCED: "green", NOT_REPRODUCED: "red", INCONCLUSIVE: "yellow"}

HEAD = ("claim", "what the paper says", "verdict", "margin", "95 %")


def claims_table(checked: Sequence[Checked], *, parts: bool = False) -> Table:
    """Return a row a claim, or with ``parts`` one for each statement of it too."""
    fair = any(one.fair is not None for one in checked)
    out = Table(box=None, pad_edge=False, header_style="bold", padding=(0, 2, 0, 0))
    for heading in (*HEAD, *(("fair", "margin", "95 %") if fair else ())):
        out.add_column(heading, justify="right" if heading in ("margin", "95 %") else "left",
                       no_wrap=heading != HEAD[1], overflow="fold")  # fmt: skip
    for one in checked:
        cells = [Text(one.claim), Text(one.text), *_cells(one.outcome)]
        out.add_row(*cells, *(_cells(one.fair) if fair else ()), style="bold" if parts else "")
        for part in one.outcome.parts if parts else ():
            out.add_row(Text(""), Text(f"  {statement(part)}"), *_part_cells(part), *([""] * 3 if fair else []))
    return out


def _cells(outcome: Outcome | None) -> list[Text]:
    if outcome is None:
        return [Text("-"), Text(""), Text("")]
    part = outcome.deciding
    return [_marked(outcome.verdict), *_numbers(part)]


def _part_cells(part: Part) -> list[Text]:
    return [_marked(part.verdict), *_numbers(part)]


def _marked(verdict: str) -> Text:
    return Text(f"{MARKS[verdict]} {verdict}", style=_STYLES[verdict])


def _numbers(part: Part | None) -> list[Text]:
    return [Text(margin_text(part)), Text(interval_text(part))]


def margin_text(part: Part | None) -> str:
    """Return a margin for people."""
    return "-" if part is None or part.margin is None else f"{part.margin:+.3f}"


def interval_text(part: Part | None) -> str:
    """Return an interval for people."""
    return "" if part is None or part.interval is None else f"{part.interval[0]:+.3f} … {part.interval[1]:+.3f}"


def statement(part: Part) -> str:
    """Return what a part says, and what was too little searched for it."""
    return part.name + (f" (hardly searched: {', '.join(part.unsure)})" if part.unsure else "")


def why(one: Checked) -> str:
    """Return the statement that decides a claim, with its numbers."""
    part = one.outcome.deciding
    if part is None:
        return ""
    return f"{statement(part)}{': ' if part.numbers else ''}{numbers_text(part)}"


def numbers_text(part: Part) -> str:
    """Return a part's numbers for people."""
    return ", ".join(f"{name} {_number(value)}" for name, value in part.numbers.items() if value not in ("", None))


def _number(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def claim_columns(checked: Sequence[Checked]) -> Columns:
    """Return a row for each statement of each claim."""
    lines: list[dict[str, Cell]] = []
    for one in checked:
        for kind, outcome in (("study", one.outcome), ("fair", one.fair)):
            for part in outcome.parts if outcome is not None else ():
                low, high = part.interval or (None, None)
                lines.append({
                    "claim": one.claim, "text": one.text, "of": kind,
                    "claim_verdict": outcome.verdict if outcome is not None else None, "statement": part.name,
                    "verdict": part.verdict, "margin": part.margin, "low": low, "high": high,
                    "numbers": numbers_text(part), "hardly_searched": " ".join(part.unsure),
                })  # fmt: skip
    return {name: [line[name] for line in lines] for name in (lines[0] if lines else ())}
