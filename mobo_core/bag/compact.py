"""Writes a bag anew as one file of large chunks: every message as it was, in two thirds of the room."""

from __future__ import annotations

import contextlib
import ctypes
import os
from collections.abc import Iterable
from pathlib import Path

from mobo_core.bag.chain import beginning
from mobo_core.bag.files import METADATA_FILE, bag_files, write_metadata
from mobo_core.bag.lock import LOCK_FILE
from mobo_core.bag.reader import Entry, FileContent, first_record, stream, with_sessions
from mobo_core.bag.recover import read_through
from mobo_core.bag.writer import CHUNK_BYTES, McapFile, custom_data
from mobo_core.errors import InputError, StudyError

_AT_FDCWD, _RENAME_EXCHANGE = -100, 2


def compact_bag(folder: Path) -> tuple[int, int]:
    """Put one file in the place of a bag's files; return their bytes before and after.

    The new bag is written beside the old one, brought to disk, compared with it, and then changes places with
    it in one step: at any moment the folder holds the whole old bag or the whole new one. Whatever else is in
    the folder stays in it. The caller holds the bag's lock.

    Raises:
        InputError: no bag, or one that is not whole; something else has the new file's name.
        StudyError: no room, or a file system on which folders cannot change places; the old bag is as it was.
    """
    folder, contents = whole_bag(folder)
    chain = beginning("compacted", files=str(len(contents)), was=contents[-1].digest)
    before = sum(content.path.stat().st_size for content in contents)
    written = rewrite_bag(folder, first_record(contents), with_sessions(c.path for c in contents), chain)
    return before, written.stat().st_size


def rewrite_bag(
    folder: Path,
    record: dict[str, str],
    messages: Iterable[tuple[dict[str, str], Entry]],
    chain: dict[str, str],
    keep_as: Path | None = None,
) -> Path:
    """Put one file of (record of its session, message) in the place of a bag's files; return its path.

    See :func:`compact_bag`, also for errors. ``keep_as``: where the old bag goes to, instead of being removed.
    """
    new = _aside(folder)
    _clear(new, folder)
    new.mkdir()
    kept = None
    try:
        file = McapFile(new / f"{folder.name}_0.mcap", record, CHUNK_BYTES, chain=chain)
        digest, said = [], record
        for session, entry in messages:
            if session != said:
                file.session(said := session)
            file.copy(entry.channel, entry.data, entry.time_ns)
            digest.append(hash(entry))
        file.finish()
        written = FileContent(file.path)
        if [hash(entry) for entry in stream(written)] != digest or not written.finished:
            raise StudyError(f"{file.path}: does not read back as it was written; {folder} is as it was")
        write_metadata(new, [file.summary], custom_data(record))
        for path in (new / METADATA_FILE, new):
            _sync(path)
        _exchange(new, folder)
        kept = keep_as
        _sync(folder.parent)
    finally:
        _clear(new, folder, kept)
    return folder / file.path.name


def whole_bag(folder: Path) -> tuple[Path, list[FileContent]]:
    """Return a bag's folder without links, and its files, read through; one NAME_0.mcap may take their place.

    Raises:
        InputError: they are not whole, or something else has that name.
    """
    if folder.is_file():
        raise InputError("is a file", where=str(folder), expected="the folder of a bag")
    folder = folder.resolve()
    files = bag_files(folder)
    contents = list(map(read_through, files))
    for content in contents:
        if not content.finished:
            expected = f"a whole bag; mobo bag recover {folder} makes it one"
            raise InputError(content.fault or "cut off", where=str(content.path), expected=expected)
    first = folder / f"{folder.name}_0.mcap"
    if first not in files and os.path.lexists(first):
        raise InputError("is no file of this bag", where=str(first), expected="another place for it")
    return folder, contents


def _aside(folder: Path) -> Path:
    new = folder.with_name(f".{folder.name}.compacting")
    if new.is_symlink() or (new.exists() and not new.is_dir()):
        raise InputError("is a link or a file", where=str(new), expected="nothing there")
    return new


def _clear(aside: Path, folder: Path, keep_as: Path | None = None) -> None:
    """Remove the bag that stands aside, or keep it elsewhere; what is not of the bag moves into the folder first."""
    if not aside.is_dir():
        return
    own = {METADATA_FILE, LOCK_FILE}
    with contextlib.suppress(InputError):
        files = bag_files(aside, folder.name)
        own |= {path.name for path in files} | {path.with_suffix(".recovering").name for path in files}
    for entry in aside.iterdir():
        if entry.name not in own:
            if os.path.lexists(folder / entry.name):
                raise StudyError(f"{entry}: is in {folder} too; move one of them away")
            os.rename(entry, folder / entry.name)
    if keep_as is not None:
        os.rename(aside, keep_as)
        return
    for entry in aside.iterdir():
        entry.unlink()
    aside.rmdir()


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
