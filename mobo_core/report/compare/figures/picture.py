"""What a picture of a comparison is, and what all share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from matplotlib.figure import Figure as Canvas

from mobo_core.report.compare.comparison import Comparison

# Okabe and Ito's colours, which the colour-blind tell apart (jfly.uni-koeln.de/color), and a marker each.
_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")
_MARKERS = "os^DvPX*"
_DASHES = ("-", "--", ":", "-.")


@dataclass(frozen=True)
class ComparisonPicture:
    """A picture of a comparison.

    Attributes:
        name: of its files, ``NAME.png`` and ``NAME.svg``.
        heading: on the page.
        caption: below it.
        draw: returns it; None if there is nothing to show.
    """

    name: str
    heading: str
    caption: str
    draw: Callable[[Comparison], Canvas | None]


def style(i: int) -> tuple[str, str, str]:
    """Return colour, marker and dashes of the i-th study or group; they repeat together only after many."""
    return _COLOURS[i % len(_COLOURS)], _MARKERS[i % len(_MARKERS)], _DASHES[i // len(_COLOURS) % len(_DASHES)]
