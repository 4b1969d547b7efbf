"""Whether an answer or a heartbeat makes sense, whoever sent it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from mobo_core.errors import InputError
from mobo_core.messages import decode, message_type
from mobo_core.search.dispatch import Dispatch

# A heartbeat of so many workers, each with a candidate, is far smaller than so many bytes.
MAX_WORKERS = 10_000
MAX_HEARTBEAT_BYTES = 1_000_000
MAX_NAME = 255


def evaluation_fault(evaluation: Any, n_voxels: int) -> str:
    """Return what is wrong with the values of an Evaluation, or ""."""
    for name in ("voxel_reach", "voxel_torque", "voxel_torque_sd", "voxel_out_of_range", "voxel_not_converged",
                 "voxel_in_collision"):  # fmt: skip
        values = getattr(evaluation, name)
        if len(values) != n_voxels:
            return f"{name} has {len(values)} entries, not {n_voxels}"
        if not np.all(np.isfinite(values)) or np.any(values < 0):
            return f"{name} holds a number that is negative or not finite"
    if np.any(evaluation.voxel_reach > 1):
        return "voxel_reach above 1"
    for total, part in (("reach", "voxel_reach"), ("torque", "voxel_torque")):
        value, parts = getattr(evaluation, total), math.fsum(getattr(evaluation, part))
        if not math.isfinite(value) or abs(value - parts) > 1e-9 * max(1.0, parts):
            return f"{total} is {value!r}, but {part} adds up to {parts!r}"
    return ""


def is_good(evaluation: Any, n_voxels: int) -> bool:
    """Return whether an Evaluation carries values that may be told."""
    return evaluation.status == message_type("Evaluation").OK and not evaluation_fault(evaluation, n_voxels)


def claim_of(evaluation: Any, n_voxels: int) -> tuple[Dispatch, bool, str]:
    """Return which sending an Evaluation answers, whether its trial may be told from it, and what is wrong with it."""
    kinds = message_type("Evaluation")
    fault = evaluation_fault(evaluation, n_voxels) if evaluation.status == kinds.OK else ""
    ok = not fault and evaluation.status in (kinds.OK, kinds.REJECTED)
    return Dispatch(int(evaluation.trial), int(evaluation.attempt), evaluation.evaluator), ok, fault


def read_heartbeat(data: bytes) -> Any:
    """Return the EvaluatorStatus that CDR bytes hold.

    Raises:
        InputError: the bytes are not one, or one that no evaluator sends.
    """
    where = "heartbeat"
    if len(data) > MAX_HEARTBEAT_BYTES:
        raise InputError(f"{len(data)} bytes", where=where, expected=f"at most {MAX_HEARTBEAT_BYTES} bytes")
    status = decode("EvaluatorStatus", data)
    name = status.evaluator
    if not name or len(name) > MAX_NAME or not name.isprintable():
        raise InputError(f"evaluator {name[:40]!r}", where=where, expected=f"a name of 1 to {MAX_NAME} characters")
    if not 0 < status.workers <= MAX_WORKERS:
        raise InputError(f"{name}: {status.workers} workers", where=where, expected=f"1 to {MAX_WORKERS}")
    if not len(status.studies) == len(status.trials) == len(status.attempts):
        raise InputError(f"{name}: studies, trials, attempts of different lengths", where=where, expected="equal ones")
    return status
