"""The oracle: the kernel's algorithm by way of Pinocchio and Coal, one pose at a time, for any chain.

Slow and plain on purpose. It shares with the kernel what defines a question (targets and starts) and the
constants of the algorithm; kinematics, Jacobian, linear algebra, distances and torques are the libraries'.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import coal
import numpy as np
import pinocchio as pin

from mobo_core.evaluation.chain import Array, Chain
from mobo_core.evaluation.kernel import configuration as kernel
from mobo_core.evaluation.kernel.arguments import Obstacles, Outputs, Question
from mobo_core.evaluation.kernel.orientation import FREE_ROLL, FULL
from mobo_core.evaluation.targets import rotation_of
from mobo_core.jit.numerics import random_start


class ReferenceModel:
    """A chain's Pinocchio model and its capsules as Coal objects; one thread at a time."""

    def __init__(self, chain: Chain) -> None:
        self.chain = chain
        self.model = chain.model
        self.data = self.model.createData()
        self._radius = np.where(chain.slide > 0.0, chain.slide, 1.0)
        self._capsules = []
        self._obstacles: list[tuple[coal.CollisionGeometry, coal.Transform3s]] | None = None
        for joint, a, b, radius in zip(
            chain.capsule_joint, chain.capsule_a, chain.capsule_b, chain.capsule_radius, strict=True
        ):
            placement = _capsule_placement(a, b)
            length = float(np.linalg.norm(b - a))
            self._capsules.append((int(joint), placement, coal.Capsule(float(radius), length)))
        # From the chain's joint frames, whose z is the axis, to Pinocchio's.
        pin.forwardKinematics(self.model, self.data, np.zeros(chain.n))
        self._frames = []
        rotation = np.eye(3)
        for i in range(chain.n):
            rotation = rotation @ chain.placement_r[i]
            self._frames.append(pin.SE3(self.data.oMi[i + 1].rotation.T @ rotation, np.zeros(3)))

    def tip(self, q: Array) -> pin.SE3:
        """Return the tip's pose at ``q``, base frame, and update all frames."""
        pin.framesForwardKinematics(self.model, self.data, q)
        return self.data.oMf[self.chain.tip_frame]

    def jacobian(self, q: Array) -> Array:
        """Return the tip's Jacobian, shape (6, n), linear before angular, base axes."""
        jac: Array = pin.computeFrameJacobian(
            self.model, self.data, q, self.chain.tip_frame, pin.LOCAL_WORLD_ALIGNED
        )
        return jac.reshape(6, self.chain.n)  # Pinocchio gives that of a single joint as a vector

    def torque(self, q: Array) -> Array:
        """Return the torques in N m that hold the arm at ``q``, shape (n,); of joints that slide at their pinions."""
        torque: Array = pin.computeGeneralizedGravity(self.model, self.data, q) * self._radius
        return torque

    def clearance(self, q: Array) -> float:
        """Return the least distance in m over the chain's pairs of capsules at ``q``; below 0 they overlap."""
        placed = self._placed(q)
        return min((_distance(*placed[i], *placed[j]) for i, j in self.chain.pairs), default=math.inf)

    def clearance_around(self, q: Array, obstacles: Obstacles) -> float:
        """Return the least distance in m of the capsules from what they count against at ``q``."""
        if not len(obstacles.against):
            return math.inf
        if self._obstacles is None:
            floor = coal.Halfspace(np.array([0.0, 0.0, 1.0]), max(obstacles.floor_z, -1e6))
            self._obstacles = [(floor, coal.Transform3s.Identity())]
            for row in obstacles.boxes:
                box = coal.Box(*(2.0 * row[12:]))
                self._obstacles.append((box, coal.Transform3s(row[3:12].reshape(3, 3), row[:3])))
        placed, things = self._placed(q), self._obstacles
        return min(
            (_distance(*placed[c], *things[k]) for c, k in np.argwhere(obstacles.against).tolist()), default=math.inf
        )

    def _placed(self, q: Array) -> list[tuple[coal.Capsule, coal.Transform3s]]:
        pin.forwardKinematics(self.model, self.data, q)
        placed = []
        for joint, placement, capsule in self._capsules:
            at = placement if joint < 0 else self.data.oMi[joint + 1] * self._frames[joint] * placement
            placed.append((capsule, coal.Transform3s(at.rotation, at.translation)))
        return placed


def _distance(
    a: coal.CollisionGeometry, at_a: coal.Transform3s, b: coal.CollisionGeometry, at_b: coal.Transform3s
) -> float:
    return float(coal.distance(a, at_a, b, at_b, coal.DistanceRequest(), coal.DistanceResult()))


def _capsule_placement(a: Array, b: Array) -> pin.SE3:
    along = b - a
    length = np.linalg.norm(along)
    rotation = np.eye(3)
    if length > 0:
        rotation = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), along / length).toRotationMatrix()
    return pin.SE3(rotation, (a + b) / 2)


def tool_error(
    tip: pin.SE3, target_r: Array, target_p: Array, orientation: int = FULL
) -> tuple[Array, float, float]:
    """Return the six errors of the tool at ``tip`` and their squared norms, as the kernel has them."""
    if orientation != FULL:
        return _free_error(tip, target_r, target_p, orientation)
    relative = target_r @ tip.rotation.T
    sine = 0.5 * np.array(
        [relative[2, 1] - relative[1, 2], relative[0, 2] - relative[2, 0], relative[1, 0] - relative[0, 1]]
    )
    trace = relative[0, 0] + relative[1, 1] + relative[2, 2]
    position, turn = target_p - tip.translation, 2.0 * sine / math.sqrt(max(1.0 + trace, kernel.HALF_TURN))
    e_rotation = float(turn @ turn if 1.0 + trace > kernel.HALF_TURN else 3.0 - trace)
    return np.concatenate([position, turn]), float(position @ position), e_rotation


def _free_error(tip: pin.SE3, target_r: Array, target_p: Array, orientation: int) -> tuple[Array, float, float]:
    """Return the same where the z axes of tool and target count alone, or not even they."""
    position, tool, target = target_p - tip.translation, tip.rotation[:, 2], target_r[:, 2]
    turn, e_rotation = np.zeros(3), 0.0
    if orientation == FREE_ROLL:
        cosine = float(tool @ target)
        turn = np.cross(tool, target) * math.sqrt(2.0 / max(1.0 + cosine, kernel.HALF_TURN))
        e_rotation = float(turn @ turn) if 1.0 + cosine > kernel.HALF_TURN else 2.0 - 2.0 * cosine
    return np.concatenate([position, turn]), float(position @ position), e_rotation


def _that_count(jac: Array, tip: pin.SE3, orientation: int) -> Array:
    """Return a Jacobian (6, n) of the tool at ``tip`` without the turns that do not count."""
    axis = tip.rotation[:, 2]
    kept = {FULL: np.eye(3), FREE_ROLL: np.eye(3) - np.outer(axis, axis)}.get(orientation, np.zeros((3, 3)))
    return np.concatenate([jac[:3], kept @ jac[3:]])


def evaluate_voxels_reference(
    chain: Chain, question: Question, first: int, last: int, out: Outputs, method: Method | None = None
) -> None:
    """Evaluate as :func:`mobo_core.evaluation.kernel.sweep.evaluate_voxels` does.

    ``method`` is one of inverse kinematics in place of the kernel's.
    """
    start, advance = method or (_start, _advance)
    centres, seed, position_tolerance = question.centres, question.seed, question.position_tolerance
    model = ReferenceModel(chain)
    target_r, q = np.empty((3, 3)), np.empty(chain.n)
    for voxel in range(first, last):
        row = voxel - first
        far = np.linalg.norm(centres[voxel] - chain.placement_p[0]) > chain.reach_radius + position_tolerance
        for pose in range(question.poses):
            if far:
                out.outcome[row, pose] = kernel.OUT_OF_RANGE
                continue
            rotation_of(question.rotations, seed, voxel, pose, target_r)
            outcome, best = kernel.NOT_CONVERGED, math.inf
            for attempt in range(question.attempts):
                out.effort[row, 0] += 1
                start(chain, seed, voxel, pose, attempt, q)
                converged, steps = _solve(model, q, target_r, centres[voxel], question, advance(chain))
                out.effort[row, 1] += steps
                if not converged:
                    continue
                collides = question.self_collision and model.clearance(q) <= 0.0
                if collides or model.clearance_around(q, question.obstacles) <= 0.0:
                    outcome = kernel.IN_COLLISION if outcome == kernel.NOT_CONVERGED else outcome
                    continue
                outcome = kernel.REACHED
                norm = float(np.linalg.norm(model.torque(q)))
                if norm < best:
                    best = norm
                    out.q[row, pose] = q
                if not question.least_torque:
                    break
            out.outcome[row, pose] = outcome
            if outcome == kernel.REACHED:
                out.torque[row, pose] = best


# Writes an attempt's first configuration, of (seed, voxel, pose, attempt).
Start = Callable[[Chain, int, int, int, int, Array], None]
# Returns the next of (configuration, Jacobian, six errors, their squared norm).
Advance = Callable[[Array, Array, Array, float], Array]
Method = tuple[Start, Callable[[Chain], Advance]]  # the second is called for each attempt


def _start(chain: Chain, seed: int, voxel: int, pose: int, attempt: int, q: Array) -> None:
    random_start(seed, voxel, pose, attempt, chain.lower, chain.upper, q)


def _advance(chain: Chain) -> Advance:
    """Return the kernel's step: damped least squares, with joints frozen at their limits."""
    lower, upper = chain.lower, chain.upper

    def advance(q: Array, jac: Array, error: Array, squared: float) -> Array:
        gradient = jac.T @ error
        frozen = ((q <= lower) & (gradient < 0)) | ((q >= upper) & (gradient > 0))
        jac[:, frozen] = 0.0
        damping = kernel.DAMPING_FLOOR + kernel.DAMPING_GAIN * squared
        step = jac.T @ np.linalg.solve(jac @ jac.T + damping * np.eye(6), error)
        largest = np.abs(step).max()
        if largest > kernel.MAX_STEP:
            step *= kernel.MAX_STEP / largest
        return np.clip(q + step, lower, upper)

    return advance


def _solve(
    model: ReferenceModel, q: Array, target_r: Array, target_p: Array, question: Question, advance: Advance
) -> tuple[bool, int]:
    """Improve ``q`` in place; return whether it converged, and the number of steps."""
    for iteration in range(question.iterations + 1):
        tip = model.tip(q).copy()
        error, e_position, e_rotation = tool_error(tip, target_r, target_p, question.orientation)
        if e_position <= question.position_tolerance**2 and e_rotation <= question.half_angle_sine**2:
            return True, iteration
        if iteration == question.iterations:
            break
        jac = _that_count(model.jacobian(q), tip, question.orientation)
        q[:] = advance(q, jac, error, e_position + e_rotation)
    return False, question.iterations
