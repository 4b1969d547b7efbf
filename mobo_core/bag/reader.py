"""Reads the messages of a bag in order, up to where it is damaged."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from mcap.exceptions import EndOfFile, McapError
from mcap.records import Channel, Footer, Header, Message, Metadata, Schema
from mcap.stream_reader import CRCValidationError, StreamReader

from mobo_core.bag.files import FileSummary, bag_files
from mobo_core.bag.writer import STUDY_RECORD
from mobo_core.errors import InputError

_MAX_RECORD_BYTES = 256_000_000
# The end of an MCAP file: opcode, length, two offsets, their CRC; the CRC and the magic bytes.
_FOOTER_BYTES, _AFTER_CRC_BYTES = 1 + 8 + 8 + 8 + 4 + 8, 4 + 8


class Entry(NamedTuple):
    """One message of a bag.

    Attributes:
        topic: full name, such as ``/candidates``.
        kind: of the message, such as ``Candidate``; the full type name if it is not one of mobo's.
        time_ns: when it was recorded, ns since the epoch.
        data: CDR bytes.
    """

    topic: str
    kind: str
    time_ns: int
    data: bytes


@dataclass
class FileContent:
    """One file as far as it can be read.

    Attributes:
        path: the file.
        entries: its whole messages.
        record: the metadata record ``mobo``.
        finished: whether it ends as an MCAP file should.
        fault: what is wrong with it, or "".
        cut_off: whether the fault is no more than a missing end.
    """

    path: Path
    entries: list[Entry] = field(default_factory=list)
    record: dict[str, str] = field(default_factory=dict)
    finished: bool = False
    fault: str = ""
    cut_off: bool = False

    def summary(self) -> FileSummary:
        """Return what metadata.yaml says of the file."""
        summary = FileSummary(self.path.name)
        for entry in self.entries:
            summary.add(entry.topic, entry.kind, entry.time_ns)
        return summary


def read_file(path: Path) -> FileContent:
    """Read one MCAP file: every whole message before its end or its first damage.

    Raises:
        InputError: not an MCAP file, or not readable at all.
    """
    content = FileContent(path)
    try:
        with path.open("rb") as stream:
            _read(stream, content)
    except OSError as error:
        raise InputError(error.strerror or str(error), where=str(path), expected="a readable file") from None
    return content


def _read(stream: object, content: FileContent) -> None:
    names: dict[int, str] = {}
    channels: dict[int, tuple[str, str]] = {}
    started = False
    reader = StreamReader(stream, validate_crcs=True, record_size_limit=_MAX_RECORD_BYTES)  # type: ignore[arg-type]
    try:
        for record in reader.records:
            started = True
            if isinstance(record, Schema):
                names[record.id] = record.name.removeprefix("mobo_msgs/msg/")
            elif isinstance(record, Channel):
                channels[record.id] = (record.topic, names.get(record.schema_id, ""))
            elif isinstance(record, Message):
                topic, kind = channels[record.channel_id]
                content.entries.append(Entry(topic, kind, record.log_time, record.data))
            elif isinstance(record, Metadata) and record.name == STUDY_RECORD:
                content.record = dict(record.metadata)
            elif isinstance(record, Footer):
                _check_summary(content.path, record)
                content.finished = True
            elif isinstance(record, Header) and record.profile not in ("ros2", ""):
                raise InputError(f"profile {record.profile!r}", where=str(content.path), expected="a ROS 2 bag")
    except InputError:
        raise
    except Exception as error:  # damage shows as whatever the parser meets
        # Nothing at all: its writer was killed between making the file and the first flush.
        if not started and content.path.stat().st_size:
            raise InputError("not an MCAP file", where=str(content.path), expected="a bag") from None
        # The magic bytes after the footer are missing if nothing but the end is.
        content.cut_off = isinstance(error, EndOfFile)
        content.finished = False
        detail = str(error) if isinstance(error, McapError) and str(error) else type(error).__name__
        content.fault = "cut off" if content.cut_off else f"damaged ({detail:.100})"


def read_bag(folder: Path | str) -> list[FileContent]:
    """Read all files of a bag.

    Raises:
        InputError: no bag, or a file of it is none.
    """
    return [read_file(path) for path in bag_files(folder)]


def _check_summary(path: Path, footer: Footer) -> None:
    """Raise CRCValidationError if the index behind the messages is damaged, which the stream reader passes over."""
    if not footer.summary_crc:
        return
    data = path.read_bytes()[footer.summary_start or -_FOOTER_BYTES : -_AFTER_CRC_BYTES]
    if zlib.crc32(data) != footer.summary_crc:
        raise CRCValidationError(footer.summary_crc, zlib.crc32(data), footer)


def first_record(contents: list[FileContent]) -> dict[str, str]:
    """Return the study's record: that of the first file that got so far, or an empty one."""
    return next((content.record for content in contents if content.record), {})


def entries(contents: list[FileContent]) -> Iterator[Entry]:
    """Return all messages in the order they were written."""
    for content in contents:
        yield from content.entries
