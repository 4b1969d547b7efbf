"""Writes a bag anew as one file of large chunks: every message as it was, in two thirds of the room."""

from __future__ import annotations

import ctypes
import os
import shutil
from pathlib import Path

from mobo_core.bag.files import METADATA_FILE, bag_files, write_metadata
from mobo_core.bag.lock import LOCK_FILE
from mobo_core.bag.reader import FileContent, read_record, stream
from mobo_core.bag.writer import CHUNK_BYTES, McapFile, custom_data
from mobo_core.errors import InputError, StudyError

_AT_FDCWD, _RENAME_EXCHANGE = -100, 2


def compact_bag(folder: Path) -> tuple[int, int]:
    """Put one file in the place of a bag's files; return their bytes before and after.

    The new bag is written beside the old one, brought to disk, compared with it, and then changes places with
    it in one step: at any moment the folder holds the whole old bag or the whole new one. Whatever else is in
    the folder stays in it. The caller holds the bag's lock.

    Raises:
        InputError: no bag, or one that is not whole.
        StudyError: no room, or a file system on which folders cannot change places; the old bag is as it was.
    """
    if folder.is_file():
        raise InputError("is a file", where=str(folder), expected="the folder of a bag")
    folder = folder.resolve()
    files = bag_files(folder)
    record = read_record(folder)
    new = folder.with_name(f".{folder.name}.compacting")
    _clear(new, folder)
    new.mkdir()
    try:
        file = McapFile(new / f"{folder.name}_0.mcap", record, CHUNK_BYTES)
        digest = []
        for path in files:
            content = FileContent(path)
            for entry in stream(content):
                file.copy(entry.channel, entry.data, entry.time_ns)
                digest.append(hash(entry))
            if not content.finished:
                expected = f"a whole bag; mobo bag recover {folder} makes it one"
                raise InputError(content.fault or "cut off", where=str(path), expected=expected)
        file.finish()
        written = FileContent(file.path)
        if [hash(entry) for entry in stream(written)] != digest or not written.finished:
            raise StudyError(f"{file.path}: does not read back as it was written; {folder} is as it was")
        write_metadata(new, [file.summary], custom_data(record))
        for path in (new / METADATA_FILE, new):
            _sync(path)
        before = sum(path.stat().st_size for path in files)
        _exchange(new, folder)
        _sync(folder.parent)
    finally:
        _clear(new, folder)
    return before, (folder / file.path.name).stat().st_size


def _clear(aside: Path, folder: Path) -> None:
    """Remove the bag that stands aside, after moving into the folder what is not of the bag."""
    if not aside.is_dir():
        return
    for entry in aside.iterdir():
        if entry.name not in (METADATA_FILE, LOCK_FILE) and entry.suffix not in (".mcap", ".recovering"):
            if os.path.lexists(folder / entry.name):
                raise StudyError(f"{entry}: is in {folder} too; move one of them away")
            os.rename(entry, folder / entry.name)
    shutil.rmtree(aside)


def _exchange(one: Path, other: Path) -> None:
    libc = ctypes.CDLL(None, use_errno=True)
    names = os.fsencode(one), os.fsencode(other)
    if libc.renameat2(_AT_FDCWD, names[0], _AT_FDCWD, names[1], _RENAME_EXCHANGE):
        reason = os.strerror(ctypes.get_errno())
        raise StudyError(f"{other}: cannot change places with its compacted self ({reason}); it is as it was")


def _sync(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
