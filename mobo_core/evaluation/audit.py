"""The check every evaluator makes of itself: accepted poses, once more, with Pinocchio and Coal."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from mobo_core.evaluation.chain import Chain
from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.jit.numerics import STREAM_AUDIT, pick, target_rotation

if TYPE_CHECKING:
    from mobo_core.evaluation.result import Postures

TORQUE_TOLERANCE = 1e-9  # N m
_SLACK = 1e-9  # m, rad: rounding at the edge of a tolerance


def audit(
    chain: Chain, spec: EvaluationSpec, postures: Postures, count: int, number: int
) -> tuple[int, float, str]:
    """Check ``count`` of the accepted postures, chosen by ``number``, against the libraries.

    Each must bring the tip to its target within the spec's tolerances by Pinocchio's kinematics, lie
    within the joint limits, be free of collision by Coal, and need the torque that was reported by Pinocchio's.

    Returns:
        The number of poses checked; the largest fault among them, which is rounding if all is well (torque
        in N m, what exceeds a tolerance or limit in m or rad, overlap of links in m); and a sentence on the
        first pose that fails, or "".
    """
    from mobo_core.evaluation.reference import ReferenceModel

    m = len(postures.voxel)
    if not m:
        return 0, 0.0, ""
    chosen: set[int] = set()
    k = 0
    while len(chosen) < min(count, m):
        chosen.add(int(pick(spec.seed, STREAM_AUDIT, number, k, m)))
        k += 1
    model = ReferenceModel(chain)
    centres, target_r = spec.voxel_centres(), np.empty((3, 3))
    worst, fault = 0.0, ""
    for i in sorted(chosen):
        voxel, pose, q = int(postures.voxel[i]), int(postures.pose[i]), postures.q[i]
        target_rotation(spec.seed, voxel, pose, target_r)
        tip = model.tip(q)
        position = float(np.linalg.norm(tip.translation - centres[voxel]))
        angle = float(np.linalg.norm(pin.log3(tip.rotation.T @ target_r)))
        torque = abs(float(np.linalg.norm(model.torque(q))) - float(postures.torque[i]))
        clearance = model.clearance(q) if spec.self_collision else math.inf
        beyond = float(max(np.max(chain.lower - q), np.max(q - chain.upper)))
        faults = [
            (position - spec.position_tolerance, _SLACK, "tip {:.3g} m outside its tolerance"),
            (angle - spec.rotation_tolerance, _SLACK, "tip turned {:.3g} rad outside its tolerance"),
            (torque, TORQUE_TOLERANCE, "torque off by {:.3g} N m"),
            (-clearance, _SLACK, "links overlap by {:.3g} m"),
            (beyond, 0.0, "a joint {:.3g} rad beyond its limit"),
        ]
        for excess, allowed, text in faults:
            worst = max(worst, excess)
            if not excess <= allowed and not fault:
                fault = f"audit: voxel {voxel}, pose {pose}: {text.format(excess)}"
    return len(chosen), worst, fault
