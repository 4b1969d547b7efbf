"""Bags as arguments of commands: read with a notice, damage told and gone on from; one trial of a bag."""

from __future__ import annotations

import fcntl
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mobo_core.bag.lock import LOCK_FILE, MAX_LOCK_BYTES, holder_name, open_lock
from mobo_core.bag.record import StudyRecord
from mobo_core.commands import progress
from mobo_core.errors import InputError, visible
from mobo_core.messages import Candidate


def read_bag_argument(bag: str) -> StudyRecord:
    """Read the study of a bag; say on standard error what of it cannot be read.

    Raises:
        InputError: no bag, or not one of a mobo study.
    """
    study = read_with_notice(bag)
    for line in fault_lines(study):
        print(line, file=sys.stderr)
    return study


def read_with_notice(bag: str) -> StudyRecord:
    """Read the study of a bag; its faults are the caller's to tell.

    Raises:
        InputError: no bag, or not one of a mobo study.
    """
    from mobo_core.bag.collector import read_study

    with notice(f"reading {bag}"):
        return read_study(bag)


def read_lean_argument(bag: str) -> StudyRecord:
    """Read of a bag trials and designs, without URDFs and maps, which takes little memory; tell its faults likewise.

    Raises:
        InputError: no bag, or not one of a mobo study.
    """
    from mobo_core.bag.collector import past_study

    with notice(f"reading {bag}"):
        study = past_study(Path(bag))
    for fault in study.faults:
        print(fault, file=sys.stderr)
    return study


def fault_lines(study: StudyRecord) -> list[str]:
    """Return a line for each file that does not end as it should."""
    writer = lock_holder(study.path)
    lines = []
    for content in study.contents:
        if content.fault:
            last = content is study.contents[-1]
            fault = f"still written to by {writer}" if writer and last and content.cut_off else content.fault
            lines.append(visible(f"{content.path}: {fault}; {len(content.entries)} messages read"))
    return lines


def lock_holder(bag: Path) -> str:
    """Return who writes to a bag at this moment, or ""; the bag stays as it is."""
    try:
        with open_lock((bag if bag.is_dir() else bag.parent) / LOCK_FILE) as file:
            try:
                fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
            except BlockingIOError:
                return holder_name(file.read(MAX_LOCK_BYTES))
    except (OSError, InputError):
        pass
    return ""


@contextmanager
def notice(text: str) -> Iterator[None]:
    """Show what is going on, on standard error: on a terminal until it is done, elsewhere a line if it takes long."""
    if not sys.stderr.isatty():
        late = threading.Timer(progress.FIRST_S, print, (f"{text} …",), {"file": sys.stderr, "flush": True})
        late.daemon = True
        late.start()
        try:
            yield
        finally:
            late.cancel()
        return
    from rich.console import Console
    from rich.text import Text

    with Console(stderr=True).status(Text(text)):
        yield


def candidate_argument(study: StudyRecord, trial: int) -> Candidate:
    """Return the first candidate of a trial that ``--trial`` names.

    Raises:
        InputError: the bag has none.
    """
    candidate = study.candidate_of(trial)
    if candidate is None:
        sent = [int(candidate.trial) for candidate in study.candidates]
        known = f"one of trials {min(sent)} to {max(sent)}" if sent else "a bag with candidates"
        raise InputError(f"no candidate of trial {trial} in {study.path}", where="--trial", expected=known)
    return candidate
