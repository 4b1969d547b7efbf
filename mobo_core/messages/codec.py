"""Messages as CDR bytes and back, with no ROS installed.

Nodes publish and receive these bytes as they are, and bags hold them as they were sent.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import fields
from functools import cache
from operator import attrgetter
from typing import NamedTuple, TypeVar

from mobo_core.errors import InputError
from mobo_core.messages.schemas import type_name, typestore
from mobo_core.messages.types import SCHEMA_VERSION, Header, Message, SpecMessage, Time

# Larger than any message mobo sends: a million voxels, and a URDF.
MAX_MESSAGE_BYTES = 64_000_000

Decoded = TypeVar("Decoded", bound=Message)
_PARTS: dict[str, type] = {"header": Header, "stamp": Time, "spec": SpecMessage}


def encode(message: Message, version: int = SCHEMA_VERSION) -> bytes:
    """Return a message as CDR bytes of a schema version; fields which that lacks are left out."""
    return bytes(typestore(version).serialize_cdr(message, type_name(message.kind)))


def decode(cls: type[Decoded], data: bytes, version: int = SCHEMA_VERSION) -> Decoded:
    """Return the message of class ``cls`` that CDR bytes of a schema version hold.

    Fields which that version lacks have the defaults, which mean the same.

    Raises:
        InputError: the bytes are not such a message.
    """
    kind = cls.kind
    if len(data) > MAX_MESSAGE_BYTES:
        raise InputError(f"{len(data)} bytes", where=kind, expected=f"at most {MAX_MESSAGE_BYTES} bytes")
    try:
        message = _typed(cls, typestore(version).deserialize_cdr(data, type_name(kind)), version)
    except Exception as error:  # rosbags raises whatever its generated code meets
        raise InputError(f"not readable ({error!r:.80})", where=kind, expected="a CDR message") from None
    assert isinstance(message, cls)
    return message


@cache
def _field_names(cls: type, version: int) -> tuple[str, ...]:
    names = tuple(part.name for part in fields(cls))
    if not issubclass(cls, Message):
        return names
    known = {name for name, _ in typestore(version).fielddefs[type_name(cls.kind)][1]}
    return tuple(name for name in names if name in known)


@cache
def _getter(cls: type, version: int) -> Callable[[object], tuple[object, ...]]:
    first, *others = _field_names(cls, version)
    return attrgetter(first, *others) if others else lambda raw: (getattr(raw, first),)


def _typed(cls: type, raw: object, version: int) -> object:
    """Return what rosbags read as an object of ours."""
    values = dict(zip(_field_names(cls, version), _getter(cls, version)(raw), strict=True))
    for name in _PARTS.keys() & values.keys():
        values[name] = _typed(_PARTS[name], values[name], version)
    return cls(**values)


class Address(NamedTuple):
    """Which question a Candidate or an Evaluation is about."""

    study: str
    trial: int
    attempt: int
    evaluator: str


def address(data: bytes) -> Address:
    """Return what a Candidate or an Evaluation begins with, as :func:`decode` would, without reading the rest.

    Raises:
        InputError: the bytes do not begin so.
    """
    try:
        if data[:2] not in (b"\0\0", b"\0\1"):
            raise IndexError("no CDR")
        order = "<" if data[1] else ">"
        (frame,) = struct.unpack_from(order + "I", data, 12)  # behind encapsulation and stamp
        study, at = _text(data, _aligned(16 + frame), order)
        trial, attempt = struct.unpack_from(order + "II", data, _aligned(at))
        evaluator, _ = _text(data, _aligned(at) + 8, order)
    except (IndexError, struct.error, UnicodeDecodeError) as error:
        raise InputError(f"not readable ({error!r:.80})", where="message", expected="a CDR message") from None
    return Address(study, trial, attempt, evaluator)


def _aligned(at: int) -> int:
    return at + 3 & ~3


def _text(data: bytes, at: int, order: str) -> tuple[str, int]:
    """Return the string at a place, and the place behind it."""
    (size,) = struct.unpack_from(order + "I", data, at)
    end = at + 4 + size
    if not size or end > len(data) or data[end - 1]:
        raise IndexError(f"string of {size} bytes at {at}")
    return data[at + 4 : end - 1].decode(), end
