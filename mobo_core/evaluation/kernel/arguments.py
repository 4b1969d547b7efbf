"""What the kernel is called with, in groups; Numba takes named tuples as they are."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# What stands for the tip where joints have the number of their axis; for a joint that slides; and for the tip of an
# arm that has such joints.
TIP, SLIDE, SLIDES = 4.0, 5.0, 6.0


class Arm(NamedTuple):
    """A :class:`mobo_core.evaluation.chain.Chain` without names and libraries.

    ``constants`` are those of :func:`lane_constants`. ``slide`` (n,): 0 for a joint that turns; for one that slides the
    radius, m, by which its force counts as torque.
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
    slide: Floats


def lane_constants(
    placement_r: Floats, placement_p: Floats, tip_r: Floats, tip_p: Floats, slide: Floats
) -> Floats:
    """Return a chain's placements as ``lane_step`` takes them, (n + 1, 14), a row a joint and one for the tip.

    Each row holds rotation (row by row) and position (m) in the joint before, and two numbers more. If, with all
    joints at zero, each turns about x, y or z of the base and each place lies above the one before, then these are
    1, 2 or 3 for the axis (TIP for the tip), and the way along z in m. Otherwise they are 0. Where a joint slides
    (``slide`` above 0) the first is SLIDE for each such joint, SLIDES for the tip, and 0 for the others.
    """
    constants = np.zeros((len(placement_p) + 1, 14))
    constants[:-1, :9], constants[:-1, 9:12] = placement_r.reshape(-1, 9), placement_p
    constants[-1, :9], constants[-1, 9:12] = tip_r.ravel(), tip_p
    if slide.any():
        constants[:-1, 12], constants[-1, 12] = np.where(slide > 0.0, SLIDE, 0.0), SLIDES
        return constants
    frame = np.eye(3)
    parallel = np.zeros((len(constants), 2))
    for i, row in enumerate(constants):
        x, y, parallel[i, 1] = frame @ row[9:12]
        frame = frame @ row[:9].reshape(3, 3)
        if x != 0.0 or y != 0.0 or not np.isin(frame, (-1.0, 0.0, 1.0)).all() or frame[:, 2].min() < 0.0:
            return constants
        parallel[i, 0] = 1.0 + frame[:, 2].argmax()
    if np.array_equal(frame, np.eye(3)):
        parallel[-1, 0] = TIP
        constants[:, 12:] = parallel
    return constants


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


class Effort(NamedTuple):
    """What the rules of ``complete`` differ in from number 2 on (see :mod:`mobo_core.evaluation.kernel.evidence`).

    ``given_up``, ``slow`` and ``slow_share``: an attempt is given up if after 1, 2, … iterations its squared error
    (m^2, by the weight, and rad^2) is above the first, or above the second and above that share of its error one
    iteration before. A pose is worth ``worth`` attempts where its least error is not below ``evidence``, and
    ``most_worth`` where it is, or where an attempt ended in self-collision; the first ``near_starts`` start near it,
    the others blindly, judged as if ``patience`` iterations younger. Once it is reached, ``blind`` attempts from blind
    starts follow, of up to ``blind_iterations``.

    Where an attempt ended in self-collision a pose is worth ``most_collided`` attempts. ``most_reached`` is after how
    many attempts the search for the solution of least torque ends.
    """

    given_up: Floats
    slow: Floats
    slow_share: Floats
    evidence: Floats
    worth: Ints
    most_worth: int
    near_starts: int
    patience: int
    blind: int
    blind_iterations: int
    most_collided: int
    most_reached: int


class Obstacles(NamedTuple):
    """A floor and boxes (see :mod:`mobo_core.evaluation.kernel.obstacles`).

    ``floor_z`` m; ``boxes`` (k, 15); ``against`` (capsules, 1 + k), of no rows where there is nothing.
    """

    floor_z: float
    boxes: Floats
    against: NDArray[np.uint8]


class Question(NamedTuple):
    """What is asked.

    ``centres`` (voxels, 3) m; ``rotations`` (voxels, poses, 3, 3), or empty to have them drawn from ``seed``.
    ``half_angle_sine`` is twice the sine of half the rotation tolerance; ``gravity`` (3,) m/s^2.
    ``orientation``: see :mod:`mobo_core.evaluation.kernel.orientation`.
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
    orientation: int
    obstacles: Obstacles


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
