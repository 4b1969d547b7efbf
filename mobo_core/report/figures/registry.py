"""The figures of the report, in the order of the page."""

from __future__ import annotations

from mobo_core.registry import Registry
from mobo_core.report.figures import (
    claims,
    convergence,
    importance,
    lengths,
    sampling,
    stages,
    steadiness,
    structures,
    voxel_maps,
)
from mobo_core.report.figures.figure import Figure

FIGURES = Registry(
    "figure",
    "mobo.figures",
    Figure,
    (
        sampling.FIGURE,
        structures.FIGURE,
        lengths.FIGURE,
        claims.FIGURE,
        voxel_maps.FIGURE,
        convergence.FIGURE,
        importance.FIGURE,
        steadiness.FIGURE,
        stages.FIGURE,
    ),
)
