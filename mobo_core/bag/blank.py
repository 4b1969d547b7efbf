"""Bags of which nothing came: begun by an optimizer that ended before the first candidate was sent."""

from __future__ import annotations

import re
from pathlib import Path

from mobo_core.bag.files import METADATA_FILE
from mobo_core.bag.lock import LOCK_FILE
from mobo_core.bag.reader import FileContent, stream
from mobo_core.errors import InputError

# Who joined, left and ran; what was said before a study, not in it.
_IDLE = ("StudyStatus", "EvaluatorStatus")
# No bag of some thousand such messages is read through to say so.
_MAX_BYTES = 10_000_000


def is_blank(folder: Path) -> bool:
    """Return whether all that a folder holds is a bag in which nothing was sent, told or commanded."""
    try:
        entries = list(folder.iterdir())
        files = [entry for entry in entries if _is_file_of(folder, entry)]
        known = {LOCK_FILE, METADATA_FILE, *(file.name for file in files)}
        if not files or any(entry.name not in known for entry in entries):
            return False
        return sum(file.stat().st_size for file in files) <= _MAX_BYTES and all(map(_is_idle, files))
    except (OSError, InputError):
        return False


def clear_blank(folder: Path) -> None:
    """Remove what :func:`is_blank` found, but for the lock."""
    for entry in folder.iterdir():
        if entry.name == METADATA_FILE or _is_file_of(folder, entry):
            entry.unlink()


def _is_file_of(folder: Path, entry: Path) -> bool:
    # A writer may also have been killed while it made such a file whole (mobo_core.bag.recover).
    return re.fullmatch(re.escape(folder.name) + r"_\d+\.(mcap|recovering)", entry.name) is not None and entry.is_file()


def _is_idle(file: Path) -> bool:
    content = FileContent(file)
    if any(entry.kind not in _IDLE for entry in stream(content)):
        return False
    # Of a file that was cut off in its first lines, there may be no more than that.
    return bool(content.record) or content.cut_off
