"""The collision shapes of a chain as capsules, and the pairs of them that may collide."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from mobo_core.evaluation.kernel.geometry import segment_distance_squared
from mobo_core.evaluation.matrices import Matrix, matmul, matvec, transposed
from mobo_core.evaluation.urdf import CheckedUrdf
from mobo_core.jit.cache import interpreted

TOUCHING = 1e-9  # m; capsules this close in the zero configuration may touch in any


def capsules_of(
    model: pin.Model, checked: CheckedUrdf, frames: Sequence[Matrix]
) -> list[tuple[int, list[float], list[float], float]]:
    """Return each collision shape's joint (-1: the base), the ends of its segment in that joint frame, and radius.

    ``frames`` are the chain's joint frames in Pinocchio's, the base's first.
    """
    capsules = []
    for shape in checked.shapes:
        frame = model.frames[model.getFrameId(shape.link, pin.BODY)]
        joint = int(frame.parentJoint)
        placed, origin = frame.placement.rotation.tolist(), frame.placement.translation.tolist()
        rotation = matmul(placed, pin.rpy.rpyToMatrix(*shape.rpy))
        centre = matvec(placed, shape.xyz)
        back = transposed(frames[joint])
        ends = []
        for sign in (-0.5, 0.5):
            along = [sign * shape.length * rotation[k][2] for k in range(3)]
            ends.append(matvec(back, [centre[k] + origin[k] + along[k] for k in range(3)]))
        capsules.append((joint - 1, ends[0], ends[1], shape.radius))
    return capsules


def listed_pairs(joint: NDArray[np.int64], names: Sequence[str], apart: set[frozenset[str]]) -> NDArray[np.int64]:
    """Return the pairs (k, 2) of capsules on different joints whose ``names`` are not listed in ``apart``.

    ``joint`` (c,) of all capsules; those of one name are one body.
    """
    pairs = [
        (i, j)
        for i, j in itertools.combinations(range(len(names)), 2)
        if joint[i] != joint[j] and names[i] != names[j] and frozenset((names[i], names[j])) not in apart
    ]
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


def separate_pairs(
    joint: NDArray[np.int64], ends: NDArray[np.float64], radius: NDArray[np.float64]
) -> NDArray[np.int64]:
    """Return the pairs (k, 2) of capsules on different joints that are more than TOUCHING apart.

    ``joint`` (c,), ``ends`` (c, 2, 3) m, and ``radius`` (c,) m, of all capsules.
    """
    pairs, distance_squared = [], interpreted(segment_distance_squared)
    shapes = list(zip(joint.tolist(), ends.tolist(), radius.tolist(), strict=True))
    for (i, (joint_a, ends_a, radius_a)), (j, (joint_b, ends_b, radius_b)) in itertools.combinations(
        enumerate(shapes), 2
    ):
        if joint_a == joint_b:
            continue
        if math.sqrt(distance_squared(*ends_a, *ends_b)) - radius_a - radius_b > TOUCHING:
            pairs.append((i, j))
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)
