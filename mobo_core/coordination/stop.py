"""Whether a process shall end, as signals say."""

from __future__ import annotations

import signal
from types import FrameType


class Stop:
    """True once SIGINT or SIGTERM has come.

    The handler sets a plain attribute: it may be called while it runs, and a lock taken in it would be waited for
    by itself.
    """

    def __init__(self) -> None:
        self._asked = False
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._handle)

    def _handle(self, number: int, frame: FrameType | None) -> None:
        self._asked = True

    def __bool__(self) -> bool:
        """Return whether to stop."""
        return self._asked
