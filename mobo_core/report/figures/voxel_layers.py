"""Pictures of one arm's voxels: reach and torque, a square for each layer of the workspace."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from matplotlib.colors import Colormap, Normalize
from matplotlib.figure import Figure as Canvas
from matplotlib.patches import Circle, Rectangle
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike, NDArray

from mobo_core.evaluation.colours import REACH_SCALE, TORQUE_SCALE
from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.report.figures.arm_line import arm_line
from mobo_core.report.figures.drawing import FAINT, INK, has_dark_text, plain, red_to_green
from mobo_core.report.figures.sheet import Colour, Sheet
from mobo_core.report.row import Row

# The ends of the paper's colour scales.
REACH_ENDS = (REACH_SCALE.red, REACH_SCALE.green)
TORQUE_ENDS = (TORQUE_SCALE.green, TORQUE_SCALE.red)  # N m
_MOST_NUMBERS = 8  # voxels along a side, up to which each shows its value
_MOST_HATCHED = 1000  # voxels in a layer
_HATCHES = 3  # lines, and gaps between them, along a voxel's side
_MOST_LAYERS = 12
_SIDE, _APART = 2.1, 2.25  # inches: a layer's longer side, and from one layer to the next
_LEFT, _RIGHT, _BELOW, _ABOVE = 0.75, 1.05, 0.9, 1.62  # inches around the layers
_NUMBERS = "#555555"

Array = NDArray[np.float64]


class OfVoxels(Protocol):
    """What is drawn of an evaluation: one value a voxel."""

    @property
    def voxel_reach(self) -> ArrayLike:
        """Share of the poses reached."""

    @property
    def voxel_torque(self) -> ArrayLike:
        """Mean torque, N m."""


@dataclass(frozen=True)
class Panel:
    """Where a layer lies on the sheet.

    Attributes:
        name: ``reach`` or ``torque``.
        layer: from below.
        column: of the sheet, from the left.
        corner: inches, the lower left one.
        scale: inches a metre.
        low, high: m, the workspace's ends in x and y.
    """

    name: str
    layer: int
    column: int
    corner: tuple[float, float]
    scale: float
    low: tuple[float, float]
    high: tuple[float, float]

    def at(self, x: ArrayLike, y: ArrayLike) -> Array:
        """Return where a place of the workspace lies on the sheet, inches; the last axis is x, y."""
        return np.stack(np.broadcast_arrays(x, y), axis=-1) * self.scale + self._shift

    @property
    def _shift(self) -> Array:
        return np.array(self.corner) - np.array(self.low) * self.scale

    @property
    def size(self) -> tuple[float, float]:
        """Width and height, inches."""
        return (self.high[0] - self.low[0]) * self.scale, (self.high[1] - self.low[1]) * self.scale


def panels(spec: EvaluationSpec) -> tuple[list[Panel], float, float]:
    """Return where the layers of a workspace are drawn, and the sheet's width and height, inches.

    Above reach, below torque, layers from low to high; of more than twelve layers, twelve, evenly chosen.
    """
    nz = spec.shape[2]
    layers = sorted({round(i) for i in np.linspace(0, nz - 1, min(nz, _MOST_LAYERS))})
    columns, bands = _grid(len(layers))
    width, height = _APART * columns + _LEFT + _RIGHT - 0.15, 2 * (_APART + 0.1) * bands + _BELOW + _ABOVE - 0.2
    low, high = spec.workspace_min[:2], spec.workspace_max[:2]
    scale = _SIDE / max(high[0] - low[0], high[1] - low[1])
    found = []
    for i, layer in enumerate(layers):
        for place, name in enumerate(("reach", "torque")):
            line = 2 * (i // columns) + place
            corner = (_LEFT + _APART * (i % columns), height - _ABOVE - (_APART + 0.1) * line - _SIDE)
            found.append(Panel(name, layer, i % columns, corner, scale, (low[0], low[1]), (high[0], high[1])))
    return found, width, height


def _grid(nz: int) -> tuple[int, int]:
    """Return columns and bands (a band is a line of reach above one of torque) for so many layers."""
    columns = min(nz, 6) if nz <= 6 else math.ceil(nz / math.ceil(nz / 6))
    return columns, math.ceil(nz / columns)


def voxel_figure(row: Row, evaluation: OfVoxels, spec: EvaluationSpec, title: str) -> Canvas:
    """Return the maps of an arm, placed as :func:`panels` says.

    Args:
        row: the arm.
        evaluation: its Evaluation message.
        spec: the workspace.
        title: of the picture.
    """
    found, width, height = panels(spec)
    reach = np.asarray(evaluation.voxel_reach, float).reshape(spec.shape)
    torque = np.asarray(evaluation.voxel_torque, float).reshape(spec.shape)
    sheet = Sheet(width, height)
    sheet.canvas.text(0.15 / width, 1 - 0.12 / height, plain(title), ha="left", va="top", fontsize=12)
    below = "hatched: no pose reached;  dashed: as far as the stretched arm goes at this height"
    sheet.text(0.5 * width, 0.16, below, 8.5, FAINT)
    line = sheet.canvas.add_axes((0.15 / width, 1 - 1.25 / height, 1 - 0.3 / width, 0.8 / height))
    arm_line(line, row, 72 * width)
    maps = {
        "reach": (reach, Normalize(*REACH_ENDS), red_to_green()),
        "torque": (np.where(reach > 0, torque, np.nan), Normalize(*TORQUE_ENDS), red_to_green().reversed()),
    }
    last = max(panel.column for panel in found)
    for panel in found:
        values, norm, colours = maps[panel.name]
        _layer(sheet, panel, values[:, :, panel.layer], norm, colours.with_extremes(bad="#ececec"))
        _limit_of_arm(sheet, panel, sum(row.lengths), _middle(spec, 2, panel.layer))
        _frame(sheet, panel)
        if panel.name == "reach":
            at = panel.at(0.5 * (panel.low[0] + panel.high[0]), panel.high[1])
            sheet.text(at[0], at[1] + 0.15, _number(_middle(spec, 2, panel.layer), 2, "z = ", " m"), 11)
        if panel.column == last:
            _scale(sheet, width - _RIGHT + 0.12, panel, norm, colours)
    return sheet.done()


def _middle(spec: EvaluationSpec, axis: int, i: int) -> float:
    return spec.workspace_min[axis] + (i + 0.5) * spec.voxel_size + 0.0


def _number(value: float, decimals: int, before: str = "", after: str = "") -> str:
    return f"{before}{value + 0.0:.{decimals}f}{after}".replace("-", "\u2212")


def _layer(sheet: Sheet, panel: Panel, values: Array, norm: Normalize, colours: Colormap) -> None:
    """Draw one layer; ``values`` has the shape (nx, ny), NaN where no pose was reached."""
    nx, ny = values.shape
    x, y = np.linspace(panel.low[0], panel.high[0], nx + 1), np.linspace(panel.low[1], panel.high[1], ny + 1)
    i, j = (index.ravel() for index in np.indices(values.shape))
    corners = np.stack([panel.at(x[i + a], y[j + b]) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))], axis=1)
    many = nx * ny > _MOST_HATCHED
    shown = colours(norm(np.ma.masked_invalid(values.ravel())))
    sheet.polygons(corners, shown, "face" if many else "white", 0.1 if many else 1.0)
    empty = ~np.isfinite(values) | ((values == 0) if panel.name == "reach" else False)
    if not many and empty.any():
        _hatch(sheet, corners[empty.ravel()], "#b9b9b9" if panel.name == "torque" else "#ffffff80")
    if max(nx, ny) <= _MOST_NUMBERS:
        for k in np.flatnonzero(~empty.ravel()):
            value, at = values[i[k], j[k]], corners[k].mean(axis=0)
            ink: Colour = INK if has_dark_text(tuple(shown[k])) else "white"
            sheet.text(at[0], at[1], _number(value, 2 if panel.name == "reach" else 1), 8.5, ink)


def _hatch(sheet: Sheet, corners: Array, colour: str) -> None:
    """Draw slanted lines over voxels, (voxels, 4 corners, 2), cut off where a voxel ends."""
    shift = np.arange(1 - _HATCHES, _HATCHES) / _HATCHES  # of a voxel: where y = x + shift
    first = np.stack([np.maximum(0, -shift), np.maximum(0, shift)], axis=1)
    last = np.stack([np.minimum(1, 1 - shift), np.minimum(1, 1 + shift)], axis=1)
    ends = np.stack([first, last], axis=1)  # (lines, 2 ends, 2), in a voxel of side 1
    origin, size = corners[:, None, None, 0], (corners[:, 2] - corners[:, 0])[:, None, None]
    sheet.lines((origin + size * ends[None]).reshape(-1, 2, 2), colour, 1.0)


def _limit_of_arm(sheet: Sheet, panel: Panel, length: float, z: float) -> None:
    """Draw how far the stretched arm goes at this height."""
    if abs(z) < length:
        radius = math.sqrt(length**2 - z**2) * panel.scale
        centre = tuple(panel.at(0.0, 0.0).tolist())
        circle = Circle(centre, radius, fill=False, linestyle=(0, (4, 3)), edgecolor=INK, alpha=0.7, zorder=3)
        within = Rectangle(panel.corner, *panel.size, transform=sheet.axes.transData)
        sheet.axes.add_artist(circle).set_clip_path(within)


def _frame(sheet: Sheet, panel: Panel) -> None:
    """Write numbers along the sides of a layer, and the axes' names."""
    (x, y), (width, height) = panel.corner, panel.size
    ticks: list[list[tuple[float, float]]] = []
    for axis in (0, 1):
        locator = MaxNLocator(nbins=5, steps=[1, 2, 4, 10])
        places = np.asarray(locator.tick_values(panel.low[axis], panel.high[axis]), float)
        places = places[(places > panel.low[axis] - 1e-9) & (places < panel.high[axis] + 1e-9)]
        apart = places[1] - places[0] if len(places) > 1 else 1.0
        decimals = max(0, -math.floor(math.log10(apart) + 1e-9))
        for place in places.tolist():
            at = panel.at(place, place)
            if axis == 0:
                ticks.append([(at[0], y), (at[0], y - 0.05)])
                if panel.name == "torque":
                    sheet.text(at[0], y - 0.15, _number(place, decimals), 10, _NUMBERS)
            else:
                ticks.append([(x, at[1]), (x - 0.05, at[1])])
                if panel.column == 0:
                    sheet.text(x - 0.1, at[1], _number(place, decimals), 10, _NUMBERS, "right")
    sheet.lines(ticks, _NUMBERS, 0.8)
    if panel.column == 0:
        sheet.text(x - 0.58, y + 0.5 * height, "y [m]", 10.5, turned=90)
    if panel.name == "torque":
        sheet.text(x + 0.5 * width, y - 0.36, "x [m]", 10.5)


def _scale(sheet: Sheet, left: float, panel: Panel, norm: Normalize, colours: Colormap) -> None:
    """Draw the scale of colours beside a layer."""
    width, below, height = 0.13, panel.corner[1], panel.size[1]
    low, high = float(norm.vmin or 0.0), float(norm.vmax or 1.0)
    edges = np.linspace(below, below + height, 65)
    sheet.polygons(
        [[(left, a), (left + width, a), (left + width, b), (left, b)] for a, b in zip(edges, edges[1:], strict=False)],
        [tuple(colours((i + 0.5) / 64)) for i in range(64)], "face", 0.2,
    )  # fmt: skip
    if panel.name == "torque":  # what lies beyond the ends has their colours
        for edge, tip, end in ((below, -0.1, 0.0), (below + height, 0.1, 1.0)):
            sheet.polygons([[(left, edge), (left + width, edge), (left + width / 2, edge + tip)]], [colours(end)])
    step, decimals = (0.2, 1) if panel.name == "reach" else (1.0, 0)
    ticks = []
    for value in np.arange(low, high + 0.5 * step, step).tolist():
        y = below + height * (value - low) / (high - low)
        ticks.append([(left + width, y), (left + width + 0.05, y)])
        sheet.text(left + width + 0.1, y, _number(value, decimals), 10, _NUMBERS, "left")
    sheet.lines(ticks, _NUMBERS, 0.8)
    label = "share of poses reached" if panel.name == "reach" else "torque [N m]"
    sheet.text(left + width + 0.55, below + 0.5 * height, label, 10.5, turned=90)
