"""Follows a bag as it grows on the disk, message by message."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from io import BytesIO
from itertools import count
from pathlib import Path

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Message, Schema
from mcap.writer import MCAP0_MAGIC

from mobo_core.bag.chunks import Budget, opened
from mobo_core.bag.files import number_of
from mobo_core.bag.reader import read_file
from mobo_core.messages import Candidate, Command, Evaluation, Trial, decode

_HEAD = struct.Struct("<BQ")
_CHUNK = int(Opcode.CHUNK)

# Messages of a bag: topic, CDR bytes.
Raw = list[tuple[str, bytes]]

OF_A_TRIAL: dict[str, type[Candidate | Evaluation | Trial]] = {
    "candidates": Candidate,
    "evaluations": Evaluation,
    "trials": Trial,
}


class Tail:
    """What has come into a bag since it was looked at last.

    Args:
        folder: of the bag, which need not be there yet.
        take: takes (topic, CDR bytes) of each message, in the bag's order.
    """

    def __init__(self, folder: Path, take: Callable[[str, bytes], None]) -> None:
        self._folder, self._take = folder, take
        self._file: Path | None = None
        self._at = 0
        self._channels: dict[int, str] = {}

    def follow(self) -> None:
        """Take what has come into the bag since."""
        file = self._file
        if file is not None and file.exists() and file.stat().st_size == self._at and not self._next(file).exists():
            return
        while (file := self._current()) is not None:
            self._read(file)
            if not self._next(file).exists():
                return
            self._file, self._at, self._channels = self._next(file), 0, {}

    def again(self) -> None:
        """Take all that is in the bag, and go on from its end."""
        self._file, self._at = None, 0
        for file in self._files():
            for entry in read_file(file).entries:
                self._take(entry.topic.removeprefix("/"), entry.data)
        for file in self._files():
            self._file, self._at, self._channels = file, file.stat().st_size, {}

    def _current(self) -> Path | None:
        if self._file is None:
            first = self._folder / f"{self._folder.name}_0.mcap"
            if not first.exists():
                return None
            self._file, self._at, self._channels = first, 0, {}
        return self._file

    def _next(self, file: Path) -> Path:
        return file.with_name(f"{self._folder.name}_{number_of(file) + 1}.mcap")

    def _files(self) -> Iterator[Path]:
        for number in count():
            if not (file := self._folder / f"{self._folder.name}_{number}.mcap").exists():
                return
            yield file

    def _read(self, path: Path) -> None:
        with path.open("rb") as file:
            file.seek(self._at)
            data = file.read()
        at = len(MCAP0_MAGIC) if self._at == 0 and len(data) >= len(MCAP0_MAGIC) else 0
        while at + _HEAD.size <= len(data):
            opcode, length = _HEAD.unpack_from(data, at)
            if at + _HEAD.size + length > len(data) or data[at:] == MCAP0_MAGIC:
                break
            if opcode == _CHUNK:
                self._read_chunk(path, data[at + _HEAD.size : at + _HEAD.size + length])
            at += _HEAD.size + length
        self._at += at

    def _read_chunk(self, path: Path, data: bytes) -> None:
        for record in opened(Chunk.read(ReadDataStream(BytesIO(data))), Budget(path)):
            if isinstance(record, Channel):
                self._channels[record.id] = record.topic.removeprefix("/")
            elif isinstance(record, Message):
                self._take(self._channels[record.channel_id], record.data)
            else:
                assert isinstance(record, Schema)


def kept_before(raw: Raw, before: int) -> Raw:
    """Return the messages that stay in a bag cut before a trial, without those on evaluators and on the whole study."""
    kept: Raw = []
    for topic, data in raw:
        if topic in OF_A_TRIAL:
            if decode(OF_A_TRIAL[topic], data).trial < before:
                kept.append((topic, data))
            elif not before:
                break
        elif topic == "commands" and decode(Command, data).command != "stop":
            kept.append((topic, data))
        if before and sum(known == "trials" for known, _ in kept) == before:
            break
    return kept
