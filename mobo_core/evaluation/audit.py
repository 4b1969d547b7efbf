"""The check every evaluator makes of itself: accepted poses, once more, with Pinocchio and Coal."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from mobo_core.evaluation.chain import Array, Chain
from mobo_core.evaluation.obstacles import flat_arm, obstacles_of
from mobo_core.evaluation.result import Configurations
from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.evaluation.targets import given_rotations, rotation_of
from mobo_core.jit.numerics import STREAM_AUDIT, pick

TORQUE_TOLERANCE = 1e-9  # N m
_SLACK = 1e-9  # m, rad: rounding at the edge of a tolerance


class _Accepted(NamedTuple):
    voxel: int
    pose: int
    q: Array
    torque: float

    @classmethod
    def of(cls, found: Configurations, i: int) -> _Accepted:
        # A copy, which does not keep the whole part's array.
        return cls(int(found.voxel[i]), int(found.pose[i]), found.q[i].copy(), float(found.torque[i]))


def _angle(rotation: Array, target_r: Array, orientation: str) -> float:
    """Return by how much, in rad, a tool is turned from its target, as far as that counts."""
    if orientation == "full":
        return float(np.linalg.norm(pin.log3(rotation.T @ target_r)))
    axis, target = rotation[:, 2], target_r[:, 2]
    return math.atan2(float(np.linalg.norm(np.cross(axis, target))), axis @ target) if orientation != "none" else 0.0


class Audit:
    """A check of ``count`` of an arm's accepted configurations, chosen by ``number``; they come in parts.

    Each must bring the tool to its target within the spec's tolerances by Pinocchio's kinematics, lie within the joint
    limits, be free of collision by Coal, also with what stands around, and need the torque that was reported by
    Pinocchio's.
    """

    def __init__(self, chain: Chain, spec: EvaluationSpec, count: int, number: int) -> None:
        self._chain, self._spec = chain, spec
        self._count, self._number = count, number
        self._seen = 0
        self._chosen: list[_Accepted] = []  # in the order drawn

    def add(self, found: Configurations) -> None:
        """Take the next configurations, and choose anew among all so far.

        Places are drawn among all; one before this part's stands for the next of those chosen earlier. So each
        configuration is as likely as any other, and those of a single part are drawn at once.
        """
        total = self._seen + len(found.voxel)
        places: dict[int, None] = {}
        k = 0
        while len(places) < min(self._count, total):
            places[int(pick(self._spec.seed, STREAM_AUDIT, self._number, k, total))] = None
            k += 1
        earlier = iter(self._chosen)
        self._chosen = [
            next(earlier) if place < self._seen else _Accepted.of(found, place - self._seen) for place in places
        ]
        self._seen = total

    def result(self, centres: Array) -> tuple[int, float, str]:
        """Check the configurations chosen. ``centres`` (voxels, 3) are the spec's, in m.

        Returns:
            The number of poses checked; the largest error among them, which is rounding if all is well (of torque
            in N m, of a tolerance or limit exceeded in m or rad, of links that overlap in m); and a sentence on
            the first pose that fails, or "".
        """
        from mobo_core.evaluation.reference import ReferenceModel

        if not self._chosen:
            return 0, 0.0, ""
        chain, spec, model = self._chain, self._spec, ReferenceModel(self._chain)
        target_r = np.empty((3, 3))
        rotations = given_rotations(spec)
        obstacles = obstacles_of(flat_arm(chain), spec)
        worst, fault = 0.0, ""
        for voxel, pose, q, reported in sorted(self._chosen, key=lambda one: (one.voxel, one.pose)):
            rotation_of(rotations, spec.seed, voxel, pose, target_r)
            tip = model.tip(q)
            position = float(np.linalg.norm(tip.translation - centres[voxel]))
            angle = _angle(tip.rotation, target_r, spec.orientation)
            torque = abs(float(np.linalg.norm(model.torque(q))) - reported)
            clearance = model.clearance(q) if spec.self_collision else math.inf
            around = model.clearance_around(q, obstacles)
            beyond = float(max(np.max(chain.lower - q), np.max(q - chain.upper)))
            faults = [
                (position - spec.position_tolerance, _SLACK, "tip {:.3g} m outside its tolerance"),
                (angle - spec.rotation_tolerance, _SLACK, "tip turned {:.3g} rad outside its tolerance"),
                (torque, TORQUE_TOLERANCE, "torque off by {:.3g} N m"),
                (-clearance, _SLACK, "links overlap by {:.3g} m"),
                (-around, _SLACK, "the arm overlaps what stands around it by {:.3g} m"),
                (beyond, 0.0, "a joint {:.3g} rad beyond its limit"),
            ]
            for excess, allowed, text in faults:
                worst = max(worst, excess)
                if not excess <= allowed and not fault:
                    fault = f"audit: voxel {voxel}, pose {pose}: {text.format(excess)}"
        return len(self._chosen), worst, fault
