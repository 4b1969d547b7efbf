"""How sure differences between arms are: their poses are a sample, drawn anew the same for all arms.

All arms meet the same poses, so that what one more or less is reached tells them apart, and not the luck of the draw
(common random numbers). Of each voxel's poses as many are drawn again, with replacement: a paired bootstrap (Efron and
Tibshirani, An Introduction to the Bootstrap, 1993).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mobo_core.errors import InputError
from mobo_core.evaluation.batch import Batch
from mobo_core.evaluation.chain import asked_chain
from mobo_core.evaluation.evaluate import evaluate
from mobo_core.evaluation.spec import EvaluationSpec

Array = NDArray[np.float64]

RESAMPLES = 200
MOST_POSES = 1_000_000
_SEED = 0
_ENDS = (2.5, 97.5)  # percent
# Of a joint's torques the largest; a resample that holds none of so many does not happen.
_LARGEST = 64


@dataclass(frozen=True)
class Interval:
    """A value, and the ends between which 95 % of the resamples lie."""

    value: float
    low: float
    high: float

    @property
    def half(self) -> float:
        """Half of the way from end to end."""
        return 0.5 * (self.high - self.low)

    @property
    def sure(self) -> bool:
        """Whether zero is outside."""
        return self.low > 0 or self.high < 0

    def to_dict(self) -> dict[str, float]:
        """Return value, low and high."""
        return dict(vars(self))


@dataclass(frozen=True, eq=False)
class Score:
    """What an arm is worth, over all poses and in each resample.

    Attributes:
        values: (2 + n,) reach in voxels, torque in N m, then the peak of each joint in N m (0 if nothing is reached).
        drawn: (resamples, 2 + n) likewise.
    """

    values: Array
    drawn: Array

    @property
    def reach(self) -> float:
        """Sum over the voxels of the share of poses reached."""
        return float(self.values[0])

    @property
    def torque(self) -> float:
        """N m, sum over the voxels of the mean norm of the gravity torque."""
        return float(self.values[1])

    def over(self, other: Score) -> tuple[Interval, ...]:
        """Return by how much each value is larger than another arm's; both have as many joints."""
        return _intervals(self.values - other.values, self.drawn - other.drawn)

    def relative(self, other: Score) -> tuple[Interval, Interval]:
        """Return by which share reach and torque are larger than another arm's, which has some of both."""
        return _intervals(_share(self.values[:2], other.values[:2]), _share(self.drawn[:, :2], other.drawn[:, :2]))  # type: ignore[return-value]


def _share(ours: Array, theirs: Array) -> Array:
    shares: Array = ours / np.maximum(theirs, 1e-12) - 1.0
    return shares


def _intervals(values: Array, drawn: Array) -> tuple[Interval, ...]:
    low, high = np.percentile(drawn, _ENDS, axis=0)
    return tuple(Interval(*map(float, each)) for each in zip(values, low, high, strict=True))


class Resamples:
    """How often each pose of each voxel comes in each resample; to hold arms of one question against each other."""

    def __init__(self, spec: EvaluationSpec) -> None:
        """Draw them.

        Raises:
            InputError: more poses than can be held.
        """
        n_poses = spec.n_voxels * spec.poses_per_voxel
        if n_poses > MOST_POSES:
            raise InputError(f"{n_poses:,} poses", where="spec", expected=f"at most {MOST_POSES:,} for intervals")
        self.spec = spec
        poses = spec.poses_per_voxel
        chance = np.random.default_rng(_SEED)
        shape = (RESAMPLES, spec.n_voxels)
        # No pose of some thousands at most comes anywhere near 256 times.
        self._counts = chance.multinomial(poses, np.full(poses, 1 / poses), shape).astype(np.uint8)

    def score(self, urdf: str, tip: str = "") -> Score:
        """Evaluate an arm.

        Raises:
            InputError: the URDF or the tip is not fit.
        """
        spec = self.spec
        chain = asked_chain(urdf, tip, spec)
        result = evaluate(urdf, spec, tip=tip, configurations=True)
        found = result.configurations
        assert found is not None
        batch = Batch(chain, np.array(spec.gravity), found.voxel, found.pose, found.q, found.torque)
        reached, torque = np.zeros((2, spec.n_voxels, spec.poses_per_voxel))
        reached[found.voxel, found.pose] = 1.0
        torque[found.voxel, found.pose] = found.torque
        drawn = np.zeros((RESAMPLES, 2 + chain.n))
        for voxel in np.flatnonzero(result.voxel_reach):
            counts = self._counts[:, voxel]
            hits = counts @ reached[voxel]
            drawn[:, 0] += hits / spec.poses_per_voxel
            drawn[:, 1] += (counts @ torque[voxel]) / np.maximum(hits, 1.0)
        largest = np.zeros(chain.n)
        if len(found.q):
            held = np.abs(batch.joint_torque)
            largest = held.max(axis=0)
            for joint in range(chain.n):
                rows = np.argsort(-held[:, joint], kind="stable")[:_LARGEST]
                there = self._counts[:, found.voxel[rows], found.pose[rows]] > 0
                drawn[:, 2 + joint] = np.where(there.any(axis=1), held[rows[there.argmax(axis=1)], joint], 0.0)
        return Score(np.array([result.reach, result.torque, *largest]), drawn)
