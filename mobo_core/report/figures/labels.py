"""Labels of points in a scatter, placed where they hide least."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox
from numpy.typing import NDArray

from mobo_core.report.figures.drawing import INK

_DISTANCES = (24, 40, 60, 85, 115, 150)  # points, from the labelled point to the label's middle
_DIRECTIONS = 24


class Label(NamedTuple):
    """A text for the point (x, y), in data units."""

    x: float
    y: float
    text: str


def place_labels(
    figure: Figure, axes: Axes, labels: Sequence[Label], points: Sequence[tuple[float, float, float]]
) -> None:
    """Write labels near their points: inside the axes, off each other, over as few of ``points`` as can be.

    The limits of the axes must be final.

    Args:
        figure: the figure.
        axes: those of the scatter.
        labels: what to write.
        points: x, y (data units) and how much it matters not to hide it.
    """
    canvas = FigureCanvasAgg(figure)
    figure.draw_without_rendering()  # for the layout, which stays as it is then
    figure.set_layout_engine("none")
    scale = figure.dpi / 72
    frame = axes.get_window_extent()
    table = np.asarray(points, float).reshape(-1, 3)
    dots = np.column_stack([axes.transData.transform(table[:, :2]), table[:, 2]])
    taken: list[Bbox] = []
    for label in sorted(labels, key=lambda label: -label.x):
        text = axes.annotate(
            label.text,
            (label.x, label.y),
            xytext=(0, 0),
            textcoords="offset points",
            ha="center",
            va="center",
            fontsize=8.5,
            color=INK,
            linespacing=1.15,
            zorder=9,
            bbox={"boxstyle": "round,pad=0.25", "facecolor": "white", "edgecolor": "#bbbbbb", "alpha": 0.9},
            arrowprops={"arrowstyle": "-", "color": INK, "linewidth": 0.8, "shrinkA": 0, "shrinkB": 4},
        )
        text.set_in_layout(False)
        size = text.get_window_extent(canvas.get_renderer())
        at = axes.transData.transform((label.x, label.y))
        best, best_cost = (0.0, 0.0), math.inf
        for distance in _DISTANCES:
            for step in range(_DIRECTIONS):
                angle = 2 * math.pi * step / _DIRECTIONS
                # Labels are wider than high: what is beside a point has to stand further off.
                offset = (math.cos(angle) * (distance + size.width / scale / 3), math.sin(angle) * distance)
                x, y = at[0] + offset[0] * scale, at[1] + offset[1] * scale
                box = Bbox.from_bounds(x - size.width / 2, y - size.height / 2, size.width, size.height).padded(14)
                cost = _cost(box, frame, dots, taken) + 0.02 * distance
                if cost < best_cost:
                    best, best_cost, chosen = offset, cost, box
        text.set_position(best)
        taken.append(chosen)


def _cost(box: Bbox, frame: Bbox, dots: NDArray[np.float64], taken: Sequence[Bbox]) -> float:
    hidden = (dots[:, 0] > box.x0) & (dots[:, 0] < box.x1) & (dots[:, 1] > box.y0) & (dots[:, 1] < box.y1)
    outside = box.x0 < frame.x0 or box.x1 > frame.x1 or box.y0 < frame.y0 or box.y1 > frame.y1
    overlaps = sum(bool(box.overlaps(other)) for other in taken)
    return float(dots[hidden, 2].sum()) + 1000.0 * bool(outside) + 300.0 * overlaps
