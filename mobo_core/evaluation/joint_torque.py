"""What each joint has to hold: mean, 95 % and peak of its gravity torque over the accepted configurations."""

from __future__ import annotations

import math
from array import array
from collections import Counter
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from mobo_core.evaluation.batch import Batch

# Bits of a double's mantissa that a bin of the histogram leaves out: 10 of 52 stay, so bins are 0.1 % wide at most.
_LEFT_OUT = 42


@dataclass(frozen=True)
class JointTorque:
    """Absolute gravity torque of one joint over the accepted configurations, N m; NaN if there is none.

    Attributes:
        joint: its name.
        mean: over all of them, each counted once.
        p95: what 95 % of them do not exceed, at most 0.1 % too high.
        peak: the largest.
    """

    joint: str
    mean: float
    p95: float
    peak: float

    def to_dict(self) -> dict[str, str | float | None]:
        """Return joint, mean, p95 and peak, those that are not numbers as None."""
        values: dict[str, str | float | None] = asdict(self)
        return {name: None if value != value else value for name, value in values.items()}


class JointTorques:
    """Takes the accepted configurations batch by batch; keeps a sum a voxel and a histogram, whatever their number.

    The histogram's bins are the leading bits of the numbers themselves: as fine for a wrist as for a shoulder.
    How the configurations were cut into batches changes no bit.
    """

    def __init__(self, joints: tuple[str, ...]) -> None:
        """Begin with no configuration.

        Args:
            joints: names of the arm's joints.
        """
        self._joints = joints
        self._count = 0
        self._sums = [array("d") for _ in joints]
        self._bins: list[Counter[int]] = [Counter() for _ in joints]
        self._peaks = [math.nan for _ in joints]

    def add(self, batch: Batch) -> None:
        """Take the next batch."""
        if not len(batch.q):
            return
        self._count += len(batch.q)
        torque: NDArray[np.float64] = np.abs(batch.joint_torque)
        for i, values in enumerate(torque.T):
            # fsum rounds once, whatever the order: NumPy's own sums differ between processors.
            self._sums[i].extend(math.fsum(part) for part in batch.by_voxel(values))
            bins, counts = np.unique(np.ascontiguousarray(values).view(np.int64) >> _LEFT_OUT, return_counts=True)
            self._bins[i].update(dict(zip(bins.tolist(), counts.tolist(), strict=True)))
            self._peaks[i] = float(np.fmax(self._peaks[i], values.max()))

    def value(self) -> tuple[JointTorque, ...]:
        """Return what was found of each joint."""
        return tuple(
            JointTorque(
                name,
                math.fsum(self._sums[i]) / self._count if self._count else math.nan,
                self._quantile(i),
                self._peaks[i],
            )
            for i, name in enumerate(self._joints)
        )

    def _quantile(self, joint: int) -> float:
        """Return the upper end of the bin in which 95 % of the configurations are reached; at most the peak."""
        seen = 0
        for place, count in sorted(self._bins[joint].items()):
            seen += count
            if 100 * seen >= 95 * self._count:
                end = np.array([(place + 1) << _LEFT_OUT], np.int64).view(np.float64)
                return min(float(end[0]), self._peaks[joint])
        return math.nan
