"""What time it is, for stamps and records; a simulation says it itself."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_clock: ContextVar[Callable[[], int]] = ContextVar("clock", default=time.time_ns)


def now_ns() -> int:
    """Return the time in ns since the epoch."""
    return _clock.get()()


@contextmanager
def told_by(clock: Callable[[], int]) -> Iterator[None]:
    """Take the time from ``clock``, as long as the context lasts."""
    token = _clock.set(clock)
    try:
        yield
    finally:
        _clock.reset(token)
