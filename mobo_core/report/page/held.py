"""What the page holds of the arms evaluated again: torques of their joints, and configurations."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mobo_core.report.joint_torques import HeldArm
from mobo_core.report.page.blobs import Blob, pack

# rad, or m of joints that slide, a step of the stored angles: 0.1 mm at an arm's length.
Q_STEP = math.pi / 16384
NONE = -32768
N_SHOWN = 4  # configurations of an arm, drawn at random
_MOST_ANGLES = 1_500_000  # of a configuration a voxel; for as many arms as that is room for


def held_blob(arms: Sequence[HeldArm], n_joints: int, n_voxels: int) -> tuple[Blob, int]:
    """Return the arms, packed, and of how many, the first ones, a configuration a voxel is there."""
    n_with = min(len(arms), _MOST_ANGLES // (n_joints * n_voxels))
    torques = np.full((len(arms), 3, n_joints), math.nan, np.float32)
    four = np.full((len(arms), N_SHOWN, n_joints), math.nan, np.float32)
    by_voxel = np.full((n_with, n_voxels, n_joints), NONE, np.int16)
    for i, arm in enumerate(arms):
        joints, found = arm.result.joint_torques or (), arm.result.configurations
        if len(joints) != n_joints or found is None:
            continue
        torques[i] = [[getattr(joint, name) for joint in joints] for name in ("mean", "p95", "peak")]
        drawn = _drawn(len(found.voxel), arm.row.trial)
        four[i, : len(drawn)] = found.q[drawn]
        if i < n_with:
            voxels, first = np.unique(found.voxel, return_index=True)
            by_voxel[i, voxels] = np.clip(np.rint(_turned(found.q[first]) / Q_STEP), -32767, 32767)
    same = np.array([arm.same for arm in arms], np.uint8)
    return pack({"torques": torques, "four": four, "voxel_q": by_voxel, "same": same}), n_with


def _drawn(count: int, trial: int) -> NDArray[np.int64]:
    """Return which configurations are shown, the same for a trial each time."""
    return np.random.default_rng(trial).permutation(count)[:N_SHOWN]


def _turned(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return angles within 2 pi of zero, where the stored ones end; no slide has a stroke that goes beyond."""
    return np.where(np.abs(q) <= 2 * math.pi, q, np.remainder(q, 2 * math.pi))
