"""Trials from a record, as Optuna's: a study of many goes on after a moment.

Optuna copies a trial whenever it is added and told, distributions and all; these copies share what never changes.
"""

from __future__ import annotations

import copy
from datetime import datetime
from functools import lru_cache
from typing import Any, cast

from optuna.distributions import BaseDistribution, CategoricalDistribution, FloatDistribution
from optuna.trial import BaseTrial, FrozenTrial, TrialState

from mobo_core.design import Design, DesignSpace
from mobo_core.errors import InputError

_float = lru_cache(maxsize=4096)(FloatDistribution)
_categorical = lru_cache(maxsize=256)(CategoricalDistribution)


class RecalledTrial(FrozenTrial):
    """A trial whose copies share parameters and distributions, which Optuna replaces and never changes."""

    def __deepcopy__(self, memo: dict[int, Any]) -> RecalledTrial:
        return copy.copy(self)


def recalled(space: DesignSpace, params: dict[str, Any], where: str) -> tuple[Design, RecalledTrial]:
    """Return the design of parameters that a record holds, and the running trial that drew them.

    Raises:
        InputError: they are none of the space; ``where`` they were found.
    """
    known = _Known(params)
    try:
        design = space.suggest(cast(BaseTrial, known))
        if len(params) != len(known.distributions):
            raise ValueError(f"parameters {sorted(params.keys() - known.distributions.keys())} too many")
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError, InputError) as error:
        raise InputError(f"not readable ({error!r:.80})", where=where, expected="parameters of the space") from None
    trial = RecalledTrial(
        number=-1, trial_id=-1, state=TrialState.RUNNING, value=None, datetime_start=datetime.now(),
        datetime_complete=None, params=params, distributions=known.distributions, user_attrs={}, system_attrs={},
        intermediate_values={},
    )  # fmt: skip
    return design, trial


class _Known:
    """Stands in for a trial whose parameters are known, and notes what they would have been drawn from."""

    def __init__(self, params: dict[str, Any]) -> None:
        self._params = params
        self.distributions: dict[str, BaseDistribution] = {}

    def suggest_categorical(self, name: str, choices: tuple[str, ...]) -> str:
        value = self._params[name]
        if not isinstance(value, str) or value not in choices:
            raise ValueError(f"{name} is {value!r:.20}")
        self.distributions[name] = _categorical(choices)
        return value

    def suggest_float(self, name: str, low: float, high: float) -> float:
        value = self._params[name]
        if not isinstance(value, int | float) or not low <= value <= high:
            raise ValueError(f"{name} is {value!r:.20}")
        self.distributions[name] = _float(low, high)
        return value
