"""Analyses that several parts of a report ask for are done once for each table."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

from mobo_core.report.table import StudyTable

P = ParamSpec("P")
T = TypeVar("T")


def once(function: Callable[P, T]) -> Callable[P, T]:
    """Have a function of a table (and of the study it is of) keep what it returns for that table."""

    @wraps(function)
    def kept(*args: P.args, **kwargs: P.kwargs) -> T:
        table = next(argument for argument in args if isinstance(argument, StudyTable))
        memo: dict[str, T] = table.__dict__.setdefault("_once", {})
        name = f"{function.__module__}.{function.__qualname__}"
        if name not in memo:
            memo[name] = function(*args, **kwargs)
        return memo[name]

    return kept
