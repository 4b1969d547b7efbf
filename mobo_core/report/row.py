"""One trial of a study, and how trials are ranked."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """One trial that was told.

    Attributes:
        trial: its number.
        complete: whether it has values.
        joints: joint order as built, such as ``YPPYPY``; "" if the bag lost its candidate.
        sampled_joints: joint order as drawn.
        lengths: m, one a joint.
        reach: sum over the voxels of the share of poses reached; NaN if it failed.
        torque: N m, sum over the voxels of the mean norm of the gravity torque; NaN if it failed.
        on_front: whether no other trial is at least as good in all of the study's objectives.
        above_floor: whether its reach is that of a useful arm, see :data:`REACH_FLOOR_SHARE`.
        known_as: names of the known arms of this joint order.
        attempt: which sending of it was answered.
        evaluator: who answered.
        seconds: s, wall time of the evaluation.
        reason: why it failed, else "".
        values: of the study's objectives, in their order; () if it failed.
        extra: name and value of those beyond reach and torque.
    """

    trial: int
    complete: bool
    joints: str
    sampled_joints: str
    lengths: tuple[float, ...]
    reach: float
    torque: float
    on_front: bool
    above_floor: bool
    known_as: tuple[str, ...]
    attempt: int
    evaluator: str
    seconds: float
    reason: str
    values: tuple[float, ...] = ()
    extra: tuple[tuple[str, float], ...] = ()

    @property
    def state(self) -> str:
        """``COMPLETE`` or ``FAIL``."""
        return "COMPLETE" if self.complete else "FAIL"


def rank(row: Row) -> tuple[float, float, int]:
    """Return what rows are sorted by to have the highest reach first; of equals the least torque."""
    return (-row.reach, row.torque, row.trial)
