"""How messages are written down: definitions, type stores and hashes of each schema version."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import NamedTuple

from rosbags.interfaces.typing import Typesdict
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from mobo_core.errors import InputError
from mobo_core.messages.types import SCHEMA_VERSION
from mobo_core.resources import message_folder

# The definitions of schema 1 that schema 2 changed.
_OLD = Path(__file__).parent / "schema_1"
VERSIONS = (1, SCHEMA_VERSION)

_STANDARD = {
    "builtin_interfaces/msg/Time": "int32 sec\nuint32 nanosec\n",
    "std_msgs/msg/Header": "builtin_interfaces/Time stamp\nstring frame_id\n",
}


class Schema(NamedTuple):
    """How a message type is written into a bag."""

    name: str
    definition: str
    type_hash: str


def type_name(kind: str) -> str:
    """Return the full name of the type of a message kind such as ``Candidate``."""
    return f"mobo_msgs/msg/{kind}"


@functools.cache
def typestore(version: int = SCHEMA_VERSION) -> Typestore:
    """Return the rosbags type store that knows mobo's messages of a schema version."""
    # What mobo's own are made of; to load all of ROS 2's would take a tenth of every process's start.
    store = get_typestore(Stores.EMPTY)
    types: Typesdict = {}
    for name, definition in _STANDARD.items():
        types.update(get_types_from_msg(definition, name))
    for path in sorted(message_folder().glob("*.msg")):
        old = _OLD / path.name
        text = (old if version == 1 and old.exists() else path).read_text(encoding="utf-8")
        types.update(get_types_from_msg(text, type_name(path.stem)))
    store.register(types)
    return store


@functools.cache
def schema(kind: str, version: int = SCHEMA_VERSION) -> Schema:
    """Return the schema of a message kind such as ``Candidate``."""
    store, name = typestore(version), type_name(kind)
    definition, _ = store.generate_msgdef(name, ros_version=2)
    return Schema(name, definition, store.hash_rihs01(name))


@functools.lru_cache(256)
def version_of(kind: str, definition: bytes, where: str) -> int:
    """Return the schema version of a definition that a bag holds for a message kind.

    Raises:
        InputError: it is that of no version.
    """
    expected = "a definition of mobo's, of schema " + " or ".join(map(str, VERSIONS))
    for version in reversed(VERSIONS):
        if definition == schema(kind, version).definition.encode():
            return version
    try:
        found = get_types_from_msg(definition.decode(), type_name(kind))
        for version in reversed(VERSIONS):
            known = typestore(version).fielddefs
            # Comments and order of the parts do not matter.
            if all(found[name] == known.get(name) for name in found):
                return version
    except Exception as error:  # rosbags raises whatever its parser meets
        raise InputError(f"definition of {kind} not readable ({error!r:.80})", where=where, expected=expected) from None
    raise InputError(f"unknown definition of {kind}", where=where, expected=expected)
