"""What an evaluation returns. Light to import: an evaluator that only passes answers on needs no more."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from mobo_core.evaluation.chain import Array

Engine = Literal["kernel", "reference"]


@dataclass(frozen=True)
class Postures:
    """Accepted postures.

    Attributes:
        voxel, pose: (m,) which target each belongs to.
        q: (m, n) rad.
        torque: (m,) N m, norm of the gravity torque.
    """

    voxel: Array
    pose: Array
    q: Array
    torque: Array


@dataclass
class Result:
    """What an arm is worth. Arrays have one entry a voxel.

    Attributes:
        reach: sum of voxel_reach, at most the number of voxels.
        torque: N m, sum of voxel_torque.
        voxel_reach: share of the poses reached, 0 to 1.
        voxel_torque: N m, mean norm of the gravity torque over the poses reached; 0 where there is none.
        voxel_torque_sd: N m, standard deviation of the same.
        out_of_range, not_converged, in_collision: poses that failed, by reason.
        attempts, iterations: IK effort in all.
        seconds: wall time of the evaluation alone.
        joints, tip: names of the joints on the path, and of the tip link.
        audit_poses, audit_max_error: accepted poses checked again with Pinocchio and Coal, and the largest
            error found among them (m, rad or N m).
        audit_fault: what failed, if a check did.
        ignored_shapes: collision shapes that were neither cylinder nor sphere.
        postures: the accepted postures, if asked for.
    """

    reach: float
    torque: float
    voxel_reach: Array
    voxel_torque: Array
    voxel_torque_sd: Array
    out_of_range: Array
    not_converged: Array
    in_collision: Array
    attempts: int
    iterations: int
    seconds: float
    joints: tuple[str, ...]
    tip: str
    audit_poses: int = 0
    audit_max_error: float = 0.0
    audit_fault: str = ""
    ignored_shapes: int = 0
    postures: Postures | None = field(default=None, repr=False)
