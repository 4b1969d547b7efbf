"""The few pieces of HTML that the report is made of; all text is escaped here."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from html import escape

from mobo_core.version import __version__

GENERATOR = '<meta name="generator" content="mobo '

_STYLE = """
:root { color-scheme: light; }
body { font: 15px/1.5 system-ui, sans-serif; color: #222; background: #fff; max-width: 1080px; margin: 2rem auto;
  padding: 0 1.2rem; }
h1 { font-size: 1.6rem; margin: 0 0 .2rem; } h2 { font-size: 1.2rem; margin: 2.4rem 0 .6rem; }
p.sub, figcaption, .note { color: #666; } p.sub { margin-top: 0; }
.cards { display: flex; flex-wrap: wrap; gap: .7rem; margin: 1.2rem 0; padding: 0; list-style: none; }
.cards li { border: 1px solid #ddd; border-radius: 6px; padding: .5rem .9rem; min-width: 6.5rem; }
.cards b { display: block; font-size: 1.35rem; font-weight: 600; font-variant-numeric: tabular-nums; }
.cards span { color: #666; font-size: .85rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .9rem; font-variant-numeric: tabular-nums; }
th, td { padding: .25rem .8rem .25rem 0; text-align: left; vertical-align: top; border-bottom: 1px solid #eee;
  white-space: nowrap; }
th { color: #666; font-weight: 500; border-bottom-color: #bbb; } td.n, th.n { text-align: right; }
td.wrap { white-space: normal; overflow-wrap: anywhere; }
tr.low td { color: #888; } tr.line td { border-top: 2px solid #bbb; } code { font-size: .92em; }
figure { margin: 1rem 0; } img { max-width: 100%; height: auto; }
.key { display: inline-block; width: .8em; height: .8em; border-radius: 50%; margin-right: .45em; }
.bad { color: #a40000; }
"""


def html(title: str, body: Sequence[str]) -> str:
    """Return a page; ``title`` is plain text, ``body`` HTML."""
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f'{GENERATOR}{escape(__version__)}">\n'
        f"<title>{escape(title)}</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n"
        + "\n".join(body)
        + "\n</body>\n</html>\n"
    )


def figure(png: bytes, caption: str) -> str:
    """Return a picture, held in the page, with its caption."""
    data = base64.b64encode(png).decode("ascii")
    return (
        f'<figure><img src="data:image/png;base64,{data}" alt="{escape(caption)}">'
        f"<figcaption>{escape(caption)}</figcaption></figure>"
    )


def table(
    head: Sequence[str],
    rows: Sequence[Sequence[str]],
    *,
    right: Sequence[int] = (),
    wrap: Sequence[int] = (),
    classes: Sequence[str] = (),
) -> str:
    """Return a table of plain text.

    Args:
        head: of the columns.
        rows: of cells.
        right: columns of numbers.
        wrap: columns whose text may be broken into lines.
        classes: CSS classes of the rows.
    """
    kinds = ["n" if i in right else "wrap" if i in wrap else "" for i in range(len(head))]
    lines = ["<tr>" + "".join(f'<th class="{k}">{escape(t)}</th>' for k, t in zip(kinds, head, strict=True)) + "</tr>"]
    for i, row in enumerate(rows):
        cells = "".join(f'<td class="{k}">{escape(t)}</td>' for k, t in zip(kinds, row, strict=True))
        lines.append(f'<tr class="{classes[i] if classes else ""}">{cells}</tr>')
    return f'<div class="wide"><table>{"".join(lines)}</table></div>'


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
