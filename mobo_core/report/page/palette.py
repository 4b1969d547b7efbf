"""The page's colours of prefixes: the paper's by hue, in shades that the colour-blind can tell."""

from __future__ import annotations

from mobo_core.report.prefixes import Style

# Of Okabe and Ito (2008), the nearest to each of the paper's; on light and on dark paper.
_SHADES = {
    "#ff00ff": ("#cc79a7", "#dd95bd"),
    "#ff0000": ("#d55e00", "#e87a35"),
    "#0000ff": ("#0072b2", "#3f9fdc"),
    "#00ffff": ("#56b4e9", "#7cc7f0"),
    "#008000": ("#009e73", "#22bd93"),
    "#ff8000": ("#e69f00", "#f0b030"),
    "#00ff00": ("#b8aa00", "#f0e442"),
}


def page_style(style: Style) -> dict[str, str]:
    """Return how the page draws a prefix: its colour on light and on ``dark`` paper, and its marker."""
    light, dark = _SHADES.get(style.colour, (style.colour, style.colour))
    return {"prefix": style.prefix, "colour": light, "dark": dark, "marker": style.marker}
