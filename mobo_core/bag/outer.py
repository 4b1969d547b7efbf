"""The records that an MCAP file is made of, chunks unopened.

The library's own stream reader takes a few calls for each number in each record; a live bag has a chunk, with its
indexes, for every message.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from io import BytesIO
from typing import IO

from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile, InvalidMagic, RecordLengthLimitExceeded
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, DataEnd, Footer, Header, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import CRCValidationError
from mcap.writer import MCAP0_MAGIC

from mobo_core.bag.chunks import DamageError

_HEAD = struct.Struct("<BQ")
# Of a chunk: first and last time, size and CRC of what is in it, length of the compression's name.
_CHUNK, _SIZE = struct.Struct("<QQQII"), struct.Struct("<Q")
_READ = {
    Opcode.CHANNEL: Channel, Opcode.DATA_END: DataEnd, Opcode.FOOTER: Footer, Opcode.HEADER: Header,
    Opcode.METADATA: Metadata, Opcode.SCHEMA: Schema,
}  # fmt: skip


def outer_records(file: IO[bytes], limit: int) -> Iterator[McapRecord | None]:
    """Yield the records of a file from its first byte to its footer; None for an index and whatever else has no news.

    Args:
        file: at its beginning.
        limit: bytes of a record.

    Raises:
        McapError, DamageError, struct.error, UnicodeDecodeError: damage, of whatever kind.
    """
    crc = zlib.crc32(_magic(file))
    while True:
        head = file.read(_HEAD.size)
        if len(head) < _HEAD.size:
            raise EndOfFile()
        opcode, length = _HEAD.unpack(head)
        if length > limit:
            raise RecordLengthLimitExceeded(opcode, length, limit)
        body = file.read(length)
        if len(body) < length:
            raise EndOfFile()
        record = _record(opcode, body)
        if isinstance(record, DataEnd) and record.data_section_crc not in (0, crc):
            raise CRCValidationError(expected=record.data_section_crc, actual=crc, record=record)
        yield record
        if isinstance(record, Footer):
            _magic(file)
            return
        crc = zlib.crc32(body, zlib.crc32(head, crc))


def _magic(file: IO[bytes]) -> bytes:
    magic = file.read(len(MCAP0_MAGIC))
    if magic != MCAP0_MAGIC:
        raise EndOfFile() if len(magic) < len(MCAP0_MAGIC) else InvalidMagic(magic)
    return magic


def _record(opcode: int, body: bytes) -> McapRecord | None:
    if opcode == Opcode.CHUNK:
        return _chunk(body)
    if opcode == Opcode.MESSAGE:
        message: McapRecord = Message.read(ReadDataStream(BytesIO(body)), len(body))
        return message
    kind = _READ.get(opcode)  # type: ignore[call-overload]
    if kind is None:
        return None
    record: McapRecord = kind.read(ReadDataStream(BytesIO(body)))
    return record


def _chunk(body: bytes) -> Chunk:
    first, last, size, crc, n = _CHUNK.unpack_from(body)
    at = _CHUNK.size + n
    (packed,) = _SIZE.unpack_from(body, at)
    data = body[at + _SIZE.size :]
    if len(data) != packed:
        raise DamageError("a chunk of another size than its record")
    return Chunk(
        compression=body[_CHUNK.size : at].decode(), data=data, message_end_time=last, message_start_time=first,
        uncompressed_crc=crc, uncompressed_size=size,
    )  # fmt: skip
