"""Asks the kernel the smallest of questions, so that it is compiled, or loaded from the cache."""

from __future__ import annotations

from types import ModuleType

import numpy as np

from mobo_core.evaluation.kernel.arguments import Arm, Effort, Obstacles, Outputs, Question, Table
from mobo_core.evaluation.kernel.near import CELLS, codes_of, sort_samples
from mobo_core.evaluation.kernel.obstacles import count_touches
from mobo_core.evaluation.kernel.rows import LANES
from mobo_core.evaluation.kernel.starts import GRID, no_table, sort_table, unit_samples


def run(module: ModuleType, n: int) -> None:
    """Call a kernel for ``n`` joints with the types of arguments that evaluations use."""
    eye, one, up = np.eye(3), np.ones(n), np.array([0.0, 0.0, 1.0])
    constants = np.zeros((n + 1, 14))
    samples, tips, poses = np.zeros((1, n)), np.zeros((12, 1)), np.zeros((12, 1))
    unit_samples(0, samples)
    module.table_tips(constants, samples, 0, 1, tips)
    cell_first = np.zeros(GRID**3 + 1, np.int64)
    sort_table(tips, np.zeros(3), 1.0, np.zeros(1, np.int64), np.zeros(1, np.int64), cell_first, poses)
    none = np.zeros(1, np.int64)
    arm = Arm(
        np.stack([eye] * n), np.zeros((n, 3)), eye, up, constants, -one, one, one, np.zeros((n, 3)), 1.0,
        none, np.zeros((1, 3)), np.zeros((1, 3)), np.ones(1), np.zeros((0, 2), np.int64), np.zeros(n),
    )  # fmt: skip
    obstacles = Obstacles(0.0, np.zeros((0, 15)), np.zeros((1, 1), np.uint8))
    count_touches(arm, obstacles, samples, np.zeros((1, 1), np.int64))
    question = Question(up[None].copy(), np.zeros((0, 0, 3, 3)), 0, 1, 1, 1, 1e-3, 1e-2, True, False, -up, 0, obstacles)
    module.evaluate_voxels(arm, no_table(n), question, 0, 1, Outputs.empty(1, 1, n))
    poses_near, first = np.zeros((1, 12), np.float32), np.zeros(CELLS**3 + 1, np.int64)
    near = Table(samples, none.copy(), none.copy(), first, poses_near, -one, one)
    codes_of(samples, near.lower, near.apart, near.codes)
    cells, places = np.zeros(LANES, np.int64), np.zeros((LANES, 12), np.float32)
    module.table_places(constants, np.zeros((1, n, LANES)), 0, 1, 0.0, 0.0, 0.0, 1.0, cells, places)
    sort_samples(cells, places, near.cell_first, near.order, near.poses)
    effort = Effort(one, one, one, one, none, 1, 1, 1, 1, 1, 1, 1)
    module.evaluate_voxels_complete(arm, near, question, effort, 0, 1, Outputs.empty(1, 1, n))
