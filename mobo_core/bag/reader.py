"""Reads the messages of a bag in order, up to where it is damaged."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

from mcap import records
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC

from mobo_core.bag.chain import BEGIN_RECORD, END_RECORD, Digest
from mobo_core.bag.chunks import MAX_CHUNK_BYTES, Budget, DamageError, opened
from mobo_core.bag.files import Channel, FileSummary, bag_files
from mobo_core.bag.outer import outer_records
from mobo_core.bag.writer import STUDY_RECORD
from mobo_core.errors import InputError

# A record begins with its opcode and its length. The file ends with the footer's record (two offsets and
# their CRC) and the magic bytes.
_HEAD = struct.Struct("<BQ")
_MAX_CHANNELS = 1000  # a study has six topics; the description of each is looked at
_FOOTER_BYTES, _AFTER_CRC_BYTES = _HEAD.size + 8 + 8 + 4 + 8, 4 + 8


@dataclass(frozen=True, slots=True)
class Entry:
    """One message of a bag.

    Attributes:
        topic: full name, such as ``/candidates``.
        kind: of the message, such as ``Candidate``; the full type name if it is not one of mobo's.
        time_ns: when it was recorded, ns since the epoch.
        data: CDR bytes.
        channel: how the bag describes the topic.
    """

    topic: str
    kind: str
    time_ns: int
    data: bytes
    channel: Channel


@dataclass
class FileContent:
    """One file as far as it can be read.

    Attributes:
        path: the file.
        entries: its whole messages, if they were kept.
        summary: times and counts of its whole messages.
        record: the metadata record ``mobo``.
        sessions: (number of messages before it, record) of each metadata record ``mobo``: a compacted file has one
            for each session.
        chain: what the hash chain begins with; empty in files of older trees.
        end: what the file says of itself at its end.
        digest: what its messages and records hash to, if all of them were read.
        finished: whether it ends as an MCAP file should.
        fault: what is wrong with it, or "".
        cut_off: whether the fault is no more than a missing end.
        whole_bytes: how far it can be read.
    """

    path: Path
    entries: list[Entry] = field(default_factory=list)
    summary: FileSummary = field(init=False)
    record: dict[str, str] = field(default_factory=dict)
    sessions: list[tuple[int, dict[str, str]]] = field(default_factory=list)
    chain: dict[str, str] = field(default_factory=dict)
    end: dict[str, str] = field(default_factory=dict)
    digest: str = ""
    finished: bool = False
    fault: str = ""
    cut_off: bool = False
    whole_bytes: int = 0

    def __post_init__(self) -> None:
        self.summary = FileSummary(self.path.name)


def stream(content: FileContent) -> Iterator[Entry]:
    """Yield every whole message of a file before its end or its first damage; fill in ``content`` meanwhile.

    Raises:
        InputError: not an MCAP file, or not readable at all.
    """
    try:
        with content.path.open("rb") as file:
            magic = file.read(len(MCAP0_MAGIC))
            if not MCAP0_MAGIC.startswith(magic):
                raise InputError("not an MCAP file", where=str(content.path), expected="a bag")
            file.seek(0)
            try:
                for entry in _entries(file, content):
                    content.summary.add(entry.channel, entry.time_ns)
                    yield entry
            except InputError:
                raise
            except Exception as error:  # damage shows as whatever the parser meets
                _blame(content, error)
    except OSError as error:
        raise InputError(error.strerror or str(error), where=str(content.path), expected="a readable file") from None


def _entries(file: IO[bytes], content: FileContent) -> Iterator[Entry]:
    schemas: dict[int, records.Schema] = {}
    channels: dict[int, tuple[str, Channel]] = {}
    digest, budget = Digest(), Budget(content.path)
    # No record is longer than the file: a damaged length shall not fill the memory.
    limit = min(MAX_CHUNK_BYTES, content.path.stat().st_size)
    for outer in outer_records(file, limit):
        for record in opened(outer, budget):
            if isinstance(record, records.Message):
                kind, channel = channels[record.channel_id]
                digest.message(channel, record.log_time, record.data)
                yield Entry(channel.topic, kind, record.log_time, record.data, channel)
            elif isinstance(record, records.Schema):
                schemas[record.id] = record
            elif isinstance(record, records.Channel):
                if len(channels) >= _MAX_CHANNELS:
                    raise budget.refusal(f"more than {_MAX_CHANNELS:,} topics")
                channels[record.id] = _channel(record, schemas.get(record.schema_id))
            elif isinstance(record, records.Metadata):
                _take_metadata(content, record.name, dict(record.metadata), digest)
            elif isinstance(record, records.Header) and record.profile not in ("ros2", ""):
                raise InputError(f"profile {record.profile!r}", where=str(content.path), expected="a ROS 2 bag")
        content.whole_bytes = file.tell()
    assert isinstance(outer, records.Footer)
    _check_summary(file, outer)
    content.finished = True
    content.digest = digest.hex()


def _take_metadata(content: FileContent, name: str, values: dict[str, str], digest: Digest) -> None:
    if name == STUDY_RECORD:
        content.record = content.record or values
        content.sessions.append((content.summary.n_messages, values))
    elif name == BEGIN_RECORD:
        content.chain = content.chain or values
    elif name == END_RECORD:
        content.end = values
        return
    digest.record(name, values)


def _channel(record: records.Channel, schema: records.Schema | None) -> tuple[str, Channel]:
    name, encoding, definition = (schema.name, schema.encoding, schema.data) if schema else ("", "", b"")
    metadata = tuple(sorted(record.metadata.items()))
    return name.removeprefix("mobo_msgs/msg/"), Channel(record.topic, name, encoding, definition, metadata)


def _blame(content: FileContent, error: Exception) -> None:
    """Say whether the file just ends too early or is damaged."""
    content.finished = False
    size = content.path.stat().st_size
    with content.path.open("rb") as file:
        # What follows the last whole record; the magic bytes stand before the first one and after the last one.
        file.seek(max(content.whole_bytes, len(MCAP0_MAGIC) if size >= len(MCAP0_MAGIC) else 0))
        start, head = file.tell(), file.read(_HEAD.size)
        file.seek(max(0, size - len(MCAP0_MAGIC)))
        ended = size > len(MCAP0_MAGIC) and file.read() == MCAP0_MAGIC
    ends = start + _HEAD.size + _HEAD.unpack(head)[1] if len(head) == _HEAD.size else size + 1
    last = len(head) == _HEAD.size and head[0] == Opcode.FOOTER
    content.cut_off = not ended and ends + len(MCAP0_MAGIC) * last > size
    detail = str(error) if isinstance(error, McapError | DamageError) and str(error) else type(error).__name__
    content.fault = "cut off" if content.cut_off else f"damaged after byte {content.whole_bytes} ({detail:.100})"


def _check_summary(file: IO[bytes], footer: Any) -> None:
    """Raise if the index behind the messages is damaged, which the stream reader passes over."""
    here = file.tell()
    if file.read(1):
        raise DamageError("bytes after its end")
    if footer.summary_crc:
        file.seek(footer.summary_start or here - _FOOTER_BYTES)
        data = file.read(max(0, here - _AFTER_CRC_BYTES - file.tell()))
        if zlib.crc32(data) != footer.summary_crc:
            raise DamageError("CRC of the index differs")


def with_sessions(paths: Iterable[Path]) -> Iterator[tuple[dict[str, str], Entry]]:
    """Yield (record of its session, message) for all whole messages of some files; errors as :func:`stream`."""
    for path in paths:
        content = FileContent(path)
        for entry in stream(content):
            yield content.sessions[-1][1] if content.sessions else {}, entry


def read_file(path: Path) -> FileContent:
    """Read one MCAP file: every whole message before its end or its first damage; errors as :func:`stream`."""
    content = FileContent(path)
    content.entries.extend(stream(content))
    return content


def read_bag(folder: Path | str) -> list[FileContent]:
    """Read all files of a bag.

    Raises:
        InputError: no bag, or a file of it is none.
    """
    return [read_file(path) for path in bag_files(folder)]


def read_record(folder: Path | str) -> dict[str, str]:
    """Return the study's record of a bag, reading no further than to it; errors as :func:`read_bag`."""
    for path in bag_files(folder):
        content = FileContent(path)
        next(stream(content), None)  # it stands before the first message
        if content.record:
            return content.record
    return {}


def first_record(contents: list[FileContent]) -> dict[str, str]:
    """Return the study's record: that of the first file that got so far, or an empty one."""
    return next((content.record for content in contents if content.record), {})


def entries(contents: list[FileContent]) -> Iterator[Entry]:
    """Return all messages in the order they were written."""
    for content in contents:
        yield from content.entries
