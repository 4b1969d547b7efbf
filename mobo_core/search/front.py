"""The Pareto front (highest reach, lowest torque) and its hypervolume."""

from __future__ import annotations

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
