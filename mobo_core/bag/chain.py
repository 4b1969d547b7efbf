"""The hash chain over a bag: each file says what its contents hash to, and what those of the file before it do.

It shows damage: a file that was cut, changed or swapped. Who computes it anew can forge it.
"""

from __future__ import annotations

import hashlib
import json
import struct

from mobo_core.bag.files import Channel

# Metadata records of a file: one behind the study's, one as the last.
BEGIN_RECORD, END_RECORD = "mobo_chain", "mobo_digest"
# What a file may be: written as messages came, or by a command from files that were there.
ORIGINS = ("recorded", "compacted", "recovered", "cut")

_HEAD = struct.Struct("<QQI")


def beginning(origin: str, previous: str = "", **more: str) -> dict[str, str]:
    """Return the record that a file's chain begins with.

    Args:
        origin: one of ORIGINS.
        previous: digest of the file before, "" for the first.
        more: what else there is to say, such as ``stands_for``: the digest of the file in whose place it came.
    """
    return {"origin": origin, "previous": previous, **more}


class Digest:
    """Hashes what a file holds, in order: records, and messages with topic, time and definition."""

    def __init__(self) -> None:
        self._hash = hashlib.sha256()
        self._numbers: dict[Channel, int] = {}

    def record(self, name: str, values: dict[str, str]) -> None:
        """Take a metadata record."""
        self._hash.update(json.dumps([name, values], sort_keys=True).encode())

    def message(self, channel: Channel, time_ns: int, data: bytes) -> None:
        """Take a message."""
        number = self._numbers.get(channel)
        if number is None:
            number = self._numbers[channel] = len(self._numbers)
            self._hash.update(repr(tuple(channel)).encode())
        self._hash.update(_HEAD.pack(time_ns, len(data), number))
        self._hash.update(data)

    def hex(self) -> str:
        """Return the digest so far."""
        return self._hash.hexdigest()
