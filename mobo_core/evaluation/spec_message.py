"""The spec as it travels: the message ``EvaluationSpec``."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from mobo_core.errors import InputError, UnableError
from mobo_core.evaluation.spec import MAX_BOXES, MOST_RULES, EvaluationSpec
from mobo_core.messages import SpecMessage
from mobo_core.messages.types import Floats

# Fields that are reserved: what they hold in a question that asks nothing of them.
_RESERVED = ("target_poses",)
_NEUTRAL = SpecMessage()


def spec_to_message(spec: EvaluationSpec) -> SpecMessage:
    """Return a spec as the message ``EvaluationSpec``."""
    boxes = [(*box.centre, *box.rpy, *box.size) for box in spec.obstacles]
    values: dict[str, Any] = {**spec.model_dump(), "obstacles": np.array(boxes).ravel()}
    if spec.floor_z is None:
        values["floor_z"] = -math.inf
    return SpecMessage(**values)


def spec_from_message(message: SpecMessage) -> EvaluationSpec:
    """Return the spec that a message holds, checked.

    Raises:
        UnableError: a reserved field asks for something, or the rules are newer ones.
        InputError: a field that does not fit.
    """
    for name in _RESERVED:
        asked, neutral = np.asarray(getattr(message, name)), np.asarray(getattr(_NEUTRAL, name))
        if not np.array_equal(asked, neutral):
            expected = f"{neutral.tolist()}, all that this version knows"
            raise UnableError(f"{name} = {asked.tolist()!s:.60}", where="spec", expected=expected)
    values: dict[str, Any] = {}
    for name in EvaluationSpec.model_fields:
        value = getattr(message, name)
        if name == "obstacles":
            values[name] = _boxes(value)
            continue
        values[name] = value.tolist() if isinstance(value, np.ndarray) else value
    if message.floor_z == -math.inf:
        values["floor_z"] = None
    values["rules"] = message.rules or 1
    if message.rules > MOST_RULES:
        raise UnableError(f"rules = {message.rules}", where="spec", expected=f"at most {MOST_RULES}")
    return EvaluationSpec.of(values, where="spec")


def _boxes(flat: Floats) -> list[dict[str, list[float]]]:
    """Return the boxes of 9 numbers each, sizes checked before anything is made of them."""
    if len(flat) % 9 or len(flat) > 9 * MAX_BOXES:
        expected = f"9 of each box, of {MAX_BOXES} boxes at most"
        raise InputError(f"obstacles of {len(flat)} numbers", where="spec", expected=expected)
    rows = flat.reshape(-1, 3, 3).tolist()
    return [{"centre": centre, "rpy": rpy, "size": size} for centre, rpy, size in rows]
