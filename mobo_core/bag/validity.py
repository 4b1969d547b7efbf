"""Whether the values of an Evaluation make sense, whoever sent it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from mobo_core.errors import InputError
from mobo_core.messages import KINDS, Candidate, Evaluation, Message, Trial
from mobo_core.search.study import StudySettings

_MAX_NAME = 4096  # paths may be as long
_MAX_LENGTHS = 100
_TEXTS = ("study", "evaluator", "sampled_joints", "joints", "tip", "engine", "command", "source", "mobo_version",
          "host_id", "kernel_hash", "bag")  # fmt: skip
_NAMES = {kind: [name for name in _TEXTS if name in cls.__annotations__] for kind, cls in KINDS.items()}
_VOXELS = ("voxel_reach", "voxel_torque", "voxel_torque_sd", "voxel_out_of_range", "voxel_not_converged",
           "voxel_in_collision")  # fmt: skip


def check_plain(message: Message, where: str) -> None:
    """See that a message of a bag holds no name and no arm that no mobo ever wrote.

    Raises:
        InputError: a name of many kilobytes, or lengths that are too many or no numbers.
    """
    for name in _NAMES[message.kind]:
        if len(value := getattr(message, name)) > _MAX_NAME:
            raise InputError(f"{name} of {len(value):,} characters", where=where, expected=f"at most {_MAX_NAME}")
    if isinstance(message, Candidate):
        n = len(message.lengths)
        if n > _MAX_LENGTHS or not np.isfinite(message.lengths).all():
            at = f"{where}: candidate of trial {message.trial}"
            raise InputError(f"{n:,} lengths", where=at, expected=f"at most {_MAX_LENGTHS}, finite ones")


def evaluation_fault(evaluation: Evaluation, n_voxels: int, objectives: Sequence[str] = ()) -> str:
    """Return what is wrong with the values of an Evaluation in a study of these objectives, or ""."""
    for name in _VOXELS:
        values = getattr(evaluation, name)
        if len(values) != n_voxels:
            return f"{name} has {len(values)} entries, not {n_voxels}"
        # Comparisons with NaN are false.
        if n_voxels and not (values.min() >= 0 and values.max() < math.inf):
            return f"{name} holds a number that is negative or not finite"
    if n_voxels and evaluation.voxel_reach.max() > 1:
        return "voxel_reach above 1"
    for total, part in (("reach", "voxel_reach"), ("torque", "voxel_torque")):
        value, parts = getattr(evaluation, total), math.fsum(getattr(evaluation, part))
        if not math.isfinite(value) or abs(value - parts) > 1e-9 * max(1.0, parts):
            return f"{total} is {value!r}, but {part} adds up to {parts!r}"
    for name, value in zip(objectives, values_of(evaluation, objectives), strict=True):
        if not math.isfinite(value):
            return f"no finite {name}"
    return ""


def is_good(evaluation: Evaluation, settings: StudySettings) -> bool:
    """Return whether an Evaluation carries values that may be told in a study of these settings."""
    return evaluation.status == Evaluation.OK and not evaluation_fault(
        evaluation, settings.spec.n_voxels, settings.objectives
    )


def values_of(message: Evaluation | Trial, objectives: Sequence[str]) -> tuple[float, ...]:
    """Return the values of these objectives that a message holds, NaN for one that it lacks."""
    known = {"reach": message.reach, "torque": message.torque}
    extra = zip(message.extra_names, message.extra_values, strict=False)
    known |= {name: float(value) for name, value in extra if name not in known}
    return tuple(known.get(name, math.nan) for name in objectives)
