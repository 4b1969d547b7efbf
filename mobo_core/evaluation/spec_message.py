"""The spec as it travels: the message ``EvaluationSpec``."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from mobo_core.errors import InputError, UnableError
from mobo_core.evaluation.pose_file import MAX_TARGETS
from mobo_core.evaluation.spec import MAX_BOXES, MOST_RULES, EvaluationSpec
from mobo_core.messages import SpecMessage
from mobo_core.messages.types import Floats


def spec_to_message(spec: EvaluationSpec) -> SpecMessage:
    """Return a spec as the message ``EvaluationSpec``."""
    boxes = [(*box.centre, *box.rpy, *box.size) for box in spec.obstacles]
    values: dict[str, Any] = {**spec.model_dump(), "obstacles": np.array(boxes).ravel()}
    values["target_poses"] = np.array(spec.target_poses).ravel()
    if spec.floor_z is None:
        values["floor_z"] = -math.inf
    return SpecMessage(**values)


def spec_from_message(message: SpecMessage) -> EvaluationSpec:
    """Return the spec that a message holds, checked.

    Raises:
        UnableError: the rules are newer ones.
        InputError: a field that does not fit.
    """
    values: dict[str, Any] = {}
    for name in EvaluationSpec.model_fields:
        value = getattr(message, name)
        if name == "obstacles":
            rows = _rows(name, value, 9, MAX_BOXES).reshape(-1, 3, 3).tolist()
            values[name] = [{"centre": centre, "rpy": rpy, "size": size} for centre, rpy, size in rows]
            continue
        if name == "target_poses":
            values[name] = _rows(name, value, 6, MAX_TARGETS).tolist()
            continue
        values[name] = value.tolist() if isinstance(value, np.ndarray) else value
    if message.floor_z == -math.inf:
        values["floor_z"] = None
    values["rules"] = message.rules or 1
    if message.rules > MOST_RULES:
        raise UnableError(f"rules = {message.rules}", where="spec", expected=f"at most {MOST_RULES}")
    return EvaluationSpec.of(values, where="spec")


def _rows(name: str, flat: Floats, width: int, most: int) -> Floats:
    """Return rows of so many numbers, their count checked before anything is made of them."""
    if len(flat) % width or len(flat) > width * most:
        raise InputError(f"{name} of {len(flat)} numbers", where="spec", expected=f"{width} of each, {most} at most")
    return flat.reshape(-1, width)
