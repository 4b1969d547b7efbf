"""What an evaluation returns. Light to import: an evaluator that only passes answers on needs no more."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.frames import data_frame

if TYPE_CHECKING:
    from pandas import DataFrame

    from mobo_core.evaluation.joint_torque import JointTorque

Engine = Literal["kernel", "reference"]


@dataclass(frozen=True, repr=False)
class Configurations:
    """Accepted configurations.

    Attributes:
        voxel, pose: (m,) which target each belongs to.
        q: (m, n) rad.
        torque: (m,) N m, norm of the gravity torque.
    """

    voxel: NDArray[np.int64]
    pose: NDArray[np.int64]
    q: NDArray[np.float64]
    torque: NDArray[np.float64]

    def __repr__(self) -> str:
        """Return how many there are, in one line."""
        return f"<{type(self).__name__}: {len(self.voxel)} of {self.q.shape[1]} joints>"

    def to_dict(self) -> dict[str, object]:
        """Return all arrays as lists."""
        return {name: array.tolist() for name, array in vars(self).items()}

    def to_pandas(self) -> DataFrame:
        """Return a table with one row for each: voxel, pose, torque in N m, q1 to qn in rad.

        Raises:
            InputError: pandas is not installed.
        """
        joints = {f"q{i + 1}": column for i, column in enumerate(self.q.T)}
        return data_frame({"voxel": self.voxel, "pose": self.pose, "torque": self.torque, **joints})


@dataclass(repr=False)
class Result:
    """What an arm is worth. Arrays have one entry a voxel.

    Attributes:
        spec: what was asked.
        reach: sum of voxel_reach, at most the number of voxels.
        torque: N m, sum of voxel_torque.
        voxel_reach: share of the poses reached, 0 to 1.
        voxel_torque: N m, mean norm of the gravity torque over the poses reached; 0 where there is none.
        voxel_torque_sd: N m, standard deviation of the same.
        out_of_range, not_converged, in_collision: poses that failed, by reason.
        attempts, iterations: IK effort in all.
        seconds: wall time of the evaluation alone.
        joints, tip: names of the joints on the path, and of the tip link.
        slides: of those that slide, name -> m, radius of the pinion at which their force counts as torque.
        audit_poses, audit_max_error: accepted poses checked again with Pinocchio and Coal, and the largest
            error found among them (m, rad or N m).
        audit_fault: what failed, if a check did.
        ignored_shapes: collision shapes that were neither cylinder nor sphere.
        extra: values of the objectives asked for beyond reach and torque, by name.
        joint_torques: what each joint has to hold, if asked for.
        configurations: the accepted configurations, if asked for.
    """

    spec: EvaluationSpec
    reach: float
    torque: float
    voxel_reach: NDArray[np.float64]
    voxel_torque: NDArray[np.float64]
    voxel_torque_sd: NDArray[np.float64]
    out_of_range: NDArray[np.int64]
    not_converged: NDArray[np.int64]
    in_collision: NDArray[np.int64]
    attempts: int
    iterations: int
    seconds: float
    joints: tuple[str, ...]
    tip: str
    audit_poses: int = 0
    audit_max_error: float = 0.0
    audit_fault: str = ""
    ignored_shapes: int = 0
    extra: dict[str, float] = field(default_factory=dict)
    joint_torques: tuple[JointTorque, ...] | None = None
    configurations: Configurations | None = None
    slides: dict[str, float] = field(default_factory=dict)

    @property
    def mean_torque(self) -> float:
        """N m, mean over the voxels with a pose reached of their voxel_torque; NaN if there is none."""
        means = self.voxel_torque[self.voxel_reach > 0].tolist()
        return math.fsum(means) / len(means) if means else math.nan

    def __repr__(self) -> str:
        """Return scores and chain in one line."""
        extra = "".join(f", {name} {value:.4g}" for name, value in self.extra.items())
        return (
            f"<Result: reach {self.reach:.2f} of {len(self.voxel_reach)} voxels, torque {self.torque:.1f} N m{extra}; "
            f"{len(self.joints)} joints to {self.tip!r}>"
        )

    def to_dict(self) -> dict[str, object]:
        """Return the scores as plain values, as ``mobo evaluate --json`` prints them."""
        values: dict[str, object] = {
            "reach": self.reach,
            "torque": self.torque,
            "mean_torque": None if math.isnan(self.mean_torque) else self.mean_torque,
            "voxel_reach": self.voxel_reach.tolist(),
            "voxel_torque": self.voxel_torque.tolist(),
            "failures": self.failures(),
            "attempts": self.attempts,
            "iterations": self.iterations,
            "seconds": self.seconds,
            "tip": self.tip,
            "joints": list(self.joints),
        }
        if self.slides:
            values["slides"] = self.slides
        if self.joint_torques is not None:
            values["joint_torque"] = [joint.to_dict() for joint in self.joint_torques]
        if self.spec.target_poses:
            values["outcomes"] = self.outcomes()
        return values | ({"extra": dict(self.extra)} if self.extra else {})

    def outcomes(self) -> list[str]:
        """Return of each given pose whether it was ``reached``, or why not; of voxels nothing."""
        if not self.spec.target_poses:
            return []
        reasons = ("out_of_range", "not_converged", "in_collision")
        failed = zip(*(getattr(self, name).tolist() for name in reasons), strict=True)
        return [next((name for name, n in zip(reasons, row, strict=True) if n), "reached") for row in failed]

    def failures(self) -> dict[str, int]:
        """Return how many poses failed in all, by reason."""
        return {name: int(getattr(self, name).sum()) for name in ("out_of_range", "not_converged", "in_collision")}

    def to_pandas(self) -> DataFrame:
        """Return a table with one row a voxel: x, y, z of its centre in m, then what the arrays hold.

        Raises:
            InputError: pandas is not installed.
        """
        names = ("voxel_reach", "voxel_torque", "voxel_torque_sd", "out_of_range", "not_converged", "in_collision")
        centres = dict(zip("xyz", self.spec.voxel_centres().T, strict=True))
        return data_frame({**centres, **{name.removeprefix("voxel_"): getattr(self, name) for name in names}})
