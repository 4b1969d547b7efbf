"""Reads a bag as a study: its messages, decoded by the definitions in the bag, sorted as they come."""

from __future__ import annotations

import gc
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mobo_core.bag.files import bag_files
from mobo_core.bag.reader import Entry, FileContent, first_record, read_bag, read_record, stream
from mobo_core.bag.record import StudyRecord, settings_of
from mobo_core.bag.validity import check_plain, is_good
from mobo_core.messages import (
    KINDS,
    Candidate,
    Command,
    Evaluation,
    EvaluatorStatus,
    Header,
    Message,
    SpecMessage,
    StudyStatus,
    Trial,
    address,
    decode,
    version_of,
)

_NO_HEADER, _NO_SPEC = Header(), SpecMessage()


def message_of(entry: Entry) -> Message | None:
    """Return the message that a bag holds, by the definition it holds of it; None if it is not one of mobo's.

    Raises:
        InputError: bytes that are no such message, or a definition that is none of mobo's.
    """
    cls = KINDS.get(entry.kind)
    if cls is None:
        return None
    return decode(cls, entry.data, version_of(entry.kind, entry.channel.definition, entry.topic))


def read_study(path: Path | str) -> StudyRecord:
    """Read a bag as a study; a damaged file counts up to its damage (see :attr:`StudyRecord.faults`).

    Raises:
        InputError: no bag, or not one of a mobo study.
    """
    with _nothing_collected():
        return study_from(read_bag(path), Path(path))


@contextmanager
def _nothing_collected() -> Iterator[None]:
    """Have Python not look for circles inside: messages have none, and looking takes a tenth of the time."""
    was = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was:
            gc.enable()


def study_from(contents: list[FileContent], path: Path) -> StudyRecord:
    """Return the study that the contents of a bag's files tell of; errors as :func:`read_study`."""
    first = first_record(contents)
    study = StudyRecord(path, first.get("study", ""), settings_of(first, str(path)), first, contents=contents)
    collector = Collector(study)
    for content in contents:
        at = 0
        for number, entry in enumerate(content.entries):
            while at < len(content.sessions) - 1 and content.sessions[at + 1][0] <= number:
                at += 1
            record = content.sessions[at][1] if content.sessions else {}
            study.messages.append((record, entry, collector.add(entry)))
    return study


def past_study(path: Path) -> StudyRecord:
    """Read of a bag what a study needs to go on, a message at a time; errors as :func:`read_study`.

    Candidates come without URDF, spec and header, and evaluations of trials that were told are left out, but for the
    best one (:attr:`StudyRecord.best`).
    """
    first = read_record(path)
    study = StudyRecord(path, first.get("study", ""), settings_of(first, str(path)), first)
    collector = Collector(study, lean=True)
    for file in bag_files(path):
        study.contents.append(FileContent(file))
        for entry in stream(study.contents[-1]):
            collector.add(entry)
    collector.end()
    return study


class Collector:
    """Sorts the messages of a bag, as they come, into a StudyRecord; ``lean``: as :func:`past_study` says."""

    def __init__(self, study: StudyRecord, *, lean: bool = False) -> None:
        self._study, self._lean = study, lean
        self._sent: dict[int, set[tuple[int, str]]] = {}  # of the trials not told
        self._answers: dict[int, list[tuple[int, Entry]]] = {}  # of the same, not decoded; with their place in the bag
        self._n = 0
        self._urdfs: dict[int, str] = {}

    def add(self, entry: Entry) -> Message | None:
        """Take the next message, and return it; None if it is none of mobo's."""
        if self._lean and entry.kind == Evaluation.kind:
            self._keep(entry)
            return None
        study, message = self._study, message_of(entry)
        if message is not None:
            check_plain(message, str(study.path))
        match message:
            case Candidate():
                self._sent.setdefault(message.trial, set()).add((message.attempt, message.evaluator))
                if self._lean:
                    self._strip(message)
                study.candidates.append(message)
            case Evaluation():
                study.evaluations.append(message)
            case Trial():
                self._add_trial(message)
            case Command():
                study.commands.append(message)
            case EvaluatorStatus():
                study.evaluators.append(message)
            case StudyStatus():
                study.n_trials = int(message.n_trials)
            case _:
                pass
        return message

    def end(self) -> None:
        """Have the answers that wait in the study, once all messages are taken."""
        waiting = sorted((pair for pairs in self._answers.values() for pair in pairs), key=lambda pair: pair[0])
        self._study.evaluations += [self._decoded(entry) for _, entry in waiting]

    def _keep(self, entry: Entry) -> None:
        """Keep an answer as bytes: of most nobody asks for more than whom they are from."""
        of = address(entry.data)
        # What came before it was asked for counted for nothing, and shall not count now.
        if (of.attempt, of.evaluator) in self._sent.get(of.trial, ()):
            self._n += 1
            self._answers.setdefault(of.trial, []).append((self._n, entry))

    def _decoded(self, entry: Entry) -> Evaluation:
        message = message_of(entry)
        assert isinstance(message, Evaluation)
        check_plain(message, str(self._study.path))
        return message

    def _strip(self, candidate: Candidate) -> None:
        """Keep of a candidate what a study needs to go on."""
        self._urdfs.setdefault(candidate.trial, candidate.urdf)
        # An array of a message holds all of its bytes; names are few.
        candidate.urdf, candidate.spec, candidate.header = "", _NO_SPEC, _NO_HEADER
        candidate.lengths = candidate.lengths.copy()
        candidate.study, candidate.evaluator = sys.intern(candidate.study), sys.intern(candidate.evaluator)

    def _add_trial(self, trial: Trial) -> None:
        study, number = self._study, trial.trial
        if number in study.trials:
            study.repeated.append(number)
        study.trials.setdefault(number, trial)
        if not self._lean:
            return
        trial.header, trial.study, trial.evaluator = _NO_HEADER, sys.intern(trial.study), sys.intern(trial.evaluator)
        self._sent.pop(number, None)
        urdf = self._urdfs.pop(number, "")
        waiting = self._answers.pop(number, ())
        if trial.state == Trial.COMPLETE and (study.best is None or trial.reach > study.best[0].reach):
            key = (trial.attempt, trial.evaluator)
            told = [self._decoded(answer) for _, answer in waiting]
            good = [e for e in told if (e.attempt, e.evaluator) == key and is_good(e, study.settings)]
            study.best = (good[0], urdf) if good else study.best
