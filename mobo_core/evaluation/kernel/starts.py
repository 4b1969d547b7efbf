"""Where IK attempts start: the sampled configurations whose tip is nearest to a pose. Compiled.

A table holds the tip's pose at many sampled configurations, sorted by the cells of a grid. The samples near a voxel's
centre are gathered once for all of its poses; each pose takes the nearest of them, by position and orientation.
"""

from __future__ import annotations

import math

import numpy as np

from mobo_core.evaluation.kernel import compiled
from mobo_core.evaluation.kernel.arguments import Starts
from mobo_core.jit.numerics import STREAM_TABLE, stream, uniform

# Cells of the grid along each side of the box around the arm's reach.
GRID = 12
# Samples count as near within this share of the arm's reach; more, where that finds too few.
NEAR = 0.25
# What a distance of the arm's whole reach weighs against orientation, whose measure is 4 sin^2(angle / 2).
POSITION_WEIGHT = 10.8
# What an error of 1 m counts against one of 1 rad in these attempts: tolerances of 1 mm and 1 degree then weigh
# about alike, so that an attempt which can only just meet both does not settle beside one of them.
WEIGHT = 12.0
# Attempts from random starts before those from near ones. Of an arm's many solutions of a pose, near starts
# favour those typical of its joint ranges; these keep the mean torque that of random restarts.
BLIND = 2
# From a start this near, an attempt that will succeed nearly always (99.5 %) has a squared error (m^2 and rad^2)
# below these after 4, 5 and 6 iterations, an attempt that will not mostly above: it is given up.
STALL_4, STALL_5, STALL_6 = 0.04, 0.0144, 0.0036


@compiled
def unit_samples(seed, samples):
    """Fill ``samples`` (m, n) with numbers uniform in [0, 1), each row from (seed, its number) alone."""
    for i in range(samples.shape[0]):
        state = stream(seed, STREAM_TABLE, i, 0, 0)
        for k in range(samples.shape[1]):
            samples[i, k] = uniform(state, k)


@compiled
def sort_table(unsorted, centre, radius, cells, order, cell_first, poses):
    """Sort samples by the cell of a grid that their tip lies in.

    The grid has GRID cells a side and spans the ball of ``radius`` m around ``centre``. ``unsorted`` (12, m):
    tip rotation (row by row) and position (m) of each sample. Writes ``order`` (m,), the samples by cell;
    ``cell_first`` (GRID^3 + 1,), where each cell begins in it; and ``poses`` (12, m), the tips in that order.
    ``cells`` (m,) is work space.
    """
    m = order.shape[0]
    cell_first[:] = 0
    for i in range(m):
        cell = 0
        for k in range(3):
            cell = cell * GRID + _cell(unsorted[9 + k, i] - centre[k], radius)
        cells[i] = cell
        cell_first[cell + 1] += 1
    for cell in range(cell_first.shape[0] - 1):
        cell_first[cell + 1] += cell_first[cell]
    for i in range(m):  # a counting sort, which moves each beginning to the next one's
        order[cell_first[cells[i]]] = i
        cell_first[cells[i]] += 1
    for cell in range(cell_first.shape[0] - 1, 0, -1):
        cell_first[cell] = cell_first[cell - 1]
    cell_first[0] = 0
    for k in range(12):
        for i in range(m):
            poses[k, i] = unsorted[k, order[i]]


@compiled
def _cell(offset, radius):
    """Return the grid cell, along one axis, at ``offset`` m from the grid's centre."""
    at = int(math.floor((offset + radius) * (GRID / (2.0 * radius))))
    return min(max(at, 0), GRID - 1)


@compiled
def gather_near(point, enough, centre, radius, cell_first, poses, near, near_index):
    """Collect the samples whose tip is near ``point`` (m) and return their number.

    Writes ``near`` (10, m): rotation, and squared distance weighed against orientation; and ``near_index``
    (m,), their places in the sorted table. If there are fewer than ``enough``, looks further away.
    """
    weight = POSITION_WEIGHT / (radius * radius)
    within = NEAR * radius
    while True:
        count = 0
        for ix in range(_cell(point[0] - centre[0] - within, radius), _cell(point[0] - centre[0] + within, radius) + 1):
            for iy in range(
                _cell(point[1] - centre[1] - within, radius), _cell(point[1] - centre[1] + within, radius) + 1
            ):
                # Cells along z follow each other in the table.
                row = (ix * GRID + iy) * GRID
                low = cell_first[row + _cell(point[2] - centre[2] - within, radius)]
                high = cell_first[row + _cell(point[2] - centre[2] + within, radius) + 1]
                for i in range(low, high):
                    dx, dy, dz = poses[9, i] - point[0], poses[10, i] - point[1], poses[11, i] - point[2]
                    squared = dx * dx + dy * dy + dz * dz
                    if squared <= within * within:
                        for k in range(9):
                            near[k, count] = poses[k, i]
                        near[9, count] = weight * squared
                        near_index[count] = i
                        count += 1
        if count >= enough or within > 2.0 * radius:
            return count
        within *= 1.5


@compiled
def choose_starts(near, near_index, count, aimed, scores, chosen, chosen_scores):
    """Write the table places of the samples nearest to a pose, nearest first, into ``chosen``; return how many.

    ``aimed`` (3, 3) is of the pose's orientation (:func:`mobo_core.evaluation.kernel.orientation.aim`), its position
    that of :func:`gather_near`. ``scores`` (m,)
    and ``chosen_scores`` are work space.
    """
    t0, t1, t2 = aimed[0, 0], aimed[0, 1], aimed[0, 2]
    t3, t4, t5 = aimed[1, 0], aimed[1, 1], aimed[1, 2]
    t6, t7, t8 = aimed[2, 0], aimed[2, 1], aimed[2, 2]
    for i in range(count):
        trace = t0 * near[0, i] + t1 * near[1, i] + t2 * near[2, i] + t3 * near[3, i] + t4 * near[4, i]
        trace += t5 * near[5, i] + t6 * near[6, i] + t7 * near[7, i] + t8 * near[8, i]
        scores[i] = near[9, i] - trace
    most = chosen.shape[0]
    found = 0
    for i in range(count):
        score = scores[i]
        if found == most and not score < chosen_scores[most - 1]:
            continue
        at = found if found < most else most - 1
        while at > 0 and score < chosen_scores[at - 1]:
            chosen_scores[at] = chosen_scores[at - 1]
            chosen[at] = chosen[at - 1]
            at -= 1
        chosen_scores[at] = score
        chosen[at] = near_index[i]
        found = min(found + 1, most)
    return found


def no_table(n: int) -> Starts:
    """Return the table without samples, which makes all attempts of ``n`` joints start at random."""
    return Starts(np.zeros((0, n)), np.zeros(0, np.int64), np.zeros(1, np.int64), np.zeros((12, 0)))
