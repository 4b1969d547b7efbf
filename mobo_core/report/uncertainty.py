"""How sure the values of a study are: poses are a sample, and so are voxels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mobo_core.bag.record import StudyRecord
from mobo_core.report.once import once
from mobo_core.report.row import Row
from mobo_core.report.table import StudyTable
from mobo_core.search.front import pareto_front

Array = NDArray[np.float64]

RESAMPLES = 200
_MOST = 600  # arms resampled: the front, and those nearest to it
_SEED = 0


def standard_errors(study: StudyRecord, rows: Sequence[Row]) -> tuple[Array, Array]:
    """Return the standard errors of reach (voxels) and torque (N m) of arms: that of drawing other poses.

    Of a voxel's poses a share p was reached, k of them, with a torque of standard deviation s: it adds p (1 - p) / n
    and s^2 / k to the variances. NaN of arms without their voxels.
    """
    variance = np.full((2, len(rows)), np.nan)
    for i, row in enumerate(rows):
        parts = _variances(study, row)
        if parts is not None:
            variance[:, i] = parts.sum(axis=1)
    return np.sqrt(variance[0]), np.sqrt(variance[1])


def _variances(study: StudyRecord, row: Row) -> Array | None:
    answer = study.accepted(row.trial)
    if answer is None:
        return None
    n = study.settings.spec.poses_per_voxel
    p = answer.voxel_reach
    deviation = answer.voxel_torque_sd.astype(float)
    return np.array([p * (1 - p) / n, deviation * deviation / np.maximum(p * n, 1.0)])


@dataclass(frozen=True)
class Steadiness:
    """How often an arm is on the front when voxels and poses are drawn anew.

    Attributes:
        row: the arm.
        share: of the resamples in which it is on the front.
    """

    row: Row
    share: float


@once
def steadiness(study: StudyRecord, table: StudyTable) -> list[Steadiness]:
    """Return how steady the arms of the front are, and those near it, by falling share; others are left out.

    A bootstrap: of the voxels as many are drawn, with replacement, the same for all arms; and to each arm is added
    what other poses in them would change, see :func:`standard_errors`. Objectives beyond reach and torque stay as
    they are. Efron and Tibshirani, An Introduction to the Bootstrap, 1993.
    """
    rows = [row for row in near_front(table) if study.accepted(row.trial) is not None]
    if not rows:
        return []
    answers = [study.accepted(row.trial) for row in rows]
    means = np.array([[a.voxel_reach, a.voxel_torque] for a in answers if a is not None])  # (arms, 2, voxels)
    variances = np.array([_variances(study, row) for row in rows])
    chance = np.random.default_rng(_SEED)
    n = means.shape[2]
    counts = np.zeros(len(rows), int)
    names = study.settings.objectives
    values = np.array([row.values for row in rows])
    for weights in chance.multinomial(n, np.full(n, 1 / n), RESAMPLES):
        drawn = means @ weights + np.sqrt(variances @ weights) * chance.standard_normal((len(rows), 2))
        resampled = values.copy()
        for k, name in enumerate(("reach", "torque")):
            if name in names:
                resampled[:, names.index(name)] = drawn[:, k]
        counts[pareto_front(resampled.tolist(), table.aims)] += 1
    found = [Steadiness(row, float(count) / RESAMPLES) for row, count in zip(rows, counts, strict=True) if count]
    return sorted(found, key=lambda one: (-one.share, -one.row.reach, one.row.trial))


def near_front(table: StudyTable) -> list[Row]:
    """Return the front above the reach floor, then the fronts of what is left, up to a number of arms."""
    rest = [row for row in table.complete if row.above_floor]
    near: list[Row] = []
    while rest and len(near) < _MOST:
        front = set(pareto_front([row.values for row in rest], table.aims))
        near += [rest[i] for i in sorted(front)]
        rest = [row for i, row in enumerate(rest) if i not in front]
    return near[:_MOST]
