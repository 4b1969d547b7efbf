"""Where the attempts of ``complete`` (rules 2) start: samples near a pose that differ from each other. Compiled.

A table holds sampled configurations and the poses of their tip, sorted by the cells of a grid. Those near a voxel's
centre are gathered once for all of its poses, in blocks of GROUPS: sample number i belongs to group i modulo GROUPS.
Of each group a pose keeps the best sample alone, and its attempts take the best of these, one after the other, of
those that differ from the starts taken so far.

The table is in single precision: it says where attempts start, and nothing else.
"""

from __future__ import annotations

import math

import numpy as np

from mobo_core.evaluation.kernel import compiled
from mobo_core.evaluation.kernel.starts import POSITION_WEIGHT

# Cells of the grid along each side of the box around the arm's reach.
CELLS = 16
GROUPS = 64
# Rows of a block: rotation, and squared distance weighed against orientation.
ROWS = 10
# Samples count as near within this share of the arm's reach, times powers of GROWTH up to FAR where they are fewer than
# ENOUGH, or of SHRINKING where they are more than MOST. Of poses that can be reached, the nearest sample lies much
# nearer than FAR.
NEAR, GROWTH, FAR, ENOUGH = 0.08, 1.4, 0.42, 320
SHRINKING, MOST = 0.8, 2048
# Scores become whole numbers, of which SCALE are 1, above a sample's number; and the key of a group that is left out.
SAMPLE_BITS = 24
SCALE, OUT, SAMPLE = np.float32(1 << 20), np.int64(1 << 62), np.int64((1 << SAMPLE_BITS) - 1)
_FAR_OFF = np.float32(1e9)
# A code holds the angles of up to eight joints, a byte each: configurations are alike if no byte differs by more than
# 15. Bytes stay below 112, so that with their highest bits set, sums and differences do not run into the next one.
# NONE is alike no configuration.
NONE = np.int64(0x7F7F7F7F7F7F7F7F)
_MOST, _ALIKES, _HIGH = 111.0, np.int64(0x0F0F0F0F0F0F0F0F), np.uint64(0x8080808080808080).view(np.int64)


@compiled
def code_of(q, lower, apart):
    """Return the code of a configuration ``q`` (n,) rad: those alike it differ by less than ``apart`` in each joint."""
    code = np.int64(0)
    for k in range(min(8, q.shape[0])):
        steps = (q[k] - lower[k]) / apart[k] * 16.0
        code = (code << 8) | np.int64(min(max(steps, 0.0), _MOST))
    return code


@compiled
def _cell(offset, radius):
    """Return the grid cell, along one axis, at ``offset`` m from the grid's centre."""
    at = int(math.floor((offset + radius) * (CELLS / (2.0 * radius))))
    return min(max(at, 0), CELLS - 1)


@compiled
def codes_of(q, lower, apart, codes):
    """Write the codes of configurations ``q`` (m, n) rad."""
    for i in range(q.shape[0]):
        codes[i] = code_of(q[i], lower, apart)


@compiled
def sort_samples(cells, unsorted, cell_first, order, poses):
    """Sort samples by their cell of the grid, from what ``table_places`` writes.

    ``cells`` (m,), ``unsorted`` (m, 12): tip's rotation row by row, and position in m. Writes ``order`` (m,), the
    samples by cell; ``poses`` (m, 12), the tips in that order; and ``cell_first`` (CELLS^3 + 1,), where each cell
    begins.
    """
    m = order.shape[0]
    cell_first[:] = 0
    for i in range(m):
        cell_first[cells[i] + 1] += 1
    for cell in range(cell_first.shape[0] - 1):
        cell_first[cell + 1] += cell_first[cell]
    for i in range(m):  # a counting sort, which moves each beginning to the next one's
        at = cell_first[cells[i]]
        cell_first[cells[i]] = at + 1
        order[at] = i
        for k in range(12):
            poses[at, k] = unsorted[i, k]
    for cell in range(cell_first.shape[0] - 1, 0, -1):
        cell_first[cell] = cell_first[cell - 1]
    cell_first[0] = 0


@compiled
def _scan(x, y, z, gx, gy, gz, within, radius, cell_first, poses, index):
    """Write the places of the samples whose tip is ``within`` m of a point into ``index``, and return their number.

    It stops where there are more than MOST.
    """
    size, count = 2.0 * radius / CELLS, 0
    for ix in range(_cell(gx - within, radius), _cell(gx + within, radius) + 1):
        # How far the cells of this column are from the point; those at the rim hold what lies outside, too.
        low = (ix * size - radius) - gx
        away_x = max(0.0, low, -(low + size)) if 0 < ix < CELLS - 1 else 0.0
        for iy in range(_cell(gy - within, radius), _cell(gy + within, radius) + 1):
            low = (iy * size - radius) - gy
            away_y = max(0.0, low, -(low + size)) if 0 < iy < CELLS - 1 else 0.0
            left = within * within - away_x * away_x - away_y * away_y
            if left < 0.0:
                continue
            height = math.sqrt(left)
            # Cells along z follow each other in the table.
            row = (ix * CELLS + iy) * CELLS
            first, last = cell_first[row + _cell(gz - height, radius)], cell_first[row + _cell(gz + height, radius) + 1]
            if count + (last - first) > index.shape[0]:
                last = first + (index.shape[0] - count)
            for i in range(first, last):
                dx, dy, dz = poses[i, 9] - x, poses[i, 10] - y, poses[i, 11] - z
                index[count] = i
                count += 1 if dx * dx + dy * dy + dz * dz <= within * within else 0
    return count


@compiled
def gather(x, y, z, gx, gy, gz, radius, table_codes, order, cell_first, poses, blocks, numbers, codes):
    """Collect the samples whose tip is near a point in ``blocks`` and return the number of blocks.

    The point is at x, y, z (m), and at gx, gy, gz from the grid's centre. ``radius`` is the grid's; the rest is of a
    :class:`mobo_core.evaluation.kernel.arguments.Table`.
    ``blocks`` (flat): ROWS rows of GROUPS numbers each; places that remain in the last one are far away.
    ``numbers`` and ``codes`` get those of the samples.
    """
    weight = POSITION_WEIGHT / (radius * radius)
    within = NEAR * radius
    count = _scan(x, y, z, gx, gy, gz, within, radius, cell_first, poses, numbers)
    while count < ENOUGH and within < FAR * radius:
        within = min(within * (GROWTH if 4 * count > ENOUGH else GROWTH * GROWTH), FAR * radius)
        count = _scan(x, y, z, gx, gy, gz, within, radius, cell_first, poses, numbers)
    while count > MOST and within > 1e-3 * radius:
        within *= SHRINKING
        count = _scan(x, y, z, gx, gy, gz, within, radius, cell_first, poses, numbers)
    count = min(count, MOST)
    n_blocks = (count + GROUPS - 1) // GROUPS
    for at in range(count):
        i, place = numbers[at], (at // GROUPS) * (ROWS * GROUPS) + at % GROUPS
        dx, dy, dz = poses[i, 9] - x, poses[i, 10] - y, poses[i, 11] - z
        for k in range(9):
            blocks[place + k * GROUPS] = poses[i, k]
        blocks[place + 9 * GROUPS] = weight * (dx * dx + dy * dy + dz * dz)
        numbers[at] = order[i]
        codes[at] = table_codes[order[i]]
    for at in range(count, n_blocks * GROUPS):
        place = (at // GROUPS) * (ROWS * GROUPS) + at % GROUPS
        for k in range(9):
            blocks[place + k * GROUPS] = np.float32(0.0)
        blocks[place + 9 * GROUPS] = _FAR_OFF
    return n_blocks


@compiled
def best_of_groups(blocks, n_blocks, aimed, level, numbers, codes, best, lane, keys, group_codes):
    """Write the keys of the best samples of the groups for a pose, and their codes, into row ``lane``.

    A key is 4 sin^2(angle / 2) plus the weighed squared distance, in units of SCALE, and then the sample's number.
    ``aimed`` (3, 3) and ``level`` are of the pose's orientation
    (:func:`mobo_core.evaluation.kernel.orientation.aim`), its position that of :func:`gather`, which gave ``blocks``,
    ``numbers`` and ``codes``. ``best`` (2 * GROUPS,) is work space: scores, and blocks.
    """
    t0, t1, t2 = np.float32(aimed[0, 0]), np.float32(aimed[0, 1]), np.float32(aimed[0, 2])
    t3, t4, t5 = np.float32(aimed[1, 0]), np.float32(aimed[1, 1]), np.float32(aimed[1, 2])
    t6, t7, t8 = np.float32(aimed[2, 0]), np.float32(aimed[2, 1]), np.float32(aimed[2, 2])
    for j in range(GROUPS):
        best[j] = _FAR_OFF
        best[GROUPS + j] = np.float32(0.0)
    for b in range(n_blocks):
        number = np.float32(b)
        at = b * (ROWS * GROUPS)
        for j in range(GROUPS):
            trace = t0 * blocks[at + j] + t1 * blocks[at + GROUPS + j] + t2 * blocks[at + 2 * GROUPS + j]
            trace += t3 * blocks[at + 3 * GROUPS + j] + t4 * blocks[at + 4 * GROUPS + j]
            trace += t5 * blocks[at + 5 * GROUPS + j] + t6 * blocks[at + 6 * GROUPS + j]
            trace += t7 * blocks[at + 7 * GROUPS + j] + t8 * blocks[at + 8 * GROUPS + j]
            score = blocks[at + 9 * GROUPS + j] - trace
            better = score < best[j]
            best[j] = score if better else best[j]
            best[GROUPS + j] = number if better else best[GROUPS + j]
    for j in range(GROUPS):
        i = int(best[GROUPS + j]) * GROUPS + j
        score = max((best[j] + level) * SCALE, np.float32(0.0))
        keys[lane, j] = (np.int64(score) << SAMPLE_BITS) | numbers[i] if best[j] < _FAR_OFF else OUT
        group_codes[lane, j] = codes[i]


@compiled
def leave_out(code, lane, keys, group_codes):
    """Leave groups whose sample is alike ``code`` out of row ``lane`` of ``keys``, and return the least key left."""
    best = OUT
    for j in range(keys.shape[1]):
        other = group_codes[lane, j]
        alike = (((code + _ALIKES) | _HIGH) - other) & (((other + _ALIKES) | _HIGH) - code) & _HIGH
        key = OUT if alike == _HIGH else keys[lane, j]
        keys[lane, j] = key
        best = min(best, key)
    return best
