"""What killed DDS programs leave in /dev/shm, and taking it away."""

from __future__ import annotations

import contextlib
import fcntl
import re
import time
from pathlib import Path

SHM_FOLDER = Path("/dev/shm")

# Beside every segment and port Fast DDS keeps a file whose lock its owner holds for as long as it lives.
_LOCK = re.compile(r"(fastrtps_(?:[0-9a-f]{16}|port\d{1,5}))_[es]l")
# One that was made just now may not be locked yet.
_YOUNG_S = 2.0


def clean_shared_memory(folder: Path = SHM_FOLDER, young_s: float = _YOUNG_S) -> int:
    """Remove the shared memory of Fast DDS whose owner is dead; return how many pieces that were.

    What a living program holds stays, and so does what is younger than ``young_s`` or belongs to another user.
    """
    removed = 0
    try:
        names = [path.name for path in folder.iterdir()]
    except OSError:
        return 0
    for name in names:
        if (match := _LOCK.fullmatch(name)) is None:
            continue
        with contextlib.suppress(OSError), (folder / name).open("rb") as file:
            if time.time() - (folder / name).stat().st_mtime < young_s:
                continue
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            for piece in (match[1], f"sem.{match[1]}_mutex", name):
                (folder / piece).unlink(missing_ok=True)
            removed += 1
    return removed
