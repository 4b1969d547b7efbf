"""Accepted configurations of some voxels, as objectives take them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mobo_core.evaluation.chain import Chain
from mobo_core.evaluation.measures import joint_torques, manipulabilities


@dataclass(frozen=True)
class Batch:
    """All accepted configurations of some voxels, in order of voxel and pose.

    Which voxels share a batch depends on the memory used: a value should not. Sums are best taken voxel by voxel
    with :func:`math.fsum`, and kept as one number for each.

    Attributes:
        chain: the arm.
        gravity: (3,) m/s^2, base frame.
        voxel, pose: (m,) which target each belongs to.
        q: (m, n) rad, m of joints that slide.
        torque: (m,) N m, norm of the gravity torque.
    """

    chain: Chain
    gravity: NDArray[np.float64]
    voxel: NDArray[np.int64]
    pose: NDArray[np.int64]
    q: NDArray[np.float64]
    torque: NDArray[np.float64]

    @cached_property
    def joint_torque(self) -> NDArray[np.float64]:
        """(m, n) N m, torque that holds each joint against gravity, of a slide at its pinion; computed if asked."""
        c, out = self.chain, np.empty(self.q.shape)
        joint_torques(
            c.placement_r, c.placement_p, c.tip_r, c.tip_p, c.slide, c.mass, c.com, self.gravity, self.q, out
        )  # fmt: skip
        return out

    @cached_property
    def manipulability(self) -> NDArray[np.float64]:
        """(m,) m^3 if all joints turn, Yoshikawa's measure sqrt(det(J J^T)); computed when asked for."""
        c, out = self.chain, np.empty(len(self.q))
        manipulabilities(c.placement_r, c.placement_p, c.tip_r, c.tip_p, c.slide, self.q, out)
        return out

    def by_voxel(self, values: NDArray[np.float64]) -> Iterator[list[float]]:
        """Yield the part of ``values`` (m,) that belongs to each voxel in turn, of those that have any."""
        numbers = values.tolist()
        first = np.flatnonzero(np.diff(self.voxel, prepend=-1))
        for low, high in pairwise([*first, len(numbers)]):
            yield numbers[low:high]
