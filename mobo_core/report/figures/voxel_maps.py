"""Pictures of one arm's voxels: reach and torque, a square for each layer of the workspace."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from typing import Protocol

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import Colormap, Normalize
from matplotlib.figure import Figure as Canvas
from matplotlib.patches import Circle, Rectangle
from matplotlib.ticker import MaxNLocator, MultipleLocator
from numpy.typing import ArrayLike, NDArray

from mobo_core.bag.record import StudyRecord
from mobo_core.design.joints import JOINTS
from mobo_core.evaluation.colours import REACH_SCALE, TORQUE_SCALE
from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.messages import Evaluation
from mobo_core.report.figures.drawing import FAINT, INK, has_dark_text, plain, red_to_green
from mobo_core.report.figures.figure import Figure, Picture, View, script_beside
from mobo_core.report.prefixes import found, groups
from mobo_core.report.row import Row
from mobo_core.report.table import StudyTable

# The ends of the paper's colour scales.
REACH_ENDS = (REACH_SCALE.red, REACH_SCALE.green)
TORQUE_ENDS = (TORQUE_SCALE.green, TORQUE_SCALE.red)  # N m
_MOST_NUMBERS = 8  # voxels along a side, up to which each shows its value
_MOST_HATCHED = 1000  # voxels in a layer
_MOST_LAYERS = 12
_OTHER_PREFIXES = 4  # drawn beside those that the paper names
_JOINT_WIDTH = 17.0  # points, of a joint's letter in its circle


class OfVoxels(Protocol):
    """What is drawn of an evaluation: one value a voxel."""

    @property
    def voxel_reach(self) -> ArrayLike:
        """Share of the poses reached."""

    @property
    def voxel_torque(self) -> ArrayLike:
        """Mean torque, N m."""


def voxel_figure(row: Row, evaluation: OfVoxels, spec: EvaluationSpec, title: str) -> Canvas:
    """Return the maps of an arm: above reach, below torque, layers of voxels from low to high.

    Of more than twelve layers, twelve are drawn, evenly chosen.

    Args:
        row: the arm.
        evaluation: its Evaluation message.
        spec: the workspace.
        title: of the picture.
    """
    nx, ny, nz = spec.shape
    reach = np.asarray(evaluation.voxel_reach, float).reshape(nx, ny, nz)
    torque = np.asarray(evaluation.voxel_torque, float).reshape(nx, ny, nz)
    layers = sorted({round(i) for i in np.linspace(0, nz - 1, min(nz, _MOST_LAYERS))})
    columns, bands = _grid(len(layers))
    width, height = 2.25 * columns + 1.6, 4.75 * bands + 1.5
    figure = Canvas(figsize=(width, height))
    figure.text(0.15 / width, 1 - 0.12 / height, plain(title), ha="left", va="top", fontsize=12)
    figure.text(
        0.5, 0.1 / height, "hatched: no pose reached;  dashed: as far as the stretched arm goes at this height",
        ha="center", fontsize=8.5, color=FAINT,
    )  # fmt: skip
    right = 1 - 1.05 / width
    _arm(figure.add_axes((0.15 / width, 1 - 1.25 / height, 1 - 0.3 / width, 0.8 / height)), row, 72 * width)
    grid = figure.add_gridspec(
        2 * bands, columns, left=0.72 / width, right=right, top=1 - 1.62 / height, bottom=0.78 / height, wspace=0.06,
        hspace=0.16,
    )  # fmt: skip
    maps = (
        ("reach", reach, REACH_ENDS, red_to_green(), "share of poses reached"),
        ("torque", np.where(reach > 0, torque, np.nan), TORQUE_ENDS, red_to_green().reversed(), "torque [N m]"),
    )
    for place, (name, values, ends, colours, label) in enumerate(maps):
        colours = colours.with_extremes(bad="#ececec")
        for i, layer in enumerate(layers):
            axes = figure.add_subplot(grid[2 * (i // columns) + place, i % columns])
            mesh = _layer(axes, values[:, :, layer], spec, layer, Normalize(*ends), colours, row, name)
            axes.tick_params(labelleft=i % columns == 0, labelbottom=place == 1)
            if i % columns == 0:
                axes.set_ylabel("y [m]")
            if place == 1:
                axes.set_xlabel("x [m]")
            else:
                axes.set_title(f"z = {_middle(spec, 2, layer):.2f} m".replace("-", "\u2212"))
        beside = grid[place, columns - 1].get_position(figure)
        figure.colorbar(
            mesh, cax=figure.add_axes((right + 0.12 / width, beside.y0, 0.13 / width, beside.height)), label=label,
            extend="both" if name == "torque" else "neither", ticks=MultipleLocator(0.2 if name == "reach" else 1.0),
        )  # fmt: skip
    return figure


def _grid(nz: int) -> tuple[int, int]:
    """Return columns and bands (a band is a line of reach above one of torque) for so many layers."""
    columns = min(nz, 6) if nz <= 6 else math.ceil(nz / math.ceil(nz / 6))
    return columns, math.ceil(nz / columns)


def _middle(spec: EvaluationSpec, axis: int, i: int) -> float:
    return spec.workspace_min[axis] + (i + 0.5) * spec.voxel_size + 0.0


def _layer(
    axes: Axes, values: NDArray[np.float64], spec: EvaluationSpec, layer: int, norm: Normalize, colours: Colormap,
    row: Row, name: str,
) -> QuadMesh:  # fmt: skip
    """Draw one layer; ``values`` has the shape (nx, ny), NaN where no pose was reached."""
    nx, ny = values.shape
    low, high = spec.workspace_min, spec.workspace_max
    x, y = np.linspace(low[0], high[0], nx + 1), np.linspace(low[1], high[1], ny + 1)
    many = nx * ny > _MOST_HATCHED
    shown = np.ma.masked_invalid(values.T)
    mesh = axes.pcolormesh(x, y, shown, norm=norm, cmap=colours, edgecolors="white", linewidth=0.0 if many else 1.0)
    axes.set(aspect="equal", xlim=(x[0], x[-1]), ylim=(y[0], y[-1]))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(nbins=5, steps=[1, 2, 4, 10]))
    for spine in axes.spines.values():
        spine.set_visible(False)
    numbers = max(nx, ny) <= _MOST_NUMBERS
    for i in range(nx):
        for j in range(ny):
            value, at = values[i, j], (0.5 * (x[i] + x[i + 1]), 0.5 * (y[j] + y[j + 1]))
            empty = not np.isfinite(value) or (name == "reach" and value == 0)
            if empty and not many:
                corner, size = (x[i], y[j]), spec.voxel_size
                colour = "#b9b9b9" if name == "torque" else "#ffffff80"
                hatched = Rectangle(corner, size, size, fill=False, hatch="////", linewidth=0, edgecolor=colour)
                axes.add_patch(hatched).set_in_layout(False)
            elif numbers and not empty:
                dark = has_dark_text(colours(norm(value)))
                text = f"{value:.2f}" if name == "reach" else f"{value:.1f}"
                number = axes.text(*at, text, ha="center", va="center", fontsize=8.5, color=INK if dark else "white")
                number.set_in_layout(False)
    _limit_of_arm(axes, sum(row.lengths), _middle(spec, 2, layer))
    return mesh


def _limit_of_arm(axes: Axes, length: float, z: float) -> None:
    """Draw how far the stretched arm goes at this height."""
    if abs(z) < length:
        radius = math.sqrt(length**2 - z**2)
        dashes = (0, (4, 3))
        axes.add_patch(Circle((0, 0), radius, fill=False, linestyle=dashes, edgecolor=INK, alpha=0.7))


def _arm(axes: Axes, row: Row, width: float) -> None:
    """Draw the stretched arm with its joints along it; joints at (nearly) the same place side by side.

    Args:
        axes: to draw in.
        row: the arm.
        width: of the picture in points.
    """
    total = max(sum(row.lengths), 1e-9)
    step = _JOINT_WIDTH / (0.75 * width) * total
    places: list[tuple[float, str]] = []
    at = 0.0
    for joint, length in zip(row.joints, row.lengths, strict=False):
        if places and at - places[-1][0] < step * len(places[-1][1]):
            places[-1] = (places[-1][0], places[-1][1] + joint)
        else:
            places.append((at, joint))
        at += length
    axes.plot([0, total], [0, 0], color="#555555", linewidth=3.2, solid_capstyle="round", zorder=1)
    write = partial(axes.annotate, textcoords="offset points", va="center", fontsize=8, color="#555555")
    last, low = -math.inf, False
    for x, joints in places:
        first = min(x, total - step * (len(joints) - 1))
        for i, joint in enumerate(joints):
            colour = JOINTS[joint].colour if joint in JOINTS else FAINT
            axes.text(
                first + step * i, 0, plain(joint), ha="center", va="center", fontsize=9, fontweight="bold",
                color="white", zorder=3 + i,
                bbox={"boxstyle": "circle,pad=0.22", "facecolor": colour, "edgecolor": "white"},
            )  # fmt: skip
        low = x - last < 2 * step and not low
        write(f"{x:.3f}", (x, 0), xytext=(0, -28 if low else -17), ha="center")
        last = x
    write(f"{total:.3f} m", (total, 0), xytext=(16, 0), ha="left")
    axes.set(xlim=(-0.04 * total, 1.13 * total), ylim=(-1.9, 1))
    axes.set_axis_off()


def _draw(study: StudyRecord, table: StudyTable) -> Iterator[Picture]:
    spec = study.settings.spec
    for prefix, best, evaluation in _best(study, table):
        values = f"reach {best.reach:.2f} of {table.n_voxels}, torque {best.torque:.1f} N m"
        canvas = voxel_figure(best, evaluation, spec, f"{best.joints}, trial {best.trial}: {values}")
        yield Picture(canvas, prefix, f"The arm of the highest reach that begins {prefix}.")


def _best(study: StudyRecord, table: StudyTable) -> Iterator[tuple[str, Row, Evaluation]]:
    """Yield the shown prefixes with the arm of the highest reach and its evaluation."""
    for group in found(groups(table), others=_OTHER_PREFIXES):
        best = group.best
        evaluation = study.accepted(best.trial) if best is not None else None
        if best is None or evaluation is None:
            continue
        if len(evaluation.voxel_reach) == len(evaluation.voxel_torque) == study.settings.spec.n_voxels:
            yield group.prefix, best, evaluation


def _data(study: StudyRecord, table: StudyTable) -> object:
    return {"arms": [[prefix, best.trial] for prefix, best, _ in _best(study, table)]}


FIGURE = Figure(
    name="voxels",
    heading="Where the arms reach, and at what torque",
    caption="The arm of the highest reach of each prefix, voxel by voxel.",
    draw=_draw,
    view=View(_data, script_beside(__file__)),
    parts="PREFIX",
    dpi=120,
)
