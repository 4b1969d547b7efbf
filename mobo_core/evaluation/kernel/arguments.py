"""What the kernel is called with, in groups; Numba takes named tuples as they are."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Arm(NamedTuple):
    """A :class:`mobo_core.evaluation.chain.Chain` without names and libraries.

    ``constants`` (n + 1, 12) holds rotation (row by row) and position (m) of each joint in the one before, and of
    the tip in the last, as ``lane_step`` takes them.
    """

    placement_r: Floats
    placement_p: Floats
    tip_r: Floats
    tip_p: Floats
    constants: Floats
    lower: Floats
    upper: Floats
    mass: Floats
    com: Floats
    reach_radius: float
    capsule_joint: Ints
    capsule_a: Floats
    capsule_b: Floats
    capsule_radius: Floats
    pairs: Ints


class Starts(NamedTuple):
    """A table of starts (see :mod:`mobo_core.evaluation.kernel.starts`); without samples, all are random.

    ``q`` (m, n) rad, unsorted; ``order`` (m,), ``cell_first`` (GRID^3 + 1,) and ``poses`` (12, m) by cell.
    """

    q: Floats
    order: Ints
    cell_first: Ints
    poses: Floats


class Table(NamedTuple):
    """A table of starts by rules 2 (see :mod:`mobo_core.evaluation.kernel.near`).

    ``q`` (m, n) rad and ``codes`` (m,), unsorted; ``order`` (m,), ``cell_first`` (CELLS^3 + 1,) and ``poses`` (m, 12)
    by cell. ``lower`` and ``apart`` (n,) rad: from where angles are sampled, and by how much starts of a pose differ.
    """

    q: Floats
    codes: Ints
    order: Ints
    cell_first: Ints
    poses: NDArray[np.float32]
    lower: Floats
    apart: Floats


class Question(NamedTuple):
    """What is asked.

    ``centres`` (voxels, 3) m; ``rotations`` (voxels, poses, 3, 3), or empty to have them drawn from ``seed``.
    ``half_angle_sine`` is twice the sine of half the rotation tolerance; ``gravity`` (3,) m/s^2.
    """

    centres: Floats
    rotations: Floats
    seed: int
    poses: int
    attempts: int
    iterations: int
    position_tolerance: float
    half_angle_sine: float
    self_collision: bool
    least_torque: bool
    gravity: Floats


class Outputs(NamedTuple):
    """What is written, one row a voxel.

    ``outcome`` (voxels, poses); ``torque`` likewise, N m; ``q`` (voxels, poses, n) rad; ``effort`` (voxels, 2):
    attempts and iterations.
    """

    outcome: NDArray[np.uint8]
    torque: Floats
    q: Floats
    effort: Ints

    @classmethod
    def empty(cls, voxels: int, poses: int, n: int) -> Outputs:
        """Return outputs for so many voxels, poses and joints, all zero."""
        return cls(
            np.zeros((voxels, poses), np.uint8),
            np.zeros((voxels, poses)),
            np.zeros((voxels, poses, n)),
            np.zeros((voxels, 2), np.int64),
        )

    def part(self, first: int, last: int) -> Outputs:
        """Return the rows ``first`` to ``last`` - 1."""
        rows = slice(first, last)
        return Outputs(self.outcome[rows], self.torque[rows], self.q[rows], self.effort[rows])
