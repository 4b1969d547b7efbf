"""What ``mobo evaluate`` prints of an evaluation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from mobo_core.evaluation.wording import further_asked

if TYPE_CHECKING:
    from mobo_core.arms.read import ReadArm
    from mobo_core.bag.record import StudyRecord
    from mobo_core.evaluation.joint_torque import JointTorque
    from mobo_core.evaluation.result import Result

_MOST_FAILED = 12  # given poses that are named
# What has to be equal, to the bit, for two evaluations to be the same.
_COMPARED = ("reach", "torque", "voxel_reach", "voxel_torque")


def print_result(result: Result) -> None:
    """Print scores, effort, chain and the torque of each joint."""
    spec = result.spec
    for phrase in further_asked(spec):
        print(f"asked   {phrase}")
    failures = ", ".join(f"{count} {name.replace('_', ' ')}" for name, count in result.failures().items())
    n = spec.n_voxels * spec.poses_per_voxel
    mean = "" if math.isnan(result.mean_torque) else f"; {result.mean_torque:.2f} N m a reached voxel"
    if spec.target_poses:
        print(f"reach   {result.reach:.0f} of {n} poses")
        print(f"torque  {result.torque:.1f} N m, summed over the poses reached")
    else:
        print(f"reach   {result.reach:.2f} of {spec.n_voxels} voxels ({result.reach / spec.n_voxels:.1%} of {n} poses)")
        print(f"torque  {result.torque:.1f} N m, summed over the voxels' means{mean}")
    for name, value in result.extra.items():
        print(f"{name}  {value:.4g} {_unit(name)}")
    print(f"failed  {failures}")
    if spec.target_poses:
        _print_failed(result)
    print(f"effort  {result.attempts} attempts, {result.iterations} iterations, {result.seconds:.2f} s")
    print(f"chain   {', '.join(result.joints)} to {result.tip}")
    if result.slides:
        radii = ", ".join(f"{name} {radius:g} m" for name, radius in result.slides.items())
        print(f"slides  {radii}: radius of the pinion at which their force counts as torque")
    if result.ignored_shapes:
        print(f"note    {result.ignored_shapes} collision shapes left out: only cylinders and spheres count")
    if result.joint_torques and result.reach:
        _print_joints(result.joint_torques)


def _print_failed(result: Result) -> None:
    why = [(i, outcome.replace("_", " ")) for i, outcome in enumerate(result.outcomes(), 1)]
    failed = [f"{i} ({outcome})" for i, outcome in why if outcome != "reached"]
    if failed:
        more = f" and {len(failed) - _MOST_FAILED} more" if len(failed) > _MOST_FAILED else ""
        print(f"poses   not reached: {', '.join(failed[:_MOST_FAILED])}{more}")


def print_read(arm: ReadArm) -> None:
    """Print what collision shapes an arm of a file was given, and where joints are held."""
    capsules = arm.capsules
    if capsules.fitted:
        ratio = capsules.volume_ratio
        larger = "" if ratio is None else f", {ratio:.2f} times the volume of its shapes"
        off = f"up to {1e3 * capsules.largest_gap:.0f} mm off a mesh or box, at {capsules.at}"
        print(f"shapes  {capsules.count} capsules{larger}; {off}")
    held = [f"{name} {value:.4g}" for name, value in arm.held.items() if value]
    if held:
        print(f"held    {', '.join(held)}")


def _print_joints(joints: Sequence[JointTorque]) -> None:
    width = max(5, *(len(joint.joint) for joint in joints))
    print(f"{'joint':{width}} {'mean':>8} {'95 %':>8} {'peak':>8}   N m, held against gravity at the poses reached")
    for joint in joints:
        print(f"{joint.joint:{width}} {joint.mean:8.2f} {joint.p95:8.2f} {joint.peak:8.2f}")


def _unit(objective: str) -> str:
    from mobo_core.evaluation.objectives import OBJECTIVES

    return OBJECTIVES[objective].unit


class Recorded:
    """How an evaluation compares with what a bag has of the same trial."""

    def __init__(self, study: StudyRecord, trial: int, result: Result) -> None:
        """Compare ``result`` with the answer that ``trial`` was told from."""
        told = study.trials.get(trial)
        self._trial = trial
        self._n_voxels = study.settings.spec.n_voxels
        self._reason = "not told" if told is None else f"failed ({told.reason})"
        self._answer = study.accepted(trial)
        candidate = study.candidate_of(trial)
        same_question = result.spec == study.settings.spec and candidate is not None and result.tip == candidate.tip
        self._same: bool | None = None
        if self._answer is not None and same_question:
            pairs = ((getattr(self._answer, name), getattr(result, name)) for name in _COMPARED)
            self._same = all(np.array_equal(np.asarray(a), np.asarray(b)) for a, b in pairs)

    def to_dict(self) -> dict[str, object]:
        """Return ``trial`` and ``recorded``: reach, torque and whether all is the same, None if not comparable."""
        answer = self._answer
        values = None if answer is None else {"reach": answer.reach, "torque": answer.torque, "same": self._same}
        return {"trial": self._trial, "recorded": values}

    def __str__(self) -> str:
        """Return a line for people."""
        if self._answer is None:
            return f"bag     trial {self._trial} {self._reason}: nothing to compare with"
        values = f"reach {self._answer.reach:.2f} of {self._n_voxels}, torque {self._answer.torque:.1f} N m"
        if self._same is None:
            return f"bag     {values}, recorded with another spec or tip"
        return f"bag     {'the same, to the bit' if self._same else f'DIFFERS: recorded {values}'}"
