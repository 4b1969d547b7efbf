"""The figures of the report, in the order of the page."""

from __future__ import annotations

from mobo_core.registry import Registry
from mobo_core.report.figures import convergence, sampling, voxel_maps
from mobo_core.report.figures.figure import Figure

FIGURES = Registry(
    "figure",
    "mobo.figures",
    Figure,
    (
        sampling.FIGURE,
        convergence.FIGURE,
        voxel_maps.FIGURE,
    ),
)
