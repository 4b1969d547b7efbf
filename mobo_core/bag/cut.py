"""Cuts a bag before a trial, so that a resumed study asks anew from there."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path

from mobo_core.bag.chain import beginning
from mobo_core.bag.collector import message_of
from mobo_core.bag.compact import rewrite_bag, whole_bag
from mobo_core.bag.reader import Entry, first_record, with_sessions
from mobo_core.errors import InputError
from mobo_core.messages import Candidate, Command, Evaluation, StudyStatus, Trial, encode, version_of

Messages = Iterable[tuple[dict[str, str], Entry]]


def cut_bag(folder: Path, before: int) -> Path:
    """Keep of a bag what was recorded until trial ``before`` - 1 was told, and nothing of later trials.

    Commands that came by then stay in force. The bag as it was is kept beside it; return where.

    Raises:
        InputError: no bag, or one that is not whole; fewer trials are told.
        StudyError: no room, as :func:`mobo_core.bag.compact.compact_bag`; the bag is as it was.
    """
    folder, contents = whole_bag(folder)
    paths = [content.path for content in contents]
    told = {message.trial for _, _, message in _kept(with_sessions(paths), before) if isinstance(message, Trial)}
    missing = next((number for number in range(len(told) + 1) if number not in told), 0)
    if missing < before:
        raise InputError(str(before), where="--before", expected=f"at most {missing}, the trials told in {folder}")
    chain = beginning("cut", before=str(before), was=contents[-1].digest)
    kept = ((session, entry) for session, entry, _ in _kept(with_sessions(paths), before))
    whole = folder.with_name(f"{folder.name}_uncut")
    number = 1
    while os.path.lexists(whole):
        number += 1
        whole = folder.with_name(f"{folder.name}_uncut{number}")
    rewrite_bag(folder, first_record(contents), kept, chain, whole)
    return whole


def _kept(messages: Messages, before: int) -> Iterator[tuple[dict[str, str], Entry, object]]:
    """Yield the messages that stay."""
    told: set[int] = set()
    for session, entry in messages:
        message = message_of(entry)
        match message:
            case Candidate() | Evaluation() | Trial() if message.trial >= before:
                if not before:
                    return
                continue
            case StudyStatus() if message.state != StudyStatus.RUNNING:
                continue  # it counts what goes
            case StudyStatus() if message.asked > before:
                # A session that began with later trials under way: they go.
                version = version_of(entry.kind, entry.channel.definition, entry.topic)
                entry = replace(entry, data=encode(replace(message, asked=before), version))
            case Command() if message.command == "stop":
                continue
            case Trial():
                told.add(message.trial)
        yield session, entry, message
        if before and len(told) == before:
            return
