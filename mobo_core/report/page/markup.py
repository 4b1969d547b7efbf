"""The few pieces of HTML that the report is made of; all text is escaped here."""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping, Sequence
from functools import cache
from html import escape
from importlib.resources import files

from mobo_core.version import __version__

# All of a page is in it; 'unsafe-eval' is for tools that drive a browser.
_POLICY = (
    "default-src 'none'; img-src data: blob:; style-src 'unsafe-inline'; script-src 'unsafe-inline' 'unsafe-eval'; "
    "base-uri 'none'; form-action 'none'"
)
_STYLES = ("page", "explorer", "arm", "figures", "small")  # later rules win
GENERATOR = '<meta name="generator" content="mobo '


def html(title: str, body: Sequence[str], scripts: Sequence[str] = (), behind: Sequence[str] = ()) -> str:
    """Return a page that may load nothing.

    Args:
        title: plain text.
        body: HTML.
        scripts: JavaScript.
        behind: HTML that comes after the scripts have begun.
    """
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta name="color-scheme" content="light dark">\n'
        f'{GENERATOR}{escape(__version__)}">\n'
        f"<title>{escape(title)}</title>\n<style>{_style()}</style>\n</head>\n<body>\n"
        + "\n".join(body)
        + "".join(f"\n<script>{script}</script>" for script in scripts)
        + "".join(f"\n{part}" for part in behind)
        + "\n</body>\n</html>\n"
    )


@cache
def _style() -> str:
    return "".join((files(__package__) / "styles" / f"{name}.css").read_text(encoding="utf-8") for name in _STYLES)


@cache
def script(name: str) -> str:
    """Return one of the page's own scripts."""
    return (files(__package__) / "scripts" / f"{name}.js").read_text(encoding="utf-8")


def data(name: str, value: object) -> str:
    """Return plain data as an element that scripts read; no text in it can end the element."""
    text = json.dumps(value, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c").replace("&", "\\u0026")
    return f'<script type="application/json" id="{escape(name)}">{text}</script>'


def section(name: str, heading: str, body: Sequence[str], nav: str = "", view: str = "") -> str:
    """Return a part of the page with its heading, plain text; ``nav`` names it in the list of parts."""
    marks = f' data-nav="{escape(nav)}" tabindex="-1"' if nav else ""
    marks += f' data-view="{escape(view)}"' if view else ""
    title = f"<h2>{escape(heading)}</h2>" if heading else ""
    return f'<section id="{escape(name)}"{marks}>{title}' + "\n".join(body) + "</section>"


def fold(summary: str, body: Sequence[str]) -> str:
    """Return what is shown once it is asked for."""
    return f"<details><summary>{escape(summary)}</summary>" + "\n".join(body) + "</details>"


def figure(png: bytes, caption: str) -> str:
    """Return a picture, held in the page, with its caption."""
    text = base64.b64encode(png).decode("ascii")
    return (
        f'<figure><img loading="lazy" src="data:image/png;base64,{text}" alt="{escape(caption)}">'
        f"<figcaption>{escape(caption)}</figcaption></figure>"
    )


def table(
    head: Sequence[str],
    rows: Sequence[Sequence[str]],
    *,
    right: Sequence[int] = (),
    wrap: Sequence[int] = (),
    classes: Sequence[str] = (),
    trial: int | None = None,
) -> str:
    """Return a table of plain text.

    Args:
        head: of the columns.
        rows: of cells.
        right: columns of numbers.
        wrap: columns whose text may be broken into lines.
        classes: CSS classes of the rows.
        trial: the column of numbers of trials, of which the page's scripts make buttons.
    """
    kinds = ["n" if i in right else "wrap" if i in wrap else "" for i in range(len(head))]
    lines = ["<tr>" + "".join(f'<th class="{k}">{escape(t)}</th>' for k, t in zip(kinds, head, strict=True)) + "</tr>"]
    for i, row in enumerate(rows):
        names = [f' data-trial="{escape(text)}"' if k == trial else "" for k, text in enumerate(row)]
        cells = "".join(f'<td class="{k}"{n}>{escape(t)}</td>' for k, n, t in zip(kinds, names, row, strict=True))
        lines.append(f'<tr class="{classes[i] if classes else ""}">{cells}</tr>')
    focus = "" if trial is not None else ' tabindex="0"'  # so that keys can scroll it where it is too wide
    return f'<div class="wide"{focus}><table>{"".join(lines)}</table></div>'


def settings(values: Mapping[str, object]) -> str:
    """Return nested values as a table of dotted names."""
    flat: list[list[str]] = []

    def walk(values: Mapping[str, object], prefix: str) -> None:
        for name, value in values.items():
            if isinstance(value, Mapping):
                walk(value, f"{prefix}{name}.")
            else:
                flat.append([prefix + name, str(value)])

    walk(values, "")
    return table(["name", "value"], flat, wrap=(1,))
