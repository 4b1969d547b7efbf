"""The lock an optimizer holds on its bag; it ends with the process, however that ends."""

from __future__ import annotations

import errno
import fcntl
import json
import os
import socket
import stat
from pathlib import Path
from typing import IO

from mobo_core.errors import InputError, InUseError

LOCK_FILE = ".lock"
MAX_LOCK_BYTES = 10_000


class BagLock:
    """Held from construction to :meth:`release`.

    Args:
        folder: of the bag.
        node: who holds it, for those who do not get it.
        make: make the folder if there is none.

    Raises:
        InUseError: another process holds it; says which (node, host, pid).
        InputError: what stands in the lock's place is not one.
        OSError: no such folder, or it cannot be made or written to.
    """

    def __init__(self, folder: Path, node: str, *, make: bool = False) -> None:
        path = folder / LOCK_FILE
        while True:
            if make:
                folder.mkdir(parents=True, exist_ok=True)
            self._file: IO[str] = open_lock(path, make=True)
            try:
                fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                mine, there = os.fstat(self._file.fileno()), os.stat(path)
                if (mine.st_dev, mine.st_ino) == (there.st_dev, there.st_ino):
                    break
            except FileNotFoundError:
                pass  # the holder has gone, and the bag with it, because nothing was recorded
            except OSError:
                self._file.seek(0)
                holder = holder_name(self._file.read(MAX_LOCK_BYTES))
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


def open_lock(path: Path, *, make: bool = False) -> IO[str]:
    """Open a lock file, to read it or (``make``) to hold it; never what a link leads to, or a pipe.

    Raises:
        InputError: what is there is no plain file.
        OSError: it cannot be opened.
    """
    flags = os.O_RDWR | os.O_APPEND | os.O_CREAT if make else os.O_RDONLY
    try:
        descriptor = os.open(path, flags | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC, 0o666)
    except OSError as error:
        if error.errno in (errno.ELOOP, errno.ENXIO):
            raise _no_lock(path) from None
        raise
    there = os.fstat(descriptor)
    if not stat.S_ISREG(there.st_mode) or there.st_nlink > 1:
        os.close(descriptor)
        raise _no_lock(path)
    return os.fdopen(descriptor, "a+" if make else "r", encoding="utf-8", errors="replace")


def _no_lock(path: Path) -> InputError:
    return InputError("is a link, a pipe or the like", where=str(path), expected="a lock file, or none")


def holder_name(text: str) -> str:
    """Return who a lock file names."""
    try:
        who: dict[str, object] = json.loads(text)
        return f"{who['node']!s:.200} on {who['host']!s:.200}, pid {who['pid']!s:.20}"
    except (ValueError, KeyError, TypeError, RecursionError):
        return "another process"
