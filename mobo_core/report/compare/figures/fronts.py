"""The fronts of the studies; of several seeds, what part of the plane each of them, half of them, and any attained."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure as Canvas
from numpy.typing import NDArray

from mobo_core.report.compare.comparison import Comparison
from mobo_core.report.compare.figures.picture import ComparisonPicture, style
from mobo_core.report.figures.drawing import plain

Points = Sequence[tuple[float, float]]
LEVELS = (0.0, 0.5, 1.0)  # any, half, all


def attained(fronts: Sequence[Points], share: float) -> list[tuple[float, float]]:
    """Return the points (reach, torque) that bound what more than this share of the fronts attained, or all of them.

    A front attains a point if one of its arms reaches as much for no more torque. Share 0 is what any attained, 1
    what all did. Fonseca, Guerreiro, López-Ibáñez, Paquete, On the computation of the empirical attainment function,
    EMO 2011.
    """
    needed = min(max(int(np.floor(share * len(fronts))) + 1, 1), len(fronts))
    if any(not front for front in fronts):
        fronts = [front for front in fronts if front]
        if len(fronts) < needed:
            return []
    reaches = sorted({reach for front in fronts for reach, _ in front}, reverse=True)
    found: list[tuple[float, float]] = []
    for reach in reaches:
        torques = sorted(min((t for r, t in front if r >= reach), default=np.inf) for front in fronts)
        torque = float(torques[needed - 1])
        if np.isfinite(torque) and (not found or torque < found[-1][1]):
            found.append((reach, torque))
    return found[::-1]


def _draw(comparison: Comparison) -> Canvas | None:
    groups = [group for group in comparison.groups if any(one.front for one in group.members)]
    if not groups:
        return None
    figure = Canvas(figsize=(9.6, 5.6), layout="constrained")
    axes = figure.add_subplot()
    shares = len({one.settings.spec.n_voxels for one in comparison.studies}) > 1
    axes.set(xlabel="reach [share of the voxels]" if shares else "reach [voxels]",
             ylabel="least torque [N m a voxel]" if shares else "least torque [N m, summed over voxels]")  # fmt: skip
    axes.grid(True)
    for i, group in enumerate(groups):
        colour, marker, dashes = style(i)
        n = group.members[0].settings.spec.n_voxels if shares else 1
        fronts = [[(r / n, t / n) for r, t in one.front] for one in group.members]
        any_one, half, every = (attained(fronts, level) for level in LEVELS)
        axes.plot(*_steps(half), color=colour, linestyle=dashes, linewidth=1.8, zorder=3)
        axes.plot([], [], color=colour, linestyle=dashes, linewidth=1.8, marker=marker, label=plain(group.label))
        points = half[:: max(1, len(half) // 12)]
        axes.plot(*np.array(points).reshape(-1, 2).T, marker, color=colour, markersize=5, markeredgecolor="white",
                  markeredgewidth=0.5, zorder=4)  # fmt: skip
        if len(fronts) > 1:
            for line in (any_one, every):
                axes.plot(*_steps(line), color=colour, linewidth=0.8, alpha=0.8, linestyle=dashes)
            (x, best), (_, worst) = _common(any_one, every)
            axes.fill_between(x, best, worst, color=colour, alpha=0.15, linewidth=0)
    axes.legend(loc="upper left")
    return figure


def _steps(front: Points) -> tuple[list[float], list[float]]:
    """Return the line below which nothing was attained: from arm to arm, up to what the next one takes."""
    x, y = [], []
    for i, (reach, torque) in enumerate(front):
        if i:
            x.append(front[i - 1][0])
            y.append(torque)
        x.append(reach)
        y.append(torque)
    return x, y


def _common(a: Points, b: Points) -> tuple[tuple[NDArray[np.float64], NDArray[np.float64]], ...]:
    """Return both lines at the same places, where both are."""
    last = min((front[-1][0] for front in (a, b) if front), default=0.0)
    x = np.linspace(min(a[0][0], b[0][0]) if a and b else 0.0, last, 400)
    lines = []
    for front in (a, b):
        reach, torque = np.array(front).reshape(-1, 2).T
        place = np.searchsorted(reach, x)
        lines.append((x, np.append(torque, np.nan)[place]))
    return tuple(lines)


PICTURE = ComparisonPicture(
    "fronts",
    "Fronts",
    "The least torque for a reach. Studies that differ in their seeds alone are one line, what half of them attained, "
    "in a band from what any did to what all did.",
    _draw,
)
