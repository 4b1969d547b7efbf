"""The compiled sweep of ``ik_mode: complete`` by rules 2; :mod:`mobo_core.evaluation.kernel.load` compiles it.

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
    BLIND,
    MOST_WORTH,
    NEAR_STARTS,
    PATIENCE,
    TURN,
    bring_between_limits,
    hopeless,
    worth,
)
from mobo_core.evaluation.kernel.geometry import any_near_pair_collides
from mobo_core.evaluation.kernel.near import (
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
from mobo_core.evaluation.kernel.rows import LANES
from mobo_core.evaluation.kernel.starts import WEIGHT
from mobo_core.evaluation.kernel.sweep import lane_state, lane_step
from mobo_core.jit.numerics import random_start, target_rotation


def evaluate_voxels_complete(arm, table, question, first, last, out):
    """Evaluate all poses of the voxels ``first`` to ``last`` - 1, as ``evaluate_voxels`` does, by rules 2.

    Each lane works on one pose, attempt after attempt, then takes the next pose.
    """
    placement_r, placement_p, lower, upper = arm.placement_r, arm.placement_p, arm.lower, arm.upper
    centres, rotations, poses = question.centres, question.rotations, question.poses
    out_outcome, out_torque, out_q, out_effort = out.outcome, out.torque, out.q, out.effort
    n = lower.shape[0]
    axes, origins, rotations_of_joints = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3, 3))
    tip, target_r = np.empty((4, 3)), np.empty((3, 3))
    ends = np.empty((arm.capsule_joint.shape[0], 2, 3))
    q, torque = np.empty(n), np.empty(n)
    free_lower, free_upper = lower.copy(), upper.copy()
    for k in range(n):
        if upper[k] - lower[k] >= TURN:
            free_lower[k], free_upper[k] = -1e4, 1e4
    e_position_max = question.position_tolerance * question.position_tolerance
    e_rotation_max = question.half_angle_sine * question.half_angle_sine
    enough = 5.0 * (WEIGHT * WEIGHT * e_position_max + e_rotation_max)
    beyond = arm.reach_radius + question.position_tolerance
    search = max(1, question.attempts - BLIND)
    # The samples near the present voxel, and the best of each group for each lane's pose.
    blocks, n_blocks = np.empty((MOST // GROUPS + 1) * (ROWS * GROUPS), np.float32), 0
    near, near_codes = np.empty(MOST + GROUPS, np.int64), np.empty(MOST + GROUPS, np.int64)
    keys, codes = np.empty((LANES, GROUPS), np.int64), np.empty((LANES, GROUPS), np.int64)
    state = lane_state()
    lane_row, lane_pose, lane_key = np.full(LANES, -1), np.zeros(LANES, np.int64), np.zeros(LANES, np.int64)
    lane_attempt, lane_iteration = np.zeros(LANES, np.int64), np.zeros(LANES, np.int64)
    lane_blind = np.zeros(LANES, np.int64)  # blind attempts to come once the search is over
    lane_searching, lane_outcome = np.zeros(LANES, np.bool_), np.zeros(LANES, np.int64)
    lane_error, lane_before, lane_torque = np.zeros(LANES), np.zeros(LANES), np.zeros(LANES)
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
                if pose == 0:
                    n_blocks = gather(centre, placement_p[0], arm.reach_radius, table, blocks, near, near_codes)
                if rotations.shape[0] > 0:
                    target_r[:] = rotations[first + row, pose]
                else:
                    target_rotation(question.seed, first + row, pose, target_r)
                best_of_groups(blocks, n_blocks, target_r, near, near_codes, lane, keys, codes)
                lane_key[lane] = leave_out(NONE, lane, keys, codes)
                for k in range(9):
                    state[(n + k) * LANES + lane] = target_r[k // 3, k % 3]
                for k in range(3):
                    state[(n + 9 + k) * LANES + lane] = centre[k]
                lane_row[lane], lane_pose[lane] = row, pose
                lane_attempt[lane], lane_iteration[lane] = 0, -1
                lane_searching[lane], lane_error[lane] = True, math.inf
                lane_outcome[lane], lane_torque[lane] = NOT_CONVERGED, math.inf
                active += 1
                pose += 1
                if pose == poses:
                    pose = 0
                    row += 1
            if lane_row[lane] >= 0 and lane_iteration[lane] < 0:
                # A new attempt.
                at = lane_row[lane]
                if lane_searching[lane] and lane_key[lane] < OUT and lane_attempt[lane] < NEAR_STARTS:
                    start = lane_key[lane] & SAMPLE
                    for k in range(n):
                        q[k] = table.q[start, k]
                    lane_key[lane] = leave_out(table.codes[start], lane, keys, codes)
                else:
                    random_start(question.seed, first + at, lane_pose[lane], lane_attempt[lane], lower, upper, q)
                for k in range(n):
                    state[k * LANES + lane] = q[k]
                lane_iteration[lane] = 0
                out_effort[at, 0] += 1
        if active == 0:
            return
        lane_step(state, arm.constants, free_lower, free_upper, WEIGHT, e_position_max, e_rotation_max)
        for lane in range(LANES):
            at = lane_row[lane]
            if at < 0:
                continue
            e_position, e_rotation = state[(n + 12) * LANES + lane], state[(n + 13) * LANES + lane]
            there = e_position <= e_position_max and e_rotation <= e_rotation_max
            error = WEIGHT * WEIGHT * e_position + e_rotation
            iteration = lane_iteration[lane]
            if not there:
                if iteration > 0 and error < lane_error[lane]:
                    lane_error[lane] = error
                # Blind attempts need longer; those of reached poses are left alone, so as not to favour the solutions
                # that are quickly found.
                patience = 0 if lane_attempt[lane] < NEAR_STARTS else PATIENCE
                if iteration < question.iterations and not (
                    lane_searching[lane] and hopeless(iteration - patience, error, lane_before[lane], enough)
                ):
                    lane_before[lane] = error
                    lane_iteration[lane] += 1
                    out_effort[at, 1] += 1
                    continue
            # The attempt is over.
            reached = False
            if there:
                for k in range(n):
                    q[k] = state[k * LANES + lane]
                bring_between_limits(q, lower, upper)
                forward(placement_r, placement_p, arm.tip_r, arm.tip_p, q, axes, origins, rotations_of_joints, tip)
                reached = not question.self_collision or not any_near_pair_collides(
                    arm, origins, rotations_of_joints, ends
                )
                if reached:
                    norm = gravity_torque(
                        arm.mass, arm.com, question.gravity, axes, origins, rotations_of_joints, torque
                    )
                    if not question.least_torque or norm < lane_torque[lane]:
                        lane_torque[lane] = norm
                        out_q[at, lane_pose[lane]] = q
                    lane_outcome[lane] = REACHED
                else:
                    if lane_outcome[lane] == NOT_CONVERGED:
                        lane_outcome[lane] = IN_COLLISION
                    if lane_searching[lane]:
                        code = code_of(q, table.lower, table.apart)
                        lane_key[lane] = leave_out(code, lane, keys, codes)
            lane_attempt[lane] += 1
            lane_iteration[lane] = -1
            if lane_searching[lane]:
                most = MOST_WORTH
                if lane_outcome[lane] == NOT_CONVERGED:
                    most = worth(lane_error[lane])
                if lane_attempt[lane] < min(most, search) and (question.least_torque or not reached):
                    continue
                # The search is over; blind attempts follow where the pose is reached.
                lane_searching[lane] = False
                lane_blind[lane] = min(BLIND, question.attempts - lane_attempt[lane])
                lane_attempt[lane] = 0
                if lane_outcome[lane] == REACHED and lane_blind[lane] > 0:
                    continue
            elif lane_attempt[lane] < lane_blind[lane] and (question.least_torque or not reached):
                continue
            out_outcome[at, lane_pose[lane]] = lane_outcome[lane]
            if lane_outcome[lane] == REACHED:
                out_torque[at, lane_pose[lane]] = lane_torque[lane]
            lane_row[lane] = -1
            active -= 1
