"""The lock an optimizer holds on its bag; it ends with the process, however that ends."""

from __future__ import annotations

import fcntl
import json
import os
import socket
from pathlib import Path
from typing import IO

from mobo_core.errors import InUseError

LOCK_FILE = ".lock"


class BagLock:
    """Held from construction to :meth:`release`.

    Args:
        folder: of the bag.
        node: who holds it, for those who do not get it.
        make: make the folder if there is none.

    Raises:
        InUseError: another process holds it; says which (node, host, pid).
        OSError: no such folder, or it cannot be made or written to.
    """

    def __init__(self, folder: Path, node: str, *, make: bool = False) -> None:
        path = folder / LOCK_FILE
        while True:
            if make:
                folder.mkdir(parents=True, exist_ok=True)
            self._file: IO[str] = path.open("a+", encoding="utf-8")
            try:
                fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                mine, there = os.fstat(self._file.fileno()), os.stat(path)
                if (mine.st_dev, mine.st_ino) == (there.st_dev, there.st_ino):
                    break
            except FileNotFoundError:
                pass  # the holder has gone, and the bag with it, because nothing was recorded
            except OSError:
                self._file.seek(0)
                holder = holder_name(self._file.read())
                self._file.close()
                expected = "a bag no optimizer writes to"
                raise InUseError(f"in use by {holder}", where=str(folder), expected=expected) from None
            self._file.close()
        self._file.truncate(0)
        json.dump({"node": node, "host": socket.gethostname(), "pid": os.getpid()}, self._file)
        self._file.flush()

    def release(self) -> None:
        """Give the lock back."""
        self._file.close()


def holder_name(text: str) -> str:
    """Return who a lock file names."""
    try:
        who: dict[str, object] = json.loads(text)
        return f"{who['node']} on {who['host']}, pid {who['pid']}"
    except (ValueError, KeyError, TypeError):
        return "another process"
