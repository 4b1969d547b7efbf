"""The lock an optimizer holds on its bag; it ends with the process, however that ends."""

from __future__ import annotations

import fcntl
import json
import os
import socket
from pathlib import Path
from typing import IO, Any

from mobo_core.errors import InputError

LOCK_FILE = ".lock"


class BagLock:
    """Held from construction to :meth:`release`.

    Raises:
        InputError: another process holds it; says which (node, host, pid).
    """

    def __init__(self, folder: Path, node: str) -> None:
        self._file: IO[str] = (folder / LOCK_FILE).open("a+", encoding="utf-8")
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            holder = self._holder()
            self._file.close()
            expected = "a bag no optimizer writes to"
            raise InputError(f"in use by {holder}", where=str(folder), expected=expected) from None
        self._file.truncate(0)
        json.dump({"node": node, "host": socket.gethostname(), "pid": os.getpid()}, self._file)
        self._file.flush()

    def _holder(self) -> str:
        self._file.seek(0)
        try:
            who: dict[str, Any] = json.loads(self._file.read())
            return f"{who['node']} on {who['host']}, pid {who['pid']}"
        except (ValueError, KeyError, TypeError):
            return "another process"

    def release(self) -> None:
        """Give the lock back."""
        self._file.close()
