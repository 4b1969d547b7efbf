"""The files of a bag: a folder NAME with NAME_0.mcap, NAME_1.mcap, … and metadata.yaml."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from mobo_core.errors import InputError
from mobo_core.messages import schema

METADATA_FILE = "metadata.yaml"


def bag_files(folder: Path | str) -> list[Path]:
    """Return the MCAP files of a bag in the order they were written; a single file is a bag of one.

    Raises:
        InputError: no such folder, or no MCAP file in it.
    """
    path = Path(folder)
    if path.is_file():
        return [path]
    if not path.is_dir():
        raise InputError("no such bag", where=str(path), expected="the folder of a bag, or an .mcap file")
    found = {}
    for file in path.glob("*.mcap"):
        match = re.fullmatch(r".*_(\d+)\.mcap", file.name)
        if match:
            found[int(match[1])] = file
    if not found:
        raise InputError("not a bag", where=str(path), expected="files NAME_0.mcap, NAME_1.mcap, …")
    return [found[number] for number in sorted(found)]


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


@dataclass
class FileSummary:
    """What metadata.yaml says of one file.

    Attributes:
        name: file name within the folder.
        first_ns, last_ns: times of the first and last message, ns since the epoch.
        counts: topic -> (message kind, number of messages).
    """

    name: str
    first_ns: int = 0
    last_ns: int = 0
    counts: dict[str, tuple[str, int]] = field(default_factory=dict)

    def add(self, topic: str, kind: str, time_ns: int) -> None:
        """Count a message."""
        if not self.n_messages:
            self.first_ns = time_ns
        self.first_ns, self.last_ns = min(self.first_ns, time_ns), max(self.last_ns, time_ns)
        self.counts[topic] = (kind, self.counts.get(topic, (kind, 0))[1] + 1)

    @property
    def n_messages(self) -> int:
        """Number of messages in all."""
        return sum(count for _, count in self.counts.values())


def write_metadata(folder: Path, summaries: Iterable[FileSummary], custom: dict[str, str]) -> None:
    """Write metadata.yaml (version 9, as rosbag2 of Jazzy) in one piece."""
    files = list(summaries)
    filled = [file for file in files if file.n_messages]
    start = min((file.first_ns for file in filled), default=0)
    end = max((file.last_ns for file in filled), default=0)
    topics: dict[str, tuple[str, int]] = {}
    for file in files:
        for topic, (kind, count) in file.counts.items():
            topics[topic] = (kind, count + topics.get(topic, (kind, 0))[1])
    information = {
        "version": 9,
        "storage_identifier": "mcap",
        "duration": {"nanoseconds": end - start},
        "starting_time": {"nanoseconds_since_epoch": start},
        "message_count": sum(count for _, count in topics.values()),
        "topics_with_message_count": [_topic(name, *topics[name]) for name in sorted(topics)],
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
    text = yaml.safe_dump({"rosbag2_bagfile_information": information}, sort_keys=False)
    part = folder / (METADATA_FILE + ".part")
    part.write_text(text, encoding="utf-8")
    os.replace(part, folder / METADATA_FILE)


def _topic(name: str, kind: str, count: int) -> dict[str, Any]:
    described = schema(kind)
    return {
        "topic_metadata": {
            "name": name,
            "type": described.name,
            "serialization_format": "cdr",
            "offered_qos_profiles": [qos_profile(latched=kind == "StudyStatus")],
            "type_description_hash": described.type_hash,
        },
        "message_count": count,
    }
