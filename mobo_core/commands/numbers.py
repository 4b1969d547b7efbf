"""Numbers as arguments of commands."""

from __future__ import annotations

import math

from mobo_core.errors import InputError


def numbers_of(text: str, where: str, count: int | None = None) -> tuple[float, ...]:
    """Return comma-separated numbers.

    Raises:
        InputError: they are none, or not finite, or not ``count``.
    """
    try:
        found = tuple(map(float, text.split(",")))
    except ValueError:
        found = ()
    if not found or not all(map(math.isfinite, found)) or (count is not None and len(found) != count):
        expected = "a finite number" if count == 1 else "finite numbers, such as 0.1,0.2,0.3"
        raise InputError(repr(text)[:80], where=where, expected=expected)
    return found
