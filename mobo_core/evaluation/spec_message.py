"""The spec as it travels: the message ``EvaluationSpec``."""

from __future__ import annotations

from typing import Any

import numpy as np

from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.messages import make


def spec_to_message(spec: EvaluationSpec) -> Any:
    """Return a spec as the message ``EvaluationSpec``."""
    return make("EvaluationSpec", **spec.model_dump())


def spec_from_message(message: Any) -> EvaluationSpec:
    """Return the spec that a message holds, checked.

    Raises:
        InputError: a field that does not fit.
    """
    values = {}
    for name in EvaluationSpec.model_fields:
        value = getattr(message, name)
        values[name] = value.tolist() if isinstance(value, np.ndarray) else value
    return EvaluationSpec.of(values, where="spec")
