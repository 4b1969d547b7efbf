"""What a study can ask for: objectives, built in or of other distributions.

Light to import: nothing here needs Pinocchio or the compiled kernel before an arm is evaluated.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, Protocol

import numpy as np

from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.registry import Registry

if TYPE_CHECKING:
    from mobo_core.evaluation.batch import Batch
    from mobo_core.evaluation.chain import Chain

# Joints whose places are nearer than this, m, count as one axis: no two motors fit there.
SAME_PLACE = 1e-3


class Accumulator(Protocol):
    """Takes the accepted configurations of one arm, batch by batch, and gives one number."""

    def add(self, batch: Batch) -> None:
        """Take the next batch: all accepted configurations of some voxels, in order of voxel and pose."""

    def value(self) -> float:
        """Return the objective's value; finite, also where nothing was reached."""


@dataclass(frozen=True)
class Objective:
    """One thing that a study can optimise.

    Attributes:
        name: as people and messages spell it.
        unit: of its values, for people.
        direction: which way is better.
        summary: what it is, in one sentence.
        bound: from a spec, the value that normalises the hypervolume. For a minimised objective it is the reference
            point's coordinate, worse than any sensible arm's. For a maximised one, whose reference is 0, it is the
            best value there can be, or a scale.
        begin: starts an accumulator for one arm; None of ``reach`` and ``torque``, which every result has.
        tolerance: relative difference that ``mobo verify`` allows between a recorded value and a new one; 0 where
            the bits are the same on every machine.
    """

    name: str
    unit: str
    direction: Literal["maximize", "minimize"]
    summary: str
    bound: Callable[[EvaluationSpec], float]
    begin: Callable[[Chain, EvaluationSpec], Accumulator] | None
    tolerance: float = 0.0


def _farthest(spec: EvaluationSpec) -> float:
    """Return the distance in m of the workspace's farthest corner, or given pose, from the base."""
    if spec.target_poses:
        return max(math.hypot(*pose[:3]) for pose in spec.target_poses)
    ends = zip(spec.workspace_min, spec.workspace_max, strict=True)
    return math.sqrt(math.fsum(max(abs(low), abs(high)) ** 2 for low, high in ends))


def _payload_torque(spec: EvaluationSpec) -> float:
    """Return the torque in N m of the payload's weight at the farthest corner."""
    return spec.payload_kg * math.sqrt(math.fsum(g * g for g in spec.gravity)) * _farthest(spec)


def _mean_torque_bound(spec: EvaluationSpec) -> float:
    return 10.0 + _payload_torque(spec)


def _peak_torque_bound(spec: EvaluationSpec) -> float:
    return 20.0 + _payload_torque(spec)


class MeanTorque:
    """Mean over the reached voxels of the voxel's mean torque; the bound if none is reached."""

    def __init__(self, chain: Chain, spec: EvaluationSpec) -> None:
        self._nothing = _mean_torque_bound(spec)
        self._means = array("d")

    def add(self, batch: Batch) -> None:
        """Take the mean of each voxel."""
        # fsum rounds once, whatever the order: NumPy's own sums differ between processors.
        self._means.extend(math.fsum(part) / len(part) for part in batch.by_voxel(batch.torque))

    def value(self) -> float:
        """Return the mean, N m."""
        return math.fsum(self._means) / len(self._means) if self._means else self._nothing


class PeakTorque:
    """Largest absolute torque of any joint over the accepted configurations; the bound if there is none."""

    def __init__(self, chain: Chain, spec: EvaluationSpec) -> None:
        self._nothing = _peak_torque_bound(spec)
        self._peak: float | None = None

    def add(self, batch: Batch) -> None:
        """Take the largest of the batch."""
        if len(batch.q):
            self._peak = max(self._peak or 0.0, float(np.abs(batch.joint_torque).max()))

    def value(self) -> float:
        """Return the peak, N m."""
        return self._nothing if self._peak is None else self._peak


class MeanManipulability:
    """Mean of Yoshikawa's measure over the accepted configurations; 0 if there is none."""

    def __init__(self, chain: Chain, spec: EvaluationSpec) -> None:
        self._sums = array("d")
        self._count = 0

    def add(self, batch: Batch) -> None:
        """Take the sum of each voxel."""
        self._sums.extend(math.fsum(part) for part in batch.by_voxel(batch.manipulability))
        self._count += len(batch.q)

    def value(self) -> float:
        """Return the mean, m^3."""
        return math.fsum(self._sums) / self._count if self._count else 0.0


class Known:
    """A value that the chain alone has, whatever it reaches."""

    def __init__(self, value: float) -> None:
        self._value = value

    def add(self, batch: Batch) -> None:
        """Take nothing of it."""

    def value(self) -> float:
        """Return the value."""
        return self._value


def mass(chain: Chain, spec: EvaluationSpec) -> Known:
    """Return what all joints carry, in kg; the payload is part of it, the base is not."""
    return Known(math.fsum(chain.mass))


def axes(chain: Chain, spec: EvaluationSpec) -> Known:
    """Return the number of places that joints have with all angles at zero, those within SAME_PLACE being one."""
    places: list[list[float]] = []
    rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    at = [0.0, 0.0, 0.0]
    for turn, step in zip(chain.placement_r.tolist(), chain.placement_p.tolist(), strict=True):
        at = [at[i] + math.fsum(rotation[i][k] * step[k] for k in range(3)) for i in range(3)]
        rotation = [[math.fsum(rotation[i][k] * turn[k][j] for k in range(3)) for j in range(3)] for i in range(3)]
        if all(math.fsum((a - b) * (a - b) for a, b in zip(at, p, strict=True)) > SAME_PLACE**2 for p in places):
            places.append(at)
    return Known(float(len(places)))


OBJECTIVES = Registry(
    "objective",
    "mobo.objectives",
    Objective,
    (
        Objective(
            "reach", "voxels", "maximize",
            "Sum over the voxels of the share of poses reached",
            lambda spec: float(spec.n_voxels), None,
        ),
        Objective(
            "torque", "N m", "minimize",
            "Sum over the voxels of the mean norm of the gravity torque at the poses reached",
            lambda spec: 10.0 * spec.n_voxels, None,
        ),
        Objective(
            "mean_torque", "N m", "minimize",
            "Mean over the reached voxels of the voxel's mean norm of the gravity torque; its bound if none is reached",
            _mean_torque_bound, MeanTorque,
        ),
        Objective(
            "peak_torque", "N m", "minimize",
            "Largest gravity torque of any joint at the accepted configurations, what a motor must hold; "
            "its bound if there is none",
            _peak_torque_bound, PeakTorque,
        ),
        Objective(
            "manipulability", "m^3", "maximize",
            "Mean of Yoshikawa's measure sqrt(det(J J^T)) over the accepted configurations; 0 if there is none, "
            "and for fewer than 6 joints",
            lambda spec: (0.5 * _farthest(spec)) ** 3, MeanManipulability,
        ),
        Objective(
            "mass", "kg", "minimize",
            "Mass of all that joints carry, the payload included",
            lambda spec: 10.0 + spec.payload_kg, mass,
        ),
        Objective(
            "axes", "places", "minimize",
            "Number of distinct places of joints along the straight arm; joints within 1 mm count once",
            lambda spec: 12.0, axes,
        ),
    ),
)  # fmt: skip
