"""What stands around an arm: a floor and boxes, and which of the arm's shapes count against each."""

from __future__ import annotations

import math

import numpy as np

from mobo_core.evaluation.chain import Array, Chain
from mobo_core.evaluation.kernel.arguments import Arm, Obstacles, lane_constants
from mobo_core.evaluation.kernel.obstacles import count_touches
from mobo_core.evaluation.kernel.starts import unit_samples
from mobo_core.evaluation.matrices import rpy_matrix
from mobo_core.evaluation.spec import EvaluationSpec

# Random configurations: a shape that touches something in all of them could never be free of it.
_LOOKS = 256


def flat_arm(chain: Chain) -> Arm:
    """Return a chain as the kernel takes it."""
    constants = lane_constants(chain.placement_r, chain.placement_p, chain.tip_r, chain.tip_p, chain.slide)
    return Arm(
        chain.placement_r, chain.placement_p, chain.tip_r, chain.tip_p, constants, chain.lower, chain.upper,
        chain.mass, chain.com, chain.reach_radius, chain.capsule_joint, chain.capsule_a, chain.capsule_b,
        chain.capsule_radius, chain.pairs, chain.slide,
    )  # fmt: skip


def no_obstacles() -> Obstacles:
    """Return obstacles of which there are none."""
    return Obstacles(-math.inf, np.zeros((0, 15)), np.zeros((0, 0), np.uint8))


def obstacles_of(arm: Arm, spec: EvaluationSpec) -> Obstacles:
    """Return what stands around an arm by a spec, and which of its capsules count against it.

    What is fixed to the base does not count, and neither does a capsule against something that it touches in every
    one of some random configurations: the first link of an arm that stands on the floor, say.
    """
    if spec.floor_z is None and not spec.obstacles:
        return no_obstacles()
    floor_z = -math.inf if spec.floor_z is None else spec.floor_z
    boxes = np.array([_row(box.centre, box.rpy, box.size) for box in spec.obstacles]).reshape(-1, 15)
    counts = np.empty((len(arm.capsule_joint), 1 + len(boxes)), np.int64)
    seen = Obstacles(floor_z, boxes, np.zeros((0, 0), np.uint8))
    q = np.empty((_LOOKS, len(arm.lower)))
    unit_samples(0, q)
    count_touches(arm, seen, q * (arm.upper - arm.lower) + arm.lower, counts)
    against = (counts < _LOOKS) & (arm.capsule_joint >= 0)[:, None]
    return seen._replace(against=against.astype(np.uint8))


def _row(centre: tuple[float, ...], rpy: tuple[float, ...], size: tuple[float, ...]) -> Array:
    return np.concatenate([centre, np.array(rpy_matrix(rpy)).ravel(), 0.5 * np.array(size)])
