"""The poses that a spec asks for: positions of voxels or of given poses, and orientations where they are given."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mobo_core.evaluation.matrices import rpy_matrix
from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.jit.numerics import target_rotation

# Orientations of no targets: the kernel draws them.
DRAWN = np.zeros((0, 0, 3, 3))


def given_rotations(spec: EvaluationSpec) -> NDArray[np.float64]:
    """Return the orientations (poses, 1, 3, 3) of given poses, base frame; DRAWN if they are drawn."""
    if not spec.target_poses:
        return DRAWN
    return np.array([rpy_matrix(pose[3:]) for pose in spec.target_poses]).reshape(-1, 1, 3, 3)


def rotation_of(
    rotations: NDArray[np.float64], seed: int, voxel: int, pose: int, out: NDArray[np.float64]
) -> None:
    """Write a target's orientation into ``out`` (3, 3): given in ``rotations``, or drawn from ``seed``."""
    if len(rotations):
        out[:] = rotations[voxel, pose]
    else:
        target_rotation(seed, voxel, pose, out)
