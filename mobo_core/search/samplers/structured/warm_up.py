"""Has the sampler draw a few trials, so that its functions are compiled, or loaded from the cache."""

from __future__ import annotations

import numpy as np

from mobo_core.design import DesignSpace
from mobo_core.search.samplers.structured.search import Search


def run() -> None:
    """Run a tiny search."""
    search = Search(DesignSpace(n_joints=3, joint_types="RP"), 2, [1, 0], [True, False], 2, 0, 2)
    for trial in range(16):
        order, point = search.next(trial)
        search.asked(trial, order, point)
        if trial:
            search.told(trial, order, point, np.array([trial / 20.0, 1.0 - trial / 20.0]))
