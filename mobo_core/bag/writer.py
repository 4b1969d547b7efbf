"""Appends messages to a bag; each is on its way to disk before the call returns."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Any

import yaml
from mcap.writer import CompressionType, Writer

from mobo_core import __version__
from mobo_core.bag.files import FileSummary, bag_files, qos_profile
from mobo_core.errors import StudyError
from mobo_core.messages import schema

STUDY_RECORD = "mobo"


class McapFile:
    """One new MCAP file, written the way rosbag2 writes it.

    Every message is a flushed chunk: what :meth:`write` returned from survives SIGKILL.

    Args:
        path: a file that does not exist yet.
        record: the metadata record named ``mobo``: what the study is.

    Raises:
        StudyError: the file cannot be made or written to (no room, read-only, …).
    """

    def __init__(self, path: Path, record: dict[str, str]) -> None:
        self.path, self.summary = path, FileSummary(path.name)
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        self._sequence = 0
        try:
            self._stream = path.open("xb")
            self._writer = Writer(self._stream, compression=CompressionType.ZSTD, enable_data_crcs=True)
            self._writer.start(profile="ros2", library=f"mobo {__version__}")
            self._writer.add_metadata(STUDY_RECORD, record)
            self._writer.flush()
        except OSError as error:
            raise self._failed(error) from None

    def write(self, topic: str, kind: str, data: bytes, time_ns: int | None = None) -> None:
        """Append a message (CDR bytes) and flush."""
        now = time.time_ns() if time_ns is None else time_ns
        try:
            if topic not in self._channels:
                self._channels[topic] = self._register(topic, kind)
            self._writer.add_message(
                channel_id=self._channels[topic], log_time=now, publish_time=now, data=data, sequence=self._sequence
            )
            self._writer.flush()
        except OSError as error:
            raise self._failed(error) from None
        self._sequence += 1
        self.summary.add(topic, kind, now)

    def finish(self) -> None:
        """Write index and footer, and close."""
        try:
            self._writer.finish()
            self._stream.flush()
            os.fsync(self._stream.fileno())
        except OSError as error:
            raise self._failed(error) from None
        finally:
            self._stream.close()

    def _register(self, topic: str, kind: str) -> int:
        described = schema(kind)
        if kind not in self._schemas:
            self._schemas[kind] = self._writer.register_schema(
                described.name, "ros2msg", described.definition.encode()
            )
        qos = yaml.safe_dump([qos_profile(latched=kind == "StudyStatus")], sort_keys=False)
        return self._writer.register_channel(
            topic,
            "cdr",
            self._schemas[kind],
            {"offered_qos_profiles": qos, "topic_type_hash": described.type_hash},
        )

    def _failed(self, error: OSError) -> StudyError:
        return StudyError(f"{self.path}: cannot write the bag ({error.strerror or error}); the study stops here")


def next_file(folder: Path) -> Path:
    """Return the path of the next file of a bag."""
    numbers = [int(path.stem.rsplit("_", 1)[1]) for path in bag_files(folder)] if any(folder.glob("*.mcap")) else []
    return folder / f"{folder.name}_{max(numbers, default=-1) + 1}.mcap"


def custom_data(record: dict[str, Any]) -> dict[str, str]:
    """Return the study's record as the ``custom_data`` of metadata.yaml."""
    return {f"mobo_{name}": str(value) for name, value in record.items()}
