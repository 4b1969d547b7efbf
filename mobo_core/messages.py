"""The messages of mobo as Python objects and as CDR bytes, from the ``.msg`` files, with no ROS installed.

Nodes publish and receive these bytes as they are, and bags hold them as they were sent.
"""

from __future__ import annotations

import functools
import struct
import time
from typing import Any, NamedTuple

import numpy as np
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from mobo_core.errors import InputError
from mobo_core.resources import message_folder

SCHEMA_VERSION = 1

# How the reason of a FAILED answer begins if the evaluator's engine or version is not up to the question.
UNABLE = "unable: "

# Larger than any message mobo sends: a million voxels, and a URDF.
MAX_MESSAGE_BYTES = 64_000_000

TOPICS = {
    "candidates": "Candidate",
    "evaluations": "Evaluation",
    "trials": "Trial",
    "evaluators": "EvaluatorStatus",
    "study": "StudyStatus",
    "commands": "Command",
}

_STANDARD = {
    "builtin_interfaces/msg/Time": "int32 sec\nuint32 nanosec\n",
    "std_msgs/msg/Header": "builtin_interfaces/Time stamp\nstring frame_id\n",
}


class Schema(NamedTuple):
    """How a message type is written into a bag."""

    name: str
    definition: str
    type_hash: str


@functools.cache
def typestore() -> Any:
    """Return the rosbags type store that knows mobo's messages."""
    # What mobo's own are made of; to load all of ROS 2's would take a tenth of every process's start.
    store = get_typestore(Stores.EMPTY)
    types: dict[str, Any] = {}
    for name, definition in _STANDARD.items():
        types.update(get_types_from_msg(definition, name))
    for path in sorted(message_folder().glob("*.msg")):
        types.update(get_types_from_msg(path.read_text(encoding="utf-8"), f"mobo_msgs/msg/{path.stem}"))
    store.register(types)
    return store


def schema(kind: str) -> Schema:
    """Return the schema of a message kind such as ``Candidate``."""
    name = f"mobo_msgs/msg/{kind}"
    definition, _ = typestore().generate_msgdef(name, ros_version=2)
    return Schema(name, definition, typestore().hash_rihs01(name))


def message_type(kind: str) -> Any:
    """Return the class of a message kind; its constants (such as ``OK``) are attributes of it."""
    return typestore().types[f"mobo_msgs/msg/{kind}"]


def encode(message: Any) -> bytes:
    """Return a message as CDR bytes."""
    data: bytes = bytes(typestore().serialize_cdr(message, message.__msgtype__))
    return data


def decode(kind: str, data: bytes) -> Any:
    """Return the message that CDR bytes hold.

    Raises:
        InputError: the bytes are not such a message.
    """
    if len(data) > MAX_MESSAGE_BYTES:
        raise InputError(f"{len(data)} bytes", where=kind, expected=f"at most {MAX_MESSAGE_BYTES} bytes")
    try:
        return typestore().deserialize_cdr(data, f"mobo_msgs/msg/{kind}")
    except Exception as error:  # rosbags raises whatever its generated code meets
        raise InputError(f"not readable ({error!r:.80})", where=kind, expected="a CDR message") from None


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


def header(time_ns: int | None = None) -> Any:
    """Return a std_msgs/Header in the frame ``base_link``, of now or of the given time."""
    ns = time.time_ns() if time_ns is None else time_ns
    types = typestore().types
    stamp = types["builtin_interfaces/msg/Time"](sec=ns // 10**9, nanosec=ns % 10**9)
    return types["std_msgs/msg/Header"](stamp=stamp, frame_id="base_link")


def make(kind: str, **fields: Any) -> Any:
    """Return a message with these fields; the others are zero, empty, and the header is of now."""
    defaults = {"header": header(), "schema_version": SCHEMA_VERSION}
    values = {}
    cls = message_type(kind)
    for name, annotation in _fields(kind):
        value = fields.pop(name) if name in fields else defaults.get(name, _zero(annotation))
        if annotation[0] in ("array", "sequence") and annotation[1] != "string":
            value = np.asarray(value, dtype=annotation[1])
        values[name] = value
    if fields:
        raise TypeError(f"{kind} has no field {', '.join(fields)}")
    return cls(**values)


@functools.cache
def _fields(kind: str) -> tuple[tuple[str, tuple[str, str]], ...]:
    """Return (name, (array | sequence | base | message, element type)) of all fields."""
    from rosbags.interfaces import Nodetype

    found = []
    for name, (node, detail) in typestore().fielddefs[f"mobo_msgs/msg/{kind}"][1]:
        if node == Nodetype.BASE:
            found.append((name, ("base", detail[0])))
        elif node == Nodetype.NAME:
            found.append((name, ("message", detail)))
        else:
            found.append((name, ("array" if node == Nodetype.ARRAY else "sequence", detail[0][1][0])))
    return tuple(found)


def _zero(annotation: tuple[str, str]) -> Any:
    shape, element = annotation
    if shape in ("array", "sequence"):
        return []
    return {"string": "", "bool": False}.get(element, 0.0 if element.startswith("float") else 0)
