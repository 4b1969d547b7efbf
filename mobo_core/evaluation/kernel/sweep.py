"""The compiled sweep over voxels and poses; the generated module of each number of joints holds a copy of it.

:mod:`mobo_core.evaluation.kernel.load` puts the sources of the two functions :func:`table_tips` and
:func:`evaluate_voxels` behind those of ``lane_step`` and ``lane_forward``
(see :mod:`mobo_core.evaluation.kernel.lanes`) and compiles them together.
"""

from __future__ import annotations

import math

import numpy as np

from mobo_core.evaluation.kernel.configuration import (
    IN_COLLISION,
    NOT_CONVERGED,
    OUT_OF_RANGE,
    REACHED,
    forward,
    gravity_torque,
)
from mobo_core.evaluation.kernel.geometry import any_pair_collides
from mobo_core.evaluation.kernel.obstacles import touches_anything
from mobo_core.evaluation.kernel.orientation import aim
from mobo_core.evaluation.kernel.rows import LANES
from mobo_core.evaluation.kernel.starts import BLIND, STALL_4, STALL_5, STALL_6, WEIGHT, choose_starts, gather_near
from mobo_core.jit.numerics import random_start, target_rotation

# Numbers in ``state``; the generated modules have their own.
STATE = 0


def lane_step(state, constants, lower, upper, weight, orientation, e_position_max, e_rotation_max):
    """Stand for the generated function of this name."""
    raise TypeError("only the compiled modules have it")


def lane_forward(state, constants):
    """Stand for the generated function of this name."""
    raise TypeError("only the compiled modules have it")


def lane_state():
    """Return ``state``, all zero, at a multiple of 64 bytes: vector instructions then load it twice as fast."""
    block = np.zeros(STATE + 8)
    first = (8 - (np.int64(block.ctypes.data) >> 3)) & 7
    return block[first : first + STATE]


def table_tips(constants, q, low, high, tips):
    """Write where the tip is at the rows ``low`` to ``high`` - 1 of ``q`` (m, n) into those columns of ``tips``.

    ``tips`` (12, m): rotation row by row, and position in m.
    """
    n = q.shape[1]
    state = lane_state()
    for first in range(low, high, LANES):
        count = min(LANES, high - first)
        for lane in range(count):
            for k in range(n):
                state[k * LANES + lane] = q[first + lane, k]
        lane_forward(state, constants)
        for k in range(12):
            for lane in range(count):
                tips[k, first + lane] = state[(n + k) * LANES + lane]


def any_ends(state, row, lane_iteration, e_position_max, e_rotation_max, stalls, most):
    """Return whether any lane's attempt may be over; ``row`` is the first of the two of squared errors."""
    ends = 0
    for lane in range(LANES):
        iteration = lane_iteration[lane]
        there = (state[row * LANES + lane] <= e_position_max) & (state[(row + 1) * LANES + lane] <= e_rotation_max)
        ends += there | (iteration >= most) | ((iteration >= stalls) & (iteration <= 6))
    return ends > 0


def evaluate_voxels(arm, table, question, first, last, out):
    """Evaluate all poses of the voxels ``first`` to ``last`` - 1, numbers in ``question.centres``.

    Attempts start from the samples of the table nearest to the pose, and at random when it has no more. Each lane
    works on one pose, attempt after attempt, then takes the next pose. Results go to the rows of ``out``, counted
    from ``first``. The arguments are named tuples of :mod:`mobo_core.evaluation.kernel.arguments`.
    """
    placement_r, placement_p, lower, upper = arm.placement_r, arm.placement_p, arm.lower, arm.upper
    centres, rotations, attempts, poses = question.centres, question.rotations, question.attempts, question.poses
    out_outcome, out_torque, out_q, out_effort = out.outcome, out.torque, out.q, out.effort
    n = lower.shape[0]
    axes, origins, rotations_of_joints = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3, 3))
    tip, target_r, aimed = np.empty((4, 3)), np.empty((3, 3)), np.empty((3, 3))
    orientation = question.orientation
    ends = np.empty((arm.capsule_joint.shape[0], 2, 3))
    q, torque = np.empty(n), np.empty(n)
    e_position_max = question.position_tolerance * question.position_tolerance
    e_rotation_max = question.half_angle_sine * question.half_angle_sine
    beyond = arm.reach_radius + question.position_tolerance
    most = question.iterations
    samples = table.q.shape[0]
    # From this iteration to the 6th an attempt may be given up.
    stalls = 4 if samples > 0 else 7
    weight = WEIGHT if samples > 0 else 1.0
    blind = BLIND if samples > 0 else 0
    # The samples near the present voxel, and the starts of each lane's pose.
    near, near_index, scores = np.empty((10, samples)), np.empty(samples, np.int64), np.empty(samples)
    n_near = 0
    starts, start_scores = np.zeros((LANES, attempts), np.int64), np.empty(attempts)
    state = lane_state()
    lane_row, lane_pose, lane_starts = np.full(LANES, -1), np.zeros(LANES, np.int64), np.zeros(LANES, np.int64)
    lane_attempt, lane_iteration = np.zeros(LANES, np.int64), np.zeros(LANES, np.int64)
    lane_outcome, lane_torque = np.zeros(LANES, np.int64), np.zeros(LANES)
    row, pose, active = 0, 0, 0
    while True:
        # Give idle lanes the next poses, then move all lanes by one step.
        for lane in range(LANES):
            while lane_row[lane] < 0 and row < last - first:
                centre = centres[first + row]
                # From the first joint's origin, whatever its angle.
                dx, dy, dz = (
                    centre[0] - placement_p[0, 0], centre[1] - placement_p[0, 1], centre[2] - placement_p[0, 2]
                )  # fmt: skip
                if dx * dx + dy * dy + dz * dz > beyond * beyond:
                    for k in range(poses):
                        out_outcome[row, k] = OUT_OF_RANGE
                    row += 1
                    continue
                if pose == 0 and samples > 0:
                    n_near = gather_near(
                        centre, attempts, placement_p[0], arm.reach_radius, table.cell_first, table.poses, near,
                        near_index,
                    )  # fmt: skip
                if rotations.shape[0] > 0:
                    target_r[:] = rotations[first + row, pose]
                else:
                    target_rotation(question.seed, first + row, pose, target_r)
                lane_starts[lane] = 0
                if samples > 0:
                    aim(orientation, target_r, aimed)
                    lane_starts[lane] = choose_starts(
                        near, near_index, n_near, aimed, scores, starts[lane], start_scores
                    )
                for k in range(9):
                    state[(n + k) * LANES + lane] = target_r[k // 3, k % 3]
                for k in range(3):
                    state[(n + 9 + k) * LANES + lane] = centre[k]
                lane_row[lane], lane_pose[lane] = row, pose
                lane_attempt[lane], lane_iteration[lane] = 0, -1
                lane_outcome[lane], lane_torque[lane] = NOT_CONVERGED, math.inf
                active += 1
                pose += 1
                if pose == poses:
                    pose = 0
                    row += 1
            if lane_row[lane] >= 0 and lane_iteration[lane] < 0:
                # A new attempt.
                at, attempt = lane_row[lane], lane_attempt[lane]
                if blind <= attempt < blind + lane_starts[lane]:
                    q[:] = table.q[table.order[starts[lane, attempt - blind]]]
                else:
                    random_start(question.seed, first + at, lane_pose[lane], attempt, lower, upper, q)
                for k in range(n):
                    state[k * LANES + lane] = q[k]
                lane_iteration[lane] = 0
                out_effort[at, 0] += 1
        if active == 0:
            return
        lane_step(state, arm.constants, lower, upper, weight, orientation, e_position_max, e_rotation_max)
        while not any_ends(state, n + 12, lane_iteration, e_position_max, e_rotation_max, stalls, most):
            for lane in range(LANES):
                lane_iteration[lane] += 1
            lane_step(state, arm.constants, lower, upper, weight, orientation, e_position_max, e_rotation_max)
        for lane in range(LANES):
            at = lane_row[lane]
            if at < 0:
                continue
            e_position, e_rotation = state[(n + 12) * LANES + lane], state[(n + 13) * LANES + lane]
            there = e_position <= e_position_max and e_rotation <= e_rotation_max
            iteration = lane_iteration[lane]
            error = weight * weight * e_position + e_rotation
            stalled = samples > 0 and lane_attempt[lane] >= blind and (
                (iteration == 4 and error > STALL_4)
                or (iteration == 5 and error > STALL_5)
                or (iteration == 6 and error > STALL_6)
            )
            if not there and not stalled and iteration < most:
                lane_iteration[lane] += 1
                continue
            # The attempt is over.
            out_effort[at, 1] += iteration
            done = False
            if there:
                for k in range(n):
                    q[k] = state[k * LANES + lane]
                forward(
                    placement_r, placement_p, arm.tip_r, arm.tip_p, arm.slide, q, axes, origins, rotations_of_joints,
                    tip,
                )  # fmt: skip
                if (question.self_collision and any_pair_collides(
                    arm.capsule_joint, arm.capsule_a, arm.capsule_b, arm.capsule_radius, arm.pairs, origins,
                    rotations_of_joints, ends,
                )) or touches_anything(
                    arm.capsule_joint, arm.capsule_a, arm.capsule_b, arm.capsule_radius, question.obstacles, origins,
                    rotations_of_joints, ends,
                ):  # fmt: skip
                    if lane_outcome[lane] == NOT_CONVERGED:
                        lane_outcome[lane] = IN_COLLISION
                else:
                    norm = gravity_torque(
                        arm.mass, arm.com, arm.slide, question.gravity, axes, origins, rotations_of_joints, torque
                    )
                    lane_outcome[lane] = REACHED
                    if norm < lane_torque[lane]:
                        lane_torque[lane] = norm
                        out_q[at, lane_pose[lane]] = q
                    done = not question.least_torque
            lane_attempt[lane] += 1
            lane_iteration[lane] = -1
            if done or lane_attempt[lane] == attempts:
                out_outcome[at, lane_pose[lane]] = lane_outcome[lane]
                if lane_outcome[lane] == REACHED:
                    out_torque[at, lane_pose[lane]] = lane_torque[lane]
                lane_row[lane] = -1
                active -= 1
