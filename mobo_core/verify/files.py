"""Whether the files of a bag are of one study and one bag: records, hash chain, definitions, metadata.yaml."""

from __future__ import annotations

import json
from collections.abc import Iterator

from mobo_core.bag.chain import ORIGINS
from mobo_core.bag.files import Channel, channel_of, metadata_of, read_metadata
from mobo_core.bag.reader import FileContent
from mobo_core.bag.record import StudyRecord, schema_version_of, settings_of
from mobo_core.bag.writer import custom_data
from mobo_core.errors import InputError
from mobo_core.messages import KINDS, schema, version_of
from mobo_core.verify.fault import Fault


def check_files(study: StudyRecord) -> Iterator[Fault]:
    """Check every file's records, the chain from file to file, and how the bag describes topics."""
    for content in study.contents:
        for _, record in content.sessions:
            yield from (Fault(-1, content.path.name, text) for text in _record_faults(study, record))
            if content.chain.get("origin") == "recorded" and "max_attempts" not in record:
                # Only an older mobo left it out, which knew no chain: failures would pass as its.
                yield Fault(-1, content.path.name, "its record does not say max_attempts")
        if not content.sessions:
            yield Fault(-1, content.path.name, "holds no record of the study")
        yield from (Fault(-1, content.path.name, text) for text in _definition_faults(study, content))
    yield from _chain_faults(study.contents)
    yield from _metadata_faults(study)


def chain_notes(study: StudyRecord) -> list[str]:
    """Return what there is to say of the hash chain, a line each."""
    without = sum(not content.chain for content in study.contents)
    if without == len(study.contents):
        return ["no hash chain: recorded by an older mobo, whose bags do not show whether they are whole"]
    notes = []
    if without:
        notes.append(f"hash chain from file {without} on: an older mobo recorded those before")
    for content in study.contents:
        if content.chain.get("origin", "recorded") != "recorded":
            more = {k: v for k, v in content.chain.items() if k in ("files", "before") and v}
            said = "".join(f", {name} {value!r:.20}" for name, value in more.items())
            notes.append(f"hash chain begins anew in {content.path.name}: {content.chain['origin']!r:.20}{said}")
    return notes or ["hash chain whole"]


def _record_faults(study: StudyRecord, record: dict[str, str]) -> Iterator[str]:
    try:
        settings = settings_of(record, "record")
    except InputError as error:
        yield str(error)
        return
    if record.get("study") != study.name:
        yield f"is of study {record.get('study')!r:.80}, the bag's first of {study.name!r:.80}"
    if difference := study.settings.first_difference(settings):
        setting, first, here = difference
        yield f"its record says {setting} {here!r:.80}, the bag's first {first!r:.80}"
    if record.get("schema_version") != study.record.get("schema_version"):
        yield f"its record says schema_version {record.get('schema_version')!r:.20}"
    try:
        versions = json.loads(record.get("versions", "{}"))
    except (ValueError, RecursionError):
        versions = None
    if not isinstance(versions, dict) or not all(isinstance(value, str) for value in versions.values()):
        yield "versions in its record are no names with versions"
    if (attempts := record.get("max_attempts")) is not None and not (attempts.isdecimal() and int(attempts[:9]) > 0):
        yield f"its record says max_attempts {attempts!r:.20}"


def _definition_faults(study: StudyRecord, content: FileContent) -> Iterator[str]:
    version = schema_version_of(study.record, str(study.path))
    for channel, _ in content.summary.counts.values():
        kind = channel.type_name.removeprefix("mobo_msgs/msg/")
        if kind not in KINDS:
            continue  # which its messages are blamed for
        ours = channel_of(channel.topic, kind, version)
        # Many definitions are the same in several versions.
        if schema(kind, version_of(kind, channel.definition, channel.topic)) != schema(kind, version):
            yield f"{channel.topic}: its definition is not that of schema {version}"
        elif channel.definition != ours.definition and b"#" in channel.definition:
            yield f"{channel.topic}: its definition is not mobo's"
        if _type_hash(channel) != _type_hash(ours) or channel.encoding != ours.encoding:
            yield f"{channel.topic}: its type is described otherwise than mobo's"


def _type_hash(channel: Channel) -> str:
    return dict(channel.metadata).get("topic_type_hash", "")


def _chain_faults(contents: list[FileContent]) -> Iterator[Fault]:
    for i, content in enumerate(contents):
        name, chain, end = content.path.name, content.chain, content.end
        before = contents[i - 1] if i else None
        if before is not None and before.chain and not chain:
            yield Fault(-1, name, "no part of the hash chain, though the file before it is")
        if chain and chain.get("origin") not in ORIGINS:
            yield Fault(-1, name, f"its chain is of origin {chain.get('origin')!r:.40}, which is none")
        if chain and before is not None and before.digest:
            known = {before.digest, before.chain.get("stands_for", before.digest)}
            if chain.get("previous", "") not in known:
                yield Fault(-1, name, f"follows another file than {before.path.name}, which was changed or swapped")
        if chain and before is None and chain.get("previous"):
            yield Fault(-1, name, "follows a file that is not there")
        if chain and content.finished:
            if end.get("sha256") != content.digest:
                yield Fault(-1, name, "was changed: it does not hash to what it says")
            if end.get("messages") != str(content.summary.n_messages):
                yield Fault(-1, name, f"holds {content.summary.n_messages} messages, not {end.get('messages')!r:.20}")


def _metadata_faults(study: StudyRecord) -> Iterator[Fault]:
    if not study.path.is_dir() or not (study.path / "metadata.yaml").exists():
        return
    found = read_metadata(study.path)
    if not found:
        yield Fault(-1, "metadata.yaml", "not readable; mobo bag recover writes it anew")
        return
    expected = metadata_of([content.summary for content in study.contents], custom_data(study.record))
    for name in expected:
        if name == "custom_data":  # of the session that wrote it
            records = [record for content in study.contents for _, record in content.sessions]
            same = found.get(name) in [custom_data(record) for record in records]
        else:
            same = found.get(name) == expected[name]
        if not same:
            yield Fault(-1, "metadata.yaml", f"its {name} is not that of the files; mobo bag recover writes it anew")
