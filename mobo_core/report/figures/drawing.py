"""What all pictures share: looks, colours, and turning a figure into bytes that are the same every time."""

from __future__ import annotations

import io
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Literal

import matplotlib
import numpy as np
from matplotlib.colors import Colormap, ListedColormap
from matplotlib.figure import Figure

_COMPRESSION = 3  # of 9
INK, FAINT, PAPER = "#222222", "#767676", "#ffffff"


@contextmanager
def looks() -> Iterator[None]:
    """Draw what is drawn inside in the looks of the report, whatever the user's matplotlibrc says."""
    with matplotlib.rc_context(), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing")  # names in scripts that the font lacks
        matplotlib.rcdefaults()
        _set_looks()
        yield


def _set_looks() -> None:
    matplotlib.rc("font", family="DejaVu Sans", size=10)
    matplotlib.rc("axes", titlesize=11, labelsize=10.5, labelcolor=INK, edgecolor="#888888", linewidth=0.8)
    matplotlib.rc("axes", axisbelow=True)
    matplotlib.rc("axes.spines", top=False, right=False)
    matplotlib.rc("grid", color="#e6e6e6", linewidth=0.8)
    matplotlib.rc("legend", frameon=False)
    matplotlib.rc("text", color=INK)
    matplotlib.rc("xtick", color="#555555")
    matplotlib.rc("ytick", color="#555555")
    matplotlib.rc("svg", fonttype="path", hashsalt="mobo")
    matplotlib.rc("figure", facecolor=PAPER)
    matplotlib.rc("savefig", facecolor=PAPER)


def plain(text: str, longest: int = 90) -> str:
    """Return text that is drawn as it is, no part of it read as mathematics; a long one is cut."""
    return (text if len(text) <= longest else text[: longest - 1] + "…").replace("$", r"\$")


def picture(figure: Figure, kind: Literal["png", "svg"], dpi: int = 160) -> bytes:
    """Return a figure as a file's bytes; the same figure gives the same bytes. Call inside :func:`looks`."""
    out = io.BytesIO()
    metadata = dict.fromkeys(("Date", "Creator") if kind == "svg" else ("Software",))
    # A quarter of the time for a tenth more bytes.
    more: dict[str, Any] = {"pil_kwargs": {"compress_level": _COMPRESSION}} if kind == "png" else {}
    figure.savefig(out, format=kind, dpi=dpi, metadata=metadata, **more)
    figure.set_layout_engine("none")  # the next kind is laid out alike
    return out.getvalue()


def red_to_green() -> Colormap:
    """Return the paper's gradation from red to green, over amber.

    Mixed in linear light, with lightness rising all along, so that it can be read without telling red from green.
    """
    stops = np.array([[0.74, 0.015, 0.03], [0.84, 0.42, 0.05], [0.15, 0.80, 0.20]])  # linear light
    share = np.linspace(0.0, 1.0, 256)
    light = np.stack([np.interp(share, (0.0, 0.5, 1.0), channel) for channel in stops.T], axis=1)
    srgb = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    return ListedColormap([tuple(map(float, row)) for row in srgb], name="mobo_red_to_green")


def has_dark_text(colour: tuple[float, ...]) -> bool:
    """Return whether dark text reads better than white on a colour (sRGB, each 0 to 1)."""
    red, green, blue = (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in colour[:3])
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue > 0.22
