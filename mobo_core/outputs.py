"""Files that commands write: whole or not at all."""

from __future__ import annotations

import os
from pathlib import Path

from mobo_core.errors import InputError


def write_whole(path: Path, content: bytes | str) -> None:
    """Write a file in one piece, over an older one if there is one; missing folders are made.

    A pipe, a device or a link stays what it is, and is written to as it goes.

    Raises:
        InputError: it cannot be written there.
    """
    data = content.encode() if isinstance(content, str) else content
    try:
        if path.is_dir():
            raise InputError("is a folder", where=str(path), expected="the path of a file")
        if path.is_symlink() or (path.exists() and not path.is_file()):
            path.write_bytes(data)  # a pipe, a device or a link: not ours to replace
            return
        make_folder(path.parent)
        replace_whole(path, data)
    except OSError as error:
        raise _cannot(path, error) from None


def replace_whole(path: Path, data: bytes) -> None:
    """Put a file in the place of what is there, in one step, in a folder that is there.

    Raises:
        OSError: it cannot be written; what was there stays.
    """
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    part.unlink(missing_ok=True)  # of a process that was killed; a link is removed, not followed
    try:
        with part.open("xb") as file:
            file.write(data)
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


def make_folder(folder: Path) -> None:
    """Make a folder and those above it; one that is there already is fine.

    Raises:
        InputError: it cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise InputError("is a file", where=str(folder), expected="a folder, or a path that is free") from None
    except OSError as error:
        raise _cannot(folder, error) from None


def _cannot(path: Path, error: OSError) -> InputError:
    reason = error.strerror or str(error)
    return InputError(f"cannot be written ({reason})", where=str(path), expected="a place that can be written to")
