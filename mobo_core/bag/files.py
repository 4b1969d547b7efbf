"""The files of a bag: a folder NAME with NAME_0.mcap, NAME_1.mcap, … and metadata.yaml."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from mobo_core.errors import InputError, StudyError
from mobo_core.messages import SCHEMA_VERSION, schema
from mobo_core.outputs import replace_whole
from mobo_core.settings import read_yaml

METADATA_FILE = "metadata.yaml"

_NUMBERED = re.compile(r"(.*)_(\d{1,9})\.mcap", re.ASCII | re.DOTALL)
_MAX_METADATA_BYTES = 1_000_000
_MAX_QOS_BYTES = 20_000


def number_of(path: Path) -> int:
    """Return the number in a file's name NAME_<number>.mcap; -1 if it has none."""
    match = _NUMBERED.fullmatch(path.name)
    return int(match[2]) if match else -1


def bag_files(folder: Path | str, name: str = "") -> list[Path]:
    """Return the MCAP files of a bag in the order they were written; a single file is a bag of one.

    Those are the ones that metadata.yaml names, and ones of a later number (its writer was killed) that are named
    alike or like the folder. Without a metadata.yaml those named like the folder, else all if they are named alike.
    Other recordings in the folder are none of the bag's.

    Args:
        folder: of the bag, or a file.
        name: of the folder, if it has another for the moment.

    Raises:
        InputError: no such folder, or no MCAP file in it; two files of one number.
    """
    path = Path(folder)
    if path.is_file():
        return [path]
    if not path.is_dir():
        raise InputError("no such bag", where=str(path), expected="the folder of a bag, or an .mcap file")
    found = [file for file in path.glob("*.mcap") if number_of(file) >= 0 and file.is_file()]
    if not found:
        raise InputError("not a bag", where=str(path), expected="files NAME_0.mcap, NAME_1.mcap, …")
    listed = listed_files(path)
    own = [file for file in found if file.name in listed]
    last = max(map(number_of, own), default=-1)
    prefixes = {_prefix(file) for file in own} | {name or path.absolute().name}
    own += [file for file in found if number_of(file) > last and _prefix(file) in prefixes]
    own = sorted(own or found, key=number_of)
    if len({_prefix(file) for file in own} - prefixes) > 1:
        raise InputError("several recordings", where=str(path), expected="one bag in a folder")
    for one, other in pairwise(own):
        if number_of(one) == number_of(other):
            raise InputError(f"both {one.name} and {other.name}", where=str(path), expected="one bag in a folder")
    return own


def listed_files(folder: Path) -> set[str]:
    """Return the names of the files that a bag's metadata.yaml names; none if it cannot be read."""
    names = read_metadata(folder).get("relative_file_paths")
    return {name for name in names if isinstance(name, str)} if isinstance(names, list) else set()


def read_metadata(folder: Path) -> dict[str, Any]:
    """Return what a bag's metadata.yaml holds; nothing if there is none, or none that can be read."""
    path = folder / METADATA_FILE
    try:
        if not path.is_file() or path.stat().st_size > _MAX_METADATA_BYTES:
            return {}
        held = read_yaml(path.read_bytes())
    except (OSError, ValueError):
        return {}
    information = held.get("rosbag2_bagfile_information") if isinstance(held, dict) else None
    return information if isinstance(information, dict) else {}


def _prefix(file: Path) -> str:
    match = _NUMBERED.fullmatch(file.name)
    return match[1] if match else ""


def qos_profile(*, latched: bool = False, depth: int = 1000) -> dict[str, Any]:
    """Return the quality of service of a topic as rosbag2's metadata spells it."""
    forever = {"sec": 9223372036, "nsec": 854775807}
    return {
        "history": "keep_last",
        "depth": depth,
        "reliability": "reliable",
        "durability": "transient_local" if latched else "volatile",
        "deadline": forever,
        "lifespan": forever,
        "liveliness": "automatic",
        "liveliness_lease_duration": forever,
        "avoid_ros_namespace_conventions": False,
    }


class Channel(NamedTuple):
    """A topic as a bag describes it: what is needed to read its messages without us.

    Attributes:
        topic: full name, such as ``/candidates``.
        type_name: such as ``mobo_msgs/msg/Candidate``.
        encoding: of the definition, ``ros2msg``.
        definition: of the message type and all it is made of.
        metadata: (name, value) pairs: quality of service, hash of the type.
    """

    topic: str
    type_name: str
    encoding: str
    definition: bytes
    metadata: tuple[tuple[str, str], ...]


@cache
def channel_of(topic: str, kind: str, version: int = SCHEMA_VERSION) -> Channel:
    """Return the channel of a topic (full name) that carries one of mobo's messages, of a schema version."""
    described = schema(kind, version)
    qos = yaml.safe_dump([qos_profile(latched=kind == "StudyStatus")], sort_keys=False)
    metadata = (("offered_qos_profiles", qos), ("topic_type_hash", described.type_hash))
    return Channel(topic, described.name, "ros2msg", described.definition.encode(), metadata)


@dataclass
class FileSummary:
    """What metadata.yaml says of one file.

    Attributes:
        name: file name within the folder.
        first_ns, last_ns: times of the first and last message, ns since the epoch.
        counts: topic -> (its channel, number of messages).
    """

    name: str
    first_ns: int = 0
    last_ns: int = 0
    counts: dict[str, tuple[Channel, int]] = field(default_factory=dict)

    def add(self, channel: Channel, time_ns: int) -> None:
        """Count a message."""
        if not self.n_messages:
            self.first_ns = time_ns
        self.first_ns, self.last_ns = min(self.first_ns, time_ns), max(self.last_ns, time_ns)
        self.counts[channel.topic] = (channel, self.counts.get(channel.topic, (channel, 0))[1] + 1)

    @property
    def n_messages(self) -> int:
        """Number of messages in all."""
        return sum(count for _, count in self.counts.values())


def metadata_of(summaries: Iterable[FileSummary], custom: dict[str, str]) -> dict[str, Any]:
    """Return what metadata.yaml says of a bag's files (version 9, as rosbag2 of Jazzy)."""
    files = list(summaries)
    filled = [file for file in files if file.n_messages]
    start = min((file.first_ns for file in filled), default=0)
    end = max((file.last_ns for file in filled), default=0)
    topics: dict[str, tuple[Channel, int]] = {}
    for file in files:
        for topic, (channel, count) in file.counts.items():
            topics[topic] = (channel, count + topics.get(topic, (channel, 0))[1])
    return {
        "version": 9,
        "storage_identifier": "mcap",
        "duration": {"nanoseconds": end - start},
        "starting_time": {"nanoseconds_since_epoch": start},
        "message_count": sum(count for _, count in topics.values()),
        "topics_with_message_count": [_topic(*topics[name]) for name in sorted(topics)],
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [file.name for file in files],
        "files": [
            {
                "path": file.name,
                "starting_time": {"nanoseconds_since_epoch": file.first_ns},
                "duration": {"nanoseconds": file.last_ns - file.first_ns},
                "message_count": file.n_messages,
            }
            for file in files
        ],
        "custom_data": custom,
        "ros_distro": "jazzy",
    }


def write_metadata(folder: Path, summaries: Iterable[FileSummary], custom: dict[str, str]) -> None:
    """Write metadata.yaml in one piece.

    Raises:
        StudyError: it cannot be written; an older one is left as it was.
    """
    information = metadata_of(summaries, custom)
    text = yaml.safe_dump({"rosbag2_bagfile_information": information}, sort_keys=False)
    try:
        replace_whole(folder / METADATA_FILE, text.encode())
    except OSError as error:
        raise StudyError(f"{folder / METADATA_FILE}: cannot be written ({error.strerror or error})") from None


def _topic(channel: Channel, count: int) -> dict[str, Any]:
    metadata = dict(channel.metadata)
    return {
        "topic_metadata": {
            "name": channel.topic,
            "type": channel.type_name,
            "serialization_format": "cdr",
            "offered_qos_profiles": _qos(metadata.get("offered_qos_profiles", "")),
            "type_description_hash": metadata.get("topic_type_hash", ""),
        },
        "message_count": count,
    }


def _qos(text: str) -> list[Any]:
    """Return the quality of service that a channel's description holds; none if it is not readable."""
    try:
        profiles = read_yaml(text) if len(text) <= _MAX_QOS_BYTES else []
    except ValueError:
        return []
    return profiles if isinstance(profiles, list) else []
