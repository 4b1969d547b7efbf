"""The sweep of ``ik_mode: complete`` by rules 2 and later; :mod:`mobo_core.evaluation.kernel.load` compiles it.

Most poses that a study asks of its arms cannot be reached, so evidence says how many attempts a pose is worth: how far
the error has fallen in the best of those made. An attempt that will hardly succeed any more is given up.
A pose that is reached is then tried from blind starts; the first of their solutions counts, so that torque is that
of blind restarts, and the one that was found if there is none.
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
from mobo_core.evaluation.kernel.evidence import (
    TURN,
    bring_between_limits,
    hopes_of,
    worth_of,
)
from mobo_core.evaluation.kernel.geometry import any_near_pair_collides
from mobo_core.evaluation.kernel.near import (
    CELLS,
    GROUPS,
    MOST,
    NONE,
    OUT,
    ROWS,
    SAMPLE,
    best_of_groups,
    code_of,
    gather,
    leave_out,
)
from mobo_core.evaluation.kernel.obstacles import touches_anything
from mobo_core.evaluation.kernel.orientation import aim
from mobo_core.evaluation.kernel.rows import LANES
from mobo_core.evaluation.kernel.starts import WEIGHT
from mobo_core.evaluation.kernel.sweep import lane_forward, lane_state, lane_step
from mobo_core.jit.numerics import random_start, target_rotation


def table_places(constants, q, low, high, x, y, z, radius, cells, poses):
    """Write where the tip is at the samples of the blocks ``low`` to ``high`` - 1 into ``cells`` and ``poses``.

    ``q`` (blocks, n, LANES) rad. ``cells`` (blocks * LANES,): the tip's cell of the grid of ``radius`` around a point
    (m). ``poses`` (blocks * LANES, 12): rotation row by row, and position in m.
    """
    n = q.shape[1]
    state = lane_state()
    scale = CELLS / (2.0 * radius)
    for block in range(low, high):
        for k in range(n):
            for lane in range(LANES):
                state[k * LANES + lane] = q[block, k, lane]
        lane_forward(state, constants)
        for lane in range(LANES):
            ix = np.floor((state[(n + 9) * LANES + lane] - x + radius) * scale)
            iy = np.floor((state[(n + 10) * LANES + lane] - y + radius) * scale)
            iz = np.floor((state[(n + 11) * LANES + lane] - z + radius) * scale)
            ix, iy, iz = min(max(ix, 0.0), CELLS - 1.0), min(max(iy, 0.0), CELLS - 1.0), min(max(iz, 0.0), CELLS - 1.0)
            cells[block * LANES + lane] = int((ix * CELLS + iy) * CELLS + iz)
        for lane in range(LANES):
            for k in range(12):
                poses[block * LANES + lane, k] = state[(n + k) * LANES + lane]


def evaluate_voxels_complete(arm, table, question, effort, first, last, out):
    """Evaluate all poses of the voxels ``first`` to ``last`` - 1, as ``evaluate_voxels`` does, by rules 2 or later.

    Each lane works on one pose, attempt after attempt, then takes the next pose. ``effort`` holds what rules differ in.
    """
    placement_r, placement_p, lower, upper, constants = (
        arm.placement_r, arm.placement_p, arm.lower, arm.upper, arm.constants
    )  # fmt: skip
    tip_r, tip_p, mass, com, slide, gravity = arm.tip_r, arm.tip_p, arm.mass, arm.com, arm.slide, question.gravity
    capsule_joint, capsule_a, capsule_b, capsule_radius, pairs = (
        arm.capsule_joint, arm.capsule_a, arm.capsule_b, arm.capsule_radius, arm.pairs
    )  # fmt: skip
    table_q, table_codes, table_lower, apart = table.q, table.codes, table.lower, table.apart
    order, cell_first, samples = table.order, table.cell_first, table.poses
    centres, rotations, poses, seed = question.centres, question.rotations, question.poses, question.seed
    evidence, worth, obstacles = effort.evidence, effort.worth, question.obstacles
    out_outcome, out_torque, out_q, out_effort = out.outcome, out.torque, out.q, out.effort
    n = lower.shape[0]
    axes, origins, rotations_of_joints = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3, 3))
    tip, target_r, aimed = np.empty((4, 3)), np.empty((3, 3)), np.empty((3, 3))
    orientation = question.orientation
    ends = np.empty((capsule_joint.shape[0], 2, 3))
    q, torque = np.empty(n), np.empty(n)
    free_lower, free_upper = lower.copy(), upper.copy()
    for k in range(n):
        if upper[k] - lower[k] >= TURN and slide[k] == 0.0:
            free_lower[k], free_upper[k] = -1e4, 1e4
    e_position_max = question.position_tolerance * question.position_tolerance
    e_rotation_max = question.half_angle_sine * question.half_angle_sine
    beyond = arm.reach_radius + question.position_tolerance
    search = max(1, question.attempts - effort.blind)
    # An attempt of age a, in iterations, is given up if its error is above hopes[0, a], or above hopes[1, a] and above
    # hopes[2, a] times what it was an iteration before.
    hopes = hopes_of(effort, question.iterations, 5.0 * (WEIGHT * WEIGHT * e_position_max + e_rotation_max))
    # The samples near the present voxel, and the best of each group for each lane's pose.
    blocks, n_blocks = np.empty((MOST // GROUPS + 1) * (ROWS * GROUPS), np.float32), 0
    near, near_codes = np.empty(MOST + GROUPS, np.int64), np.empty(MOST + GROUPS, np.int64)
    keys, codes = np.empty((LANES, GROUPS), np.int64), np.empty((LANES, GROUPS), np.int64)
    best = np.empty(2 * GROUPS, np.float32)
    state = lane_state()
    lane_row, lane_pose, lane_key = np.full(LANES, -1), np.zeros(LANES, np.int64), np.zeros(LANES, np.int64)
    lane_attempt, lane_iteration = np.zeros(LANES, np.int64), np.zeros(LANES, np.int64)
    # An attempt's most iterations; and how much younger hopes take it for, -1 where it is never given up.
    lane_most, lane_patience = np.zeros(LANES, np.int64), np.full(LANES, -1)
    lane_blind = np.zeros(LANES, np.int64)  # blind attempts to come once the search is over
    lane_searching, lane_outcome = np.zeros(LANES, np.bool_), np.zeros(LANES, np.int64)
    lane_error, lane_before, lane_torque = np.zeros(LANES), np.zeros(LANES), np.zeros(LANES)
    ended, n_ended = np.arange(LANES), LANES  # lanes whose attempt is over
    row, pose, active = 0, 0, 0
    while True:
        # Give idle lanes the next poses, others the next attempt, then move all lanes by one step.
        for i in range(n_ended):
            lane = ended[i]
            while lane_row[lane] < 0 and row < last - first:
                x, y, z = centres[first + row, 0], centres[first + row, 1], centres[first + row, 2]
                # From the first joint's origin, whatever its angle.
                dx, dy, dz = x - placement_p[0, 0], y - placement_p[0, 1], z - placement_p[0, 2]
                if dx * dx + dy * dy + dz * dz > beyond * beyond:
                    for k in range(poses):
                        out_outcome[row, k] = OUT_OF_RANGE
                    row += 1
                    continue
                if pose == 0:
                    n_blocks = gather(
                        x, y, z, dx, dy, dz, arm.reach_radius, table_codes, order, cell_first, samples, blocks, near,
                        near_codes,
                    )  # fmt: skip
                if rotations.shape[0] > 0:
                    for k in range(9):
                        target_r[k // 3, k % 3] = rotations[first + row, pose, k // 3, k % 3]
                else:
                    target_rotation(seed, first + row, pose, target_r)
                level = aim(orientation, target_r, aimed)
                best_of_groups(blocks, n_blocks, aimed, level, near, near_codes, best, lane, keys, codes)
                lane_key[lane] = leave_out(NONE, lane, keys, codes)
                lane_row[lane], lane_pose[lane], lane_attempt[lane] = row, pose, 0
                pose += 1
                if pose == poses:
                    pose = 0
                    row += 1
                for k in range(9):
                    state[(n + k) * LANES + lane] = target_r[k // 3, k % 3]
                state[(n + 9) * LANES + lane], state[(n + 10) * LANES + lane] = x, y
                state[(n + 11) * LANES + lane] = z
                lane_searching[lane], lane_error[lane] = True, math.inf
                lane_outcome[lane], lane_torque[lane] = NOT_CONVERGED, math.inf
                active += 1
            at, attempt = lane_row[lane], lane_attempt[lane]
            if at < 0:
                continue
            near_by = lane_searching[lane] and attempt < effort.near_starts
            if near_by and lane_key[lane] < OUT:
                start = lane_key[lane] & SAMPLE
                for k in range(n):
                    state[k * LANES + lane] = table_q[start, k]
                lane_key[lane] = leave_out(table_codes[start], lane, keys, codes)
            else:
                random_start(seed, first + at, lane_pose[lane], attempt, lower, upper, q)
                for k in range(n):
                    state[k * LANES + lane] = q[k]
            lane_iteration[lane], lane_most[lane] = 0, question.iterations
            # Blind attempts need longer; those of reached poses are left alone, so as not to favour the solutions
            # that are quickly found.
            lane_patience[lane] = 0 if near_by else effort.patience
            if not lane_searching[lane]:
                lane_patience[lane], lane_most[lane] = -1, effort.blind_iterations
            out_effort[at, 0] += 1
        if active == 0:
            return
        lane_step(state, constants, free_lower, free_upper, WEIGHT, orientation, e_position_max, e_rotation_max)
        n_ended = 0
        for lane in range(LANES):
            e_position, e_rotation = state[(n + 12) * LANES + lane], state[(n + 13) * LANES + lane]
            error = WEIGHT * WEIGHT * e_position + e_rotation
            iteration, before = lane_iteration[lane], lane_before[lane]
            age = iteration - lane_patience[lane] if 0 <= lane_patience[lane] < iteration else 0
            over = (e_position <= e_position_max) & (e_rotation <= e_rotation_max)
            over |= (iteration >= lane_most[lane]) | (error > hopes[0, age])
            over |= (error > hopes[1, age]) & (error > hopes[2, age] * before)
            lane_error[lane] = min(lane_error[lane], error if iteration > 0 else math.inf)
            lane_before[lane] = error
            lane_iteration[lane] = iteration + 1
            ended[n_ended] = lane
            n_ended += over & (lane_row[lane] >= 0)
        for i in range(n_ended):
            lane = ended[i]
            at = lane_row[lane]
            out_effort[at, 1] += lane_iteration[lane] - 1
            reached = False
            if (
                state[(n + 12) * LANES + lane] <= e_position_max
                and state[(n + 13) * LANES + lane] <= e_rotation_max
            ):  # fmt: skip
                for k in range(n):
                    q[k] = state[k * LANES + lane]
                bring_between_limits(q, lower, upper, slide)
                forward(placement_r, placement_p, tip_r, tip_p, slide, q, axes, origins, rotations_of_joints, tip)
                reached = not question.self_collision or not any_near_pair_collides(
                    capsule_joint, capsule_a, capsule_b, capsule_radius, pairs, origins, rotations_of_joints, ends
                )
                if reached and obstacles.against.shape[0] > 0:
                    reached = not touches_anything(
                        capsule_joint, capsule_a, capsule_b, capsule_radius, obstacles, origins, rotations_of_joints,
                        ends,
                    )  # fmt: skip
                if reached:
                    norm = gravity_torque(mass, com, slide, gravity, axes, origins, rotations_of_joints, torque)
                    if not question.least_torque or norm < lane_torque[lane]:
                        lane_torque[lane] = norm
                        for k in range(n):
                            out_q[at, lane_pose[lane], k] = q[k]
                    lane_outcome[lane] = REACHED
                else:
                    if lane_outcome[lane] == NOT_CONVERGED:
                        lane_outcome[lane] = IN_COLLISION
                    if lane_searching[lane]:
                        lane_key[lane] = leave_out(code_of(q, table_lower, apart), lane, keys, codes)
            lane_attempt[lane] += 1
            if lane_searching[lane]:
                most = effort.most_reached if lane_outcome[lane] == REACHED else effort.most_collided
                if lane_outcome[lane] == NOT_CONVERGED:
                    most = worth_of(lane_error[lane], evidence, worth, effort.most_worth)
                if lane_attempt[lane] < min(most, search) and (question.least_torque or not reached):
                    continue
                # The search is over; blind attempts follow where the pose is reached.
                lane_searching[lane] = False
                lane_blind[lane] = min(effort.blind, question.attempts - lane_attempt[lane])
                lane_attempt[lane] = 0
                if lane_outcome[lane] == REACHED and lane_blind[lane] > 0:
                    continue
            elif lane_attempt[lane] < lane_blind[lane] and (question.least_torque or not reached):
                continue
            out_outcome[at, lane_pose[lane]] = lane_outcome[lane]
            if lane_outcome[lane] == REACHED:
                out_torque[at, lane_pose[lane]] = lane_torque[lane]
            lane_row[lane], lane_patience[lane] = -1, -1
            active -= 1
