"""The Pareto front (highest reach, lowest torque) and its hypervolume."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence

TORQUE_PER_VOXEL = 10.0  # N m, of the reference point: the end of the paper's colour scale


def pareto_front(reach: Sequence[float], torque: Sequence[float]) -> list[int]:
    """Return the indices of the arms that no other one dominates, by rising reach.

    An arm dominates another if it reaches at least as much with at most as much torque, and is better in
    one of the two. Of equal arms the first one stays.
    """
    order = sorted(range(len(reach)), key=lambda i: (-reach[i], torque[i], i))
    front: list[int] = []
    least = float("inf")
    for i in order:
        if torque[i] < least:
            front.append(i)
            least = torque[i]
    return front[::-1]


def hypervolume(reach: Sequence[float], torque: Sequence[float], n_voxels: int) -> float:
    """Return the share of the box (0..n_voxels reach, 0..10 N m x n_voxels torque) that the arms dominate."""
    worst = TORQUE_PER_VOXEL * n_voxels
    area, covered = 0.0, 0.0
    for i in pareto_front(reach, torque):
        if torque[i] < worst and reach[i] > covered:
            # Fronts rise in reach and torque: each arm adds the strip that the ones before do not cover.
            area += (reach[i] - covered) * (worst - torque[i])
            covered = reach[i]
    return area / (n_voxels * worst)


class RunningFront:
    """The Pareto front of arms that come one at a time; the same as that of all of them at once.

    Args:
        n_voxels: the highest reach there is.
    """

    def __init__(self, n_voxels: int) -> None:
        self._n_voxels = n_voxels
        # By rising reach, hence rising torque.
        self._reach: list[float] = []
        self._torque: list[float] = []
        self._hypervolume = 0.0
        self._stale = False

    def __len__(self) -> int:
        """Return the number of arms on the front."""
        return len(self._reach)

    @property
    def best_reach(self) -> float:
        """The highest reach so far, 0 before the first arm."""
        return self._reach[-1] if self._reach else 0.0

    @property
    def hypervolume(self) -> float:
        """What :func:`hypervolume` returns for all arms so far."""
        if self._stale:
            self._hypervolume, self._stale = hypervolume(self._reach, self._torque, self._n_voxels), False
        return self._hypervolume

    def add(self, reach: float, torque: float) -> None:
        """Take the next arm; torque in N m."""
        i = bisect_left(self._reach, reach)
        end = i
        if i < len(self):
            if self._torque[i] <= torque:
                return
            end += self._reach[i] == reach
        first = bisect_left(self._torque, torque, 0, i)
        self._reach[first:end], self._torque[first:end] = [reach], [torque]
        self._stale = True
