"""A picture of many small parts, drawn as a few large ones: axes of matplotlib's own would take ten times as long."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure as Canvas
from matplotlib.font_manager import FontProperties
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.textpath import TextPath
from matplotlib.transforms import Affine2D
from numpy.typing import ArrayLike

from mobo_core.report.figures.drawing import INK

Colour = str | tuple[float, ...]
_SIDES = {"left": 0.0, "center": 0.5, "right": 1.0}


class Sheet:
    """A canvas to draw on in inches, from its lower left corner."""

    def __init__(self, width: float, height: float) -> None:
        self.canvas = Canvas(figsize=(width, height))
        self.axes = self.canvas.add_axes((0.0, 0.0, 1.0, 1.0))
        self.axes.set(xlim=(0, width), ylim=(0, height))
        self.axes.set_axis_off()
        self._texts: dict[Colour, list[Path]] = defaultdict(list)

    def polygons(self, corners: ArrayLike, colours: Sequence[Colour], edge: Colour = "none", width: float = 0) -> None:
        """Draw polygons, (polygons, corners, 2), each in its colour; ``width`` of the edges in points."""
        array: Any = np.asarray(corners)
        made = PolyCollection(array, facecolors=colours, edgecolors=edge, linewidths=width)
        self.axes.add_collection(made, autolim=False)

    def lines(self, ends: ArrayLike, colour: Colour, width: float) -> None:
        """Draw lines, (lines, 2 ends, 2); ``width`` in points."""
        array: Any = np.asarray(ends)
        self.axes.add_collection(LineCollection(array, colors=colour, linewidths=width), autolim=False)

    def text(
        self, x: float, y: float, text: str, size: float, colour: Colour = INK, side: str = "center", turned: float = 0
    ) -> None:
        """Write a line of text whose middle height is at y, and whose ``side`` is at x.

        Args:
            x: inches.
            y: inches.
            text: as it is, no mathematics.
            size: points.
            colour: of the text.
            side: ``left``, ``center`` or ``right``.
            turned: degrees, about (x, y).
        """
        path, right = _written(text, size)
        move = Affine2D().translate(-_SIDES[side] * right, 0.0).rotate_deg(turned).translate(x, y)
        self._texts[colour].append(move.transform_path(path))

    def done(self) -> Canvas:
        """Return the canvas, with all texts on top."""
        for colour, paths in self._texts.items():
            whole = Path.make_compound_path(*paths)
            # As an artist: a patch would have the axes look for the limits of each curve.
            self.axes.add_artist(PathPatch(whole, facecolor=colour, linewidth=0, zorder=8))
        self._texts.clear()
        return self.canvas


@lru_cache(4096)
def _written(text: str, size: float) -> tuple[Path, float]:
    """Return the outline of a text, in inches from its left end at the middle of its digits' height; and its width."""
    font = FontProperties(family="DejaVu Sans")
    path = TextPath((0, 0), text, size=size / 72, prop=font, usetex=False)
    right = float(path.vertices[:, 0].max()) if len(path.vertices) else 0.0
    return Affine2D().translate(0.0, -0.365 * size / 72).transform_path(path), right
