"""A comparison as files: pictures, tables, and a page that shows them."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from pathlib import Path

from mobo_core.outputs import make_folder, write_whole
from mobo_core.report.compare.comparison import Comparison
from mobo_core.report.compare.figures.registry import PICTURES
from mobo_core.report.compare.tables import difference_columns, structure_columns, study_columns
from mobo_core.report.figures.drawing import looks, picture
from mobo_core.report.page import markup
from mobo_core.report.table_files import to_csv

PAGE = "index.html"


def write_comparison(
    comparison: Comparison, folder: Path, progress: Callable[[int, int], None] = lambda done, total: None
) -> Path:
    """Write a comparison into a folder, made if it is not there; return the page's path.

    Raises:
        InputError: a file cannot be written.
    """
    make_folder(folder)
    files: dict[str, bytes | str] = {}
    sections = []
    for done, one in enumerate(PICTURES):
        progress(done, len(PICTURES))
        with looks():
            canvas = one.draw(comparison)
            if canvas is None:
                continue
            files |= {f"{one.name}.png": picture(canvas, "png"), f"{one.name}.svg": picture(canvas, "svg")}
        png = files[f"{one.name}.png"]
        assert isinstance(png, bytes)
        links = f'<p class="note"><a href="{one.name}.svg">{one.name}.svg</a></p>'
        sections.append(markup.section(one.name, one.heading, [markup.figure(png, one.caption), links]))
    progress(len(PICTURES), len(PICTURES))
    tables = {
        "studies": study_columns(comparison),
        "differences": difference_columns(comparison),
        "prefixes": structure_columns(comparison),
    }
    files |= {f"{name}.csv": to_csv(columns) for name, columns in tables.items()}
    files[PAGE] = _page(comparison, sections)
    for name, content in files.items():
        write_whole(folder / name, content)
    return folder / PAGE


def _page(comparison: Comparison, pictures: list[str]) -> str:
    body = ["<header><h1>Studies side by side</h1>"]
    body += [f'<p class="bad">{escape(line)}.</p>' for line in comparison.warnings]
    body += ["</header>", "<main>"]
    for name, heading, columns in (
        ("studies", "Studies", study_columns(comparison)),
        ("differences", "Settings that differ", difference_columns(comparison)),
    ):
        body.append(markup.section(name, heading, [_table(columns)]))
    body += pictures
    body.append(markup.section("prefixes", "Best arm of each prefix", [_table(structure_columns(comparison))]))
    files = ", ".join(f'<a href="{name}.csv">{name}.csv</a>' for name in ("studies", "differences", "prefixes"))
    return markup.html("Comparison", [*body, f"<section><p>Tables: {files}.</p></section>", "</main>"])


def _table(columns: dict[str, list[str | int | float | bool | None]]) -> str:
    if not columns or not next(iter(columns.values())):
        return "<p>None.</p>"
    rows = [[_text(value) for value in values] for values in zip(*columns.values(), strict=True)]
    numbers = [i for i, values in enumerate(columns.values()) if all(isinstance(v, int | float | None) for v in values)]
    return markup.table(list(columns), rows, right=numbers)


def _text(value: object) -> str:
    return "" if value is None else f"{value:.4g}" if isinstance(value, float) else str(value)
