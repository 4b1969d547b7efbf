"""The spec as it travels: the message ``EvaluationSpec``."""

from __future__ import annotations

import numpy as np

from mobo_core.errors import UnableError
from mobo_core.evaluation.spec import MOST_RULES, EvaluationSpec
from mobo_core.messages import SpecMessage

# Fields that are reserved: what they hold in a question that asks nothing of them.
_RESERVED = ("floor_z", "obstacles", "target_poses")
_NEUTRAL = SpecMessage()


def spec_to_message(spec: EvaluationSpec) -> SpecMessage:
    """Return a spec as the message ``EvaluationSpec``."""
    return SpecMessage(**spec.model_dump())


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
    values = {}
    for name in EvaluationSpec.model_fields:
        value = getattr(message, name)
        values[name] = value.tolist() if isinstance(value, np.ndarray) else value
    values["rules"] = message.rules or 1
    if message.rules > MOST_RULES:
        raise UnableError(f"rules = {message.rules}", where="spec", expected=f"at most {MOST_RULES}")
    return EvaluationSpec.of(values, where="spec")
