"""Makes a bag whole again whose writer was killed."""

from __future__ import annotations

import os
from pathlib import Path

from mobo_core.bag.files import write_metadata
from mobo_core.bag.reader import FileContent, first_record, read_bag, read_file
from mobo_core.bag.writer import McapFile, custom_data


def recover_file(content: FileContent, record: dict[str, str]) -> FileContent:
    """Rewrite a file that does not end properly with all of its whole messages; return the new content.

    ``record`` is the study's, for a file that was cut off before its own. The new file takes the place of
    the old one in one step. A file damaged in its middle, not just cut off, is kept beside it as ``….damaged``.
    """
    path = content.path
    part = path.with_suffix(".recovering")
    part.unlink(missing_ok=True)
    whole = McapFile(part, content.record or record)
    for entry in content.entries:
        whole.write(entry.topic, entry.kind, entry.data, entry.time_ns)
    whole.finish()
    if not content.cut_off:
        os.link(path, _unused(path.with_suffix(".mcap.damaged")))
    os.replace(part, path)
    return read_file(path)


def recover_bag(folder: Path) -> list[tuple[FileContent, FileContent]]:
    """Make every file of a bag whole and write metadata.yaml anew; return (before, after) of the files mended.

    Raises:
        InputError: no bag.
        StudyError: no room.
    """
    contents = read_bag(folder)
    mended = []
    for i, content in enumerate(contents):
        if not content.finished:
            contents[i] = recover_file(content, first_record(contents))
            mended.append((content, contents[i]))
    finish_bag(folder, contents)
    return mended


def finish_bag(folder: Path, contents: list[FileContent]) -> None:
    """Write metadata.yaml for files that are whole."""
    if folder.is_dir():
        write_metadata(folder, [content.summary() for content in contents], custom_data(first_record(contents)))


def _unused(path: Path) -> Path:
    candidate, number = path, 1
    while candidate.exists():
        number += 1
        candidate = path.with_name(f"{path.name}{number}")
    return candidate
