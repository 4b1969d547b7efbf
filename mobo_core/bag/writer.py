"""Appends messages to a bag; each is on its way to disk before the call returns."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

from mcap.writer import CompressionType, Writer

from mobo_core.bag.chain import BEGIN_RECORD, END_RECORD, Digest, beginning
from mobo_core.bag.files import Channel, FileSummary, bag_files, channel_of, number_of
from mobo_core.clock import now_ns
from mobo_core.errors import InputError, StudyError
from mobo_core.messages import SCHEMA_VERSION
from mobo_core.version import __version__

STUDY_RECORD = "mobo"

# Of a file written in one go. Larger ones compress no better.
CHUNK_BYTES = 1_000_000


class NewFile(Protocol):
    """What is needed of an unbuffered file that is being written."""

    def write(self, data: bytes, /) -> int | None:
        """Write some of the bytes at the end; return how many."""

    def truncate(self, size: int, /) -> int:
        """Cut the file back."""

    def fileno(self) -> int:
        """Return its descriptor."""

    def close(self) -> None:
        """Close it."""


# Makes a file that does not exist yet, or raises OSError. A simulation has a disk of its own.
Create = Callable[[Path], NewFile]


def create_file(path: Path) -> NewFile:
    """Make a file on the disk."""
    return path.open("xb", buffering=0)


class McapFile:
    """One new MCAP file, written the way rosbag2 writes it.

    Every message is a flushed chunk: what :meth:`write` returned from survives SIGKILL. A write that fails
    is cut back, so that the file ends with its last whole chunk; nothing can be written to it after that.

    Args:
        path: a file that does not exist yet.
        record: the metadata record named ``mobo``: what the study is.
        chunk_bytes: let chunks grow to so many bytes; 0: a chunk for each message.
        version: schema version of the messages that :meth:`write` gets.
        chain: what the hash chain begins with (see :mod:`mobo_core.bag.chain`); by default as in a bag's first file.
        create: makes the file.

    Attributes:
        path: the file.
        summary: what was written.

    Raises:
        StudyError: the file cannot be made or written to (no room, read-only, …).
    """

    def __init__(
        self,
        path: Path,
        record: dict[str, str],
        chunk_bytes: int = 0,
        version: int = SCHEMA_VERSION,
        chain: dict[str, str] | None = None,
        create: Create = create_file,
    ) -> None:
        self.path, self.summary, self._version = path, FileSummary(path.name), version
        self._channels: dict[Channel, int] = {}
        self._schemas: dict[tuple[str, bytes], int] = {}
        self._chunk_bytes, self._failed, self._digest = chunk_bytes, False, Digest()
        try:
            self._stream = _WholePieces(create(path))
        except OSError as error:
            raise self._error(error) from None
        self._writer = Writer(
            self._stream,  # type: ignore[arg-type]
            chunk_size=chunk_bytes or CHUNK_BYTES,
            compression=CompressionType.ZSTD,
            enable_data_crcs=True,
        )
        try:
            self._writer.start(profile="ros2", library=f"mobo {__version__}")
            self._add_record(STUDY_RECORD, record)
            self._add_record(BEGIN_RECORD, beginning("recorded") if chain is None else chain)
            self._writer.flush()
        except OSError as error:
            self._stream.close()
            path.unlink(missing_ok=True)
            raise self._error(error) from None

    @property
    def n_chunks(self) -> int:
        """How many chunks the index holds: about 400 bytes of memory each."""
        return self._stream.flushes

    def write(self, topic: str, kind: str, data: bytes, time_ns: int | None = None) -> None:
        """Append one of mobo's messages (CDR bytes) to a topic (full name)."""
        self.copy(channel_of(topic, kind, self._version), data, now_ns() if time_ns is None else time_ns)

    def copy(self, channel: Channel, data: bytes, time_ns: int) -> None:
        """Append a message of any type as another bag describes it."""
        if self._failed:
            raise StudyError(f"{self.path}: a write to it failed before")
        try:
            if channel not in self._channels:
                self._channels[channel] = self._register(channel)
            self._writer.add_message(
                channel_id=self._channels[channel],
                log_time=time_ns,
                publish_time=time_ns,
                data=data,
                sequence=self.summary.n_messages,
            )
            if not self._chunk_bytes or self._stream.pending:
                self._writer.flush()
        except OSError as error:
            raise self._error(error) from None
        self._digest.message(channel, time_ns, data)
        self.summary.add(channel, time_ns)

    def session(self, record: dict[str, str]) -> None:
        """Let what follows be of a session with this record of the study."""
        try:
            self._writer.flush()
            self._add_record(STUDY_RECORD, record)
        except OSError as error:
            raise self._error(error) from None

    @property
    def digest(self) -> str:
        """What was written hashes to."""
        return self._digest.hex()

    def finish(self) -> None:
        """Write index and footer, and close. A file that a write to failed stays without."""
        try:
            if not self._failed:
                self._writer.flush()
                end = {"messages": str(self.summary.n_messages), "sha256": self.digest}
                self._writer.add_metadata(END_RECORD, end)
                self._writer.finish()
                self._stream.flush()
                self._stream.sync()
        except OSError as error:
            raise self._error(error) from None
        finally:
            self._stream.close()

    def abandon(self) -> None:
        """Close and remove the file."""
        self._stream.close()
        self.path.unlink(missing_ok=True)

    def _add_record(self, name: str, values: dict[str, str]) -> None:
        self._writer.add_metadata(name, values)
        self._digest.record(name, values)

    def _register(self, channel: Channel) -> int:
        key = channel.type_name, channel.definition
        if key not in self._schemas:
            self._schemas[key] = self._writer.register_schema(channel.type_name, channel.encoding, channel.definition)
        return self._writer.register_channel(channel.topic, "cdr", self._schemas[key], dict(channel.metadata))

    def _error(self, error: OSError) -> StudyError:
        self._failed = True
        return StudyError(f"{self.path}: cannot write the bag ({error.strerror or error}); the study stops here")


class _WholePieces:
    """A file as the MCAP writer wants it, which gets all that came between two flushes, or nothing of it."""

    def __init__(self, file: NewFile) -> None:
        self._file = file
        self._pending = bytearray()
        self._length = self.flushes = 0

    @property
    def pending(self) -> int:
        """Bytes that wait for the next flush."""
        return len(self._pending)

    def write(self, data: bytes) -> int:
        self._pending += data
        return len(data)

    def tell(self) -> int:
        return self._length + len(self._pending)

    def flush(self) -> None:
        data = bytes(self._pending)
        self._pending.clear()
        try:
            done = 0
            while done < len(data):
                done += self._file.write(data[done:]) or 0
        except OSError:
            with contextlib.suppress(OSError):
                self._file.truncate(self._length)
            raise
        self._length += len(data)
        self.flushes += 1

    def sync(self) -> None:
        os.fsync(self._file.fileno())

    def close(self) -> None:
        self._file.close()


def next_file(folder: Path) -> Path:
    """Return the path of the next file of a bag."""
    try:
        number = max(number_of(path) for path in bag_files(folder)) + 1
    except InputError:
        number = 0
    # What is there may be no file of the bag; no name is taken from it.
    while os.path.lexists(path := folder / f"{folder.name}_{number}.mcap"):
        number += 1
    return path


def custom_data(record: dict[str, Any]) -> dict[str, str]:
    """Return the study's record as the ``custom_data`` of metadata.yaml."""
    return {f"mobo_{name}": str(value) for name, value in record.items()}
