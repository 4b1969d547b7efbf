"""Makes a bag whole again whose writer was killed."""

from __future__ import annotations

import os
from pathlib import Path

from mobo_core.bag.chain import beginning
from mobo_core.bag.files import bag_files, write_metadata
from mobo_core.bag.reader import FileContent, first_record, stream, with_sessions
from mobo_core.bag.writer import CHUNK_BYTES, Create, McapFile, create_file, custom_data


def recover_file(
    content: FileContent,
    record: dict[str, str],
    previous: str = "",
    next_says: str = "",
    create: Create = create_file,
) -> FileContent:
    """Rewrite a file that does not end properly with all of its whole messages; return the new content.

    ``record`` is the study's, for a file that was cut off before its own. The hash chain ends before it and begins
    again: ``previous`` is the digest of the file before, ``next_says`` what the file after it takes for its digest.
    The new file takes the place of
    the old one in one step. A file damaged in its middle, not just cut off, is kept beside it as ``….damaged``,
    and so is one of whose end more is missing than a killed writer leaves.

    Raises:
        StudyError: no room; the old file is as it was.
    """
    path = content.path
    part = path.with_suffix(".recovering")
    part.unlink(missing_ok=True)
    chain = beginning("recovered", previous, **({"stands_for": next_says} if next_says else {}))
    said = content.record or record
    whole = McapFile(part, said, CHUNK_BYTES, chain=chain, create=create)
    try:
        for session, entry in with_sessions([path]):
            if session and session != said:
                whole.session(said := session)
            whole.copy(entry.channel, entry.data, entry.time_ns)
        whole.finish()
        if not content.cut_off or path.stat().st_size - content.whole_bytes > CHUNK_BYTES:
            os.link(path, _unused(path.with_suffix(".mcap.damaged")))
        os.replace(part, path)
    except BaseException:
        whole.abandon()
        raise
    return read_through(path)


def read_through(path: Path) -> FileContent:
    """Read a file to its end and keep no message."""
    content = FileContent(path)
    for _ in stream(content):
        pass
    return content


def recover_bag(folder: Path) -> list[tuple[FileContent, FileContent]]:
    """Make every file of a bag whole and write metadata.yaml anew; return (before, after) of the files mended.

    Raises:
        InputError: no bag.
        StudyError: no room.
    """
    contents = [read_through(path) for path in bag_files(folder)]
    mended = []
    for i, content in enumerate(contents):
        if not content.finished:
            previous = contents[i - 1].digest if i else ""
            next_says = contents[i + 1].chain.get("previous", "") if i + 1 < len(contents) else ""
            contents[i] = recover_file(content, first_record(contents), previous, next_says)
            mended.append((content, contents[i]))
    finish_bag(folder, contents)
    return mended


def finish_bag(folder: Path, contents: list[FileContent]) -> None:
    """Write metadata.yaml for files that are whole."""
    if folder.is_dir():
        write_metadata(folder, [content.summary for content in contents], custom_data(first_record(contents)))


def _unused(path: Path) -> Path:
    candidate, number = path, 1
    while os.path.lexists(candidate):
        number += 1
        candidate = path.with_name(f"{path.name}{number}")
    return candidate
