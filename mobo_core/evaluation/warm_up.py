"""Asks the kernel the smallest of questions, so that it is compiled, or loaded from the cache."""

from __future__ import annotations

from types import ModuleType

import numpy as np


def run(module: ModuleType, n: int) -> None:
    """Call a kernel for ``n`` joints with the types of arguments that evaluations use."""
    eye, one = np.eye(3), np.ones(n)
    module.evaluate_voxels(
        np.stack([eye] * n), np.zeros((n, 3)), eye, np.array([0.0, 0.0, 1.0]), -one, one, one, np.zeros((n, 3)), 1.0,
        np.zeros(1, np.int64), np.zeros((1, 3)), np.zeros((1, 3)), np.ones(1), np.zeros((0, 2), np.int64),
        np.array([[0.0, 0.0, 1.0]]), 0, 1, 0, 1, 1, 1, 1e-3, 1e-2, True, False, np.array([0.0, 0.0, -9.81]),
        np.zeros((1, 1), np.uint8), np.zeros((1, 1)), np.zeros((1, 1, n)), np.zeros((1, 2), np.int64),
    )  # fmt: skip
