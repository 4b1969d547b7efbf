"""Opens the chunks of an MCAP file, whatever they claim: no more comes out than a bag of its size can hold."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterable, Iterator
from io import BytesIO
from pathlib import Path

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, McapRecord, Message, Schema

from mobo_core.errors import InputError

# Opcode and length of a record; what a message's data come after.
_HEAD, _MESSAGE = struct.Struct("<BQ"), struct.Struct("<HIQQ")
_ZSTD = zstandard.ZstdDecompressor()
# The largest message, and what else fits into its chunk.
MAX_CHUNK_BYTES = 80_000_000
# A message takes so many bytes at least: an entry of its chunk's index.
_BYTES_PER_RECORD, _SPARE_RECORDS = 16, 1000
# So much more room may its messages take than a file.
_MAX_RATIO, _SPARE_BYTES = 100, 200_000_000


class DamageError(Exception):
    """What the file holds cannot be."""


class Budget:
    """What may still come out of a file."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._records = self._bytes = 0

    def chunk(self, size: int) -> None:
        """Take a chunk of so many bytes.

        Raises:
            InputError: no bag of this size holds so much.
        """
        self._bytes += size
        if self._bytes > _SPARE_BYTES and self._bytes > _SPARE_BYTES + _MAX_RATIO * self._path.stat().st_size:
            raise self.refusal(f"more than {self._bytes:,} bytes unpacked")

    def record(self) -> None:
        """Take a record of a chunk; errors as :meth:`chunk`."""
        self._records += 1
        if self._records % _SPARE_RECORDS == 0:
            most = _SPARE_RECORDS + self._path.stat().st_size // _BYTES_PER_RECORD
            if self._records > most:
                raise self.refusal(f"more than {most:,} messages")

    def refusal(self, what: str) -> InputError:
        """Return the error that says what of the file no bag holds."""
        return InputError(what, where=str(self._path), expected="as much as a bag of its size holds")


def opened(record: McapRecord | None, budget: Budget) -> Iterable[McapRecord]:
    """Return the records in a chunk, whose sizes and CRC are checked first; or the record itself, if it is one.

    Raises:
        DamageError: CRC or sizes do not fit.
        InputError: see :class:`Budget`.
    """
    if record is None:
        return ()
    return _unpacked(record, budget) if isinstance(record, Chunk) else (record,)


def _unpacked(chunk: Chunk, budget: Budget) -> Iterator[McapRecord]:
    if chunk.uncompressed_size > MAX_CHUNK_BYTES:
        raise DamageError(f"a chunk of {chunk.uncompressed_size} bytes")
    budget.chunk(chunk.uncompressed_size)
    data = _decompressed(chunk)
    if len(data) != chunk.uncompressed_size:
        raise budget.refusal("a chunk of another size than it says")
    if chunk.uncompressed_crc and zlib.crc32(data) != chunk.uncompressed_crc:
        raise DamageError("CRC of a chunk differs")
    at = 0
    while at < len(data):
        opcode, length = _HEAD.unpack_from(data, at)
        at += _HEAD.size
        end = at + length
        if end > len(data):
            raise DamageError("a record longer than its chunk")
        budget.record()
        if opcode == Opcode.MESSAGE:
            channel, sequence, log_time, publish_time = _MESSAGE.unpack_from(data, at)
            yield Message(channel, log_time, data[at + _MESSAGE.size : end], publish_time, sequence)
        elif opcode == Opcode.CHANNEL:
            yield Channel.read(ReadDataStream(BytesIO(data[at:end])))
        elif opcode == Opcode.SCHEMA:
            yield Schema.read(ReadDataStream(BytesIO(data[at:end])))
        at = end


def _decompressed(chunk: Chunk) -> bytes:
    size = chunk.uncompressed_size
    if chunk.compression == "zstd":
        # Else the size in the frame's own header would be believed.
        if zstandard.get_frame_parameters(chunk.data).content_size != size:
            raise DamageError("sizes of a chunk differ")
        return _ZSTD.decompress(chunk.data, size)
    if chunk.compression == "lz4":
        from lz4.frame import LZ4FrameDecompressor  # mobo writes none

        unpacked: bytes = LZ4FrameDecompressor().decompress(chunk.data, max_length=size + 1)
        return unpacked
    if chunk.compression:
        raise DamageError(f"compression {chunk.compression[:20]!r}")
    return bytes(chunk.data)
