"""The map of the payload that an arm's motors hold, over its workspace."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import Colormap, Normalize
from matplotlib.figure import Figure as Canvas
from numpy.typing import NDArray

from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.report.figures.drawing import FAINT, INK, has_dark_text, looks, picture, plain, red_to_green

_MOST_LAYERS, _MOST_NUMBERS = 12, 8  # drawn; voxels along a side, up to which each shows its value


def payload_picture(
    voxel_payload: NDArray[np.float64], spec: EvaluationSpec, title: str, kind: Literal["png", "svg"]
) -> bytes:
    """Return the map as a picture: layers of voxels from low to high, kg in each.

    Args:
        voxel_payload: (voxels,) kg, NaN where no pose is reached; below 0 where not even the arm itself is held.
        spec: the workspace.
        title: of the picture.
        kind: png or svg.
    """
    with looks():
        return picture(_figure(voxel_payload, spec, title), kind, dpi=120)


def _figure(voxel_payload: NDArray[np.float64], spec: EvaluationSpec, title: str) -> Canvas:
    values = np.where(np.isnan(voxel_payload), np.nan, np.clip(voxel_payload, 0.0, 1e6)).reshape(spec.shape)
    nz = spec.shape[2]
    layers = sorted({round(i) for i in np.linspace(0, nz - 1, min(nz, _MOST_LAYERS))})
    columns = min(len(layers), 6)
    bands = math.ceil(len(layers) / columns)
    figure = Canvas(figsize=(2.25 * columns + 1.8, 2.6 * bands + 0.9), layout="constrained")
    figure.suptitle(plain(title), x=0.01, ha="left", fontsize=12)
    figure.supxlabel("grey: no pose reached;  0: not even the arm itself is held", fontsize=8.5, color=FAINT)
    seen = values[np.isfinite(values)]
    norm = Normalize(0.0, max(float(np.percentile(seen, 95)) if len(seen) else 1.0, 1e-3))
    colours = red_to_green().with_extremes(bad="#ececec")
    grid = figure.subplots(bands, columns, squeeze=False)
    for axes in grid.flat[len(layers) :]:
        axes.set_axis_off()
    for axes, layer in zip(grid.flat, layers, strict=False):
        mesh = _layer(axes, values[:, :, layer], spec, norm, colours)
        height = spec.workspace_min[2] + (layer + 0.5) * spec.voxel_size + 0.0
        axes.set(xlabel="x [m]", title=f"z = {height:.2f} m".replace("-", "\u2212"))
    for axes in grid[:, 0]:
        axes.set_ylabel("y [m]")
    figure.colorbar(mesh, ax=grid, label="payload [kg]", extend="max")
    return figure


def _layer(
    axes: Axes, values: NDArray[np.float64], spec: EvaluationSpec, norm: Normalize, colours: Colormap
) -> QuadMesh:
    """Draw one layer; ``values`` has the shape (nx, ny), NaN where no pose was reached."""
    (nx, ny), low, high = values.shape, spec.workspace_min, spec.workspace_max
    x, y = np.linspace(low[0], high[0], nx + 1), np.linspace(low[1], high[1], ny + 1)
    mesh = axes.pcolormesh(x, y, np.ma.masked_invalid(values.T), norm=norm, cmap=colours, edgecolors="white")
    axes.set_aspect("equal")
    if max(nx, ny) <= _MOST_NUMBERS:
        for i, j in np.argwhere(np.isfinite(values)).tolist():
            at, ink = (0.5 * (x[i] + x[i + 1]), 0.5 * (y[j] + y[j + 1])), has_dark_text(colours(norm(values[i, j])))
            number = axes.text(
                *at, f"{values[i, j]:.1f}", ha="center", va="center", fontsize=8.5, color=INK if ink else "white"
            )
            number.set_in_layout(False)
    return mesh
