"""The compiled sweep over voxels and poses; the generated module of each number of joints holds a copy of it.

:mod:`mobo_core.evaluation.compiled` puts the source of :func:`evaluate_voxels` behind that of ``lane_step``
(see :mod:`mobo_core.evaluation.lanes`) and compiles both together.
"""

from __future__ import annotations

import math

import numpy as np

from mobo_core.evaluation.geometry import any_pair_collides
from mobo_core.evaluation.kernel import IN_COLLISION, NOT_CONVERGED, OUT_OF_RANGE, REACHED, forward, gravity_torque
from mobo_core.evaluation.lanes import LANES
from mobo_core.evaluation.numerics import random_start, target_rotation


def lane_step(state, constants, lower, upper, e_position_max, e_rotation_max):
    """Stand for the generated function of this name."""
    raise TypeError("only the compiled modules have it")


def evaluate_voxels(
    placement_r, placement_p, tip_r, tip_p, lower, upper, mass, com, radius_of_reach,
    capsule_joint, capsule_a, capsule_b, capsule_radius, pairs,
    centres, first, last, seed, poses, attempts, max_iterations, position_tolerance, half_angle_sine,
    self_collision, least_torque, gravity,
    out_outcome, out_torque, out_q, out_effort,
):  # fmt: skip
    """Evaluate all poses of the voxels ``first`` to ``last`` - 1 (numbers in ``centres``, shape (voxels, 3)).

    Each lane works on one pose, attempt after attempt, and takes the next pose when it is done.
    ``half_angle_sine`` is twice the sine of half the rotation tolerance. Results go to the rows counted
    from ``first``: ``out_outcome`` (last - first, poses), ``out_torque`` likewise in N m, ``out_q``
    (last - first, poses, n) in rad, and ``out_effort`` (last - first, 2): attempts and iterations.
    """
    n = lower.shape[0]
    constants = np.empty((n + 1, 12))
    for i in range(n + 1):
        for k in range(9):
            constants[i, k] = placement_r[i, k // 3, k % 3] if i < n else tip_r[k // 3, k % 3]
        for k in range(3):
            constants[i, 9 + k] = placement_p[i, k] if i < n else tip_p[k]
    axes, origins, rotations, tip = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3, 3)), np.empty((4, 3))
    ends = np.empty((capsule_joint.shape[0], 2, 3))
    target_r, q, torque = np.empty((3, 3)), np.empty(n), np.empty(n)
    e_position_max = position_tolerance * position_tolerance
    e_rotation_max = half_angle_sine * half_angle_sine
    beyond = radius_of_reach + position_tolerance
    state = np.zeros((n + 14) * LANES)
    lane_row, lane_pose = np.full(LANES, -1), np.zeros(LANES, np.int64)
    lane_attempt, lane_iteration = np.zeros(LANES, np.int64), np.zeros(LANES, np.int64)
    lane_outcome, lane_torque = np.zeros(LANES, np.int64), np.zeros(LANES)
    row, pose, active = 0, 0, 0
    while True:
        for lane in range(LANES):
            # Give idle lanes the next pose that is within range.
            while lane_row[lane] < 0 and row < last - first:
                c = centres[first + row]
                # From the first joint's origin, whatever its angle.
                dx, dy, dz = c[0] - placement_p[0, 0], c[1] - placement_p[0, 1], c[2] - placement_p[0, 2]
                if dx * dx + dy * dy + dz * dz > beyond * beyond:
                    out_outcome[row, pose] = OUT_OF_RANGE
                else:
                    target_rotation(seed, first + row, pose, target_r)
                    random_start(seed, first + row, pose, 0, lower, upper, q)
                    for k in range(n):
                        state[k * LANES + lane] = q[k]
                    for k in range(9):
                        state[(n + k) * LANES + lane] = target_r[k // 3, k % 3]
                    for k in range(3):
                        state[(n + 9 + k) * LANES + lane] = c[k]
                    lane_row[lane], lane_pose[lane] = row, pose
                    lane_attempt[lane] = lane_iteration[lane] = 0
                    lane_outcome[lane], lane_torque[lane] = NOT_CONVERGED, math.inf
                    out_effort[row, 0] += 1
                    active += 1
                pose += 1
                if pose == poses:
                    pose = 0
                    row += 1
        if active == 0:
            return
        lane_step(state, constants, lower, upper, e_position_max, e_rotation_max)
        for lane in range(LANES):
            at = lane_row[lane]
            if at < 0:
                continue
            there = (
                state[(n + 12) * LANES + lane] <= e_position_max and state[(n + 13) * LANES + lane] <= e_rotation_max
            )
            if not there and lane_iteration[lane] < max_iterations:
                lane_iteration[lane] += 1
                out_effort[at, 1] += 1
                continue
            # The attempt is over.
            done = False
            if there:
                for k in range(n):
                    q[k] = state[k * LANES + lane]
                forward(placement_r, placement_p, tip_r, tip_p, q, axes, origins, rotations, tip)
                if self_collision and any_pair_collides(
                    capsule_joint, capsule_a, capsule_b, capsule_radius, pairs, origins, rotations, ends
                ):
                    if lane_outcome[lane] == NOT_CONVERGED:
                        lane_outcome[lane] = IN_COLLISION
                else:
                    norm = gravity_torque(mass, com, gravity, axes, origins, rotations, torque)
                    lane_outcome[lane] = REACHED
                    if norm < lane_torque[lane]:
                        lane_torque[lane] = norm
                        for k in range(n):
                            out_q[at, lane_pose[lane], k] = q[k]
                    done = not least_torque
            lane_attempt[lane] += 1
            if done or lane_attempt[lane] == attempts:
                out_outcome[at, lane_pose[lane]] = lane_outcome[lane]
                if lane_outcome[lane] == REACHED:
                    out_torque[at, lane_pose[lane]] = lane_torque[lane]
                lane_row[lane] = -1
                active -= 1
            else:
                random_start(seed, first + at, lane_pose[lane], lane_attempt[lane], lower, upper, q)
                for k in range(n):
                    state[k * LANES + lane] = q[k]
                lane_iteration[lane] = 0
                out_effort[at, 0] += 1
