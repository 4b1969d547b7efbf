"""What a bag says of its study: settings, candidates, evaluations, and what was told."""

from __future__ import annotations

import json
import platform
import sys
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from mobo_core.bag.files import bag_files
from mobo_core.bag.reader import Entry, FileContent, entries, first_record, read_bag, read_record, stream
from mobo_core.bag.validity import is_good
from mobo_core.design import DesignSpace
from mobo_core.errors import InputError
from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.messages import SCHEMA_VERSION, decode, message_type
from mobo_core.search.study import StudySettings
from mobo_core.version import __version__

_LIBRARIES = ("optuna", "pin", "coal", "numba", "numpy", "xacro", "mcap")
# Settings that stand in the record under their own names, as plain text.
_PLAIN = ("sampler", "n_startup_trials", "seed", "in_flight")


def versions() -> dict[str, str]:
    """Return the versions of mobo, Python and the libraries a study's numbers come from."""
    found = {"mobo": __version__, "python": platform.python_version()}
    for name in _LIBRARIES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:  # a system's own package without Python metadata
            found[name] = "unknown"
    return found


def study_record(name: str, settings: StudySettings) -> dict[str, str]:
    """Return the metadata record ``mobo`` that every file of a bag begins with."""
    values = settings.to_dict()
    return {
        "study": name,
        "space": settings.space.to_json(),
        "spec": settings.spec.to_json(),
        "objectives": ",".join(settings.objectives),
        **{key: str(values[key]) for key in _PLAIN},
        "versions": json.dumps(versions(), sort_keys=True),
        "schema_version": str(SCHEMA_VERSION),
    }


def settings_of(record: dict[str, str], where: str) -> StudySettings:
    """Return the settings that a metadata record holds.

    Raises:
        InputError: no such record, or one of another schema, or one that does not fit.
    """
    if not record:
        raise InputError("holds no study", where=where, expected="a bag that mobo recorded")
    if record.get("schema_version") != str(SCHEMA_VERSION):
        raise InputError(
            f"schema_version {record.get('schema_version')}", where=where, expected=str(SCHEMA_VERSION)
        )
    try:
        return StudySettings.of(
            {
                "space": DesignSpace.of(json.loads(record["space"]), where=f"{where}: space"),
                "spec": EvaluationSpec.of(json.loads(record["spec"]), where=f"{where}: spec"),
                "objectives": record.get("objectives", "reach,torque"),  # which older bags do not say
                **{key: record[key] for key in _PLAIN},
            },
            where=where,
        )
    except (KeyError, ValueError) as error:
        raise InputError(f"metadata record not readable ({error!r:.80})", where=where, expected="a study") from None


@dataclass
class StudyRecord:
    """A study as its bag tells it. Messages are those of :mod:`mobo_core.messages`.

    Attributes:
        path: the bag.
        name: of the study.
        settings: what its trials depend on.
        record: the metadata record itself.
        candidates, evaluations, commands: in the order they were recorded.
        evaluators: joins, leaves and losses.
        trials: trial number -> Trial; the first record of it.
        repeated: numbers of trials that were told more than once.
        denied: numbers of trials told as failed after a good answer had come.
        belated: numbers of trials enqueued after they had been sent out.
        contents: the files.
        best: Evaluation and URDF of the trial of the highest reach; of :func:`past_study` only.
    """

    path: Path
    name: str
    settings: StudySettings
    record: dict[str, str]
    candidates: list[Any] = field(default_factory=list)
    evaluations: list[Any] = field(default_factory=list)
    commands: list[Any] = field(default_factory=list)
    evaluators: list[Any] = field(default_factory=list)
    trials: dict[int, Any] = field(default_factory=dict)
    repeated: list[int] = field(default_factory=list)
    denied: set[int] = field(default_factory=set)
    belated: list[int] = field(default_factory=list)
    contents: list[FileContent] = field(default_factory=list)
    best: tuple[Any, str] | None = None

    @property
    def faults(self) -> list[str]:
        """What is wrong with the files, a line each."""
        return [f"{content.path.name}: {content.fault}" for content in self.contents if content.fault]

    def candidate_of(self, trial: int) -> Any | None:
        """Return the first candidate of a trial."""
        return self._first_candidates().get(trial)

    def _first_candidates(self) -> dict[int, Any]:
        if not hasattr(self, "_first"):
            self._first: dict[int, Any] = {}
            for candidate in self.candidates:
                self._first.setdefault(int(candidate.trial), candidate)
        return self._first

    def accepted(self, trial: int) -> Any | None:
        """Return the evaluation that a trial was told from: the first good one its record names; None if it failed."""
        told = self.trials.get(trial)
        if told is None or told.state != message_type("Trial").COMPLETE:
            return None
        return self._good_answers().get((trial, int(told.attempt), told.evaluator))

    def _good_answers(self) -> dict[tuple[int, int, str], Any]:
        if not hasattr(self, "_good"):
            self._good: dict[tuple[int, int, str], Any] = {}
            for evaluation in self.evaluations:
                if is_good(evaluation, self.settings.spec.n_voxels):
                    key = (int(evaluation.trial), int(evaluation.attempt), evaluation.evaluator)
                    self._good.setdefault(key, evaluation)
        return self._good

    def complete_trials(self) -> list[Any]:
        """Return the Trial messages that carry values, by number."""
        complete = message_type("Trial").COMPLETE
        return [self.trials[n] for n in sorted(self.trials) if self.trials[n].state == complete]


def read_study(path: Path | str) -> StudyRecord:
    """Read a bag as a study; a damaged file counts up to its damage (see :attr:`StudyRecord.faults`).

    Raises:
        InputError: no bag, or not one of a mobo study.
    """
    contents = read_bag(path)
    return study_from(contents, Path(path))


def study_from(contents: list[FileContent], path: Path) -> StudyRecord:
    """Return the study that the contents of a bag's files tell of; errors as :func:`read_study`."""
    first = first_record(contents)
    study = StudyRecord(path, first.get("study", ""), settings_of(first, str(path)), first, contents=contents)
    collector = Collector(study)
    for entry in entries(contents):
        collector.add(entry)
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
    return study


class Collector:
    """Sorts the messages of a bag, as they come, into a StudyRecord; ``lean``: as :func:`past_study` says."""

    def __init__(self, study: StudyRecord, *, lean: bool = False) -> None:
        self._study, self._lean = study, lean
        self._lists = {
            "Candidate": study.candidates,
            "Evaluation": study.evaluations,
            "Command": study.commands,
            "EvaluatorStatus": study.evaluators,
        }
        self._complete = message_type("Trial").COMPLETE
        self._sent: dict[int, set[tuple[int, str]]] = {}  # of the trials not told
        self._answered: set[int] = set()
        self._urdfs: dict[int, str] = {}

    def add(self, entry: Entry) -> None:
        """Take the next message."""
        if entry.kind not in self._lists and entry.kind != "Trial":
            return
        message = decode(entry.kind, entry.data)
        if entry.kind == "Trial":
            self._add_trial(message)
            return
        if entry.kind in ("Candidate", "Evaluation"):
            trial, key = int(message.trial), (int(message.attempt), message.evaluator)
            if entry.kind == "Candidate":
                self._sent.setdefault(trial, set()).add(key)
            elif key in self._sent.get(trial, ()) and is_good(message, self._study.settings.spec.n_voxels):
                self._answered.add(trial)
            if self._lean:
                if entry.kind == "Candidate":
                    self._urdfs.setdefault(trial, message.urdf)
                    # An array of a message holds all of its bytes; names are few.
                    message.urdf, message.spec, message.header = "", None, None
                    message.lengths = message.lengths.copy()
                    message.study, message.evaluator = sys.intern(message.study), sys.intern(message.evaluator)
                elif trial in self._study.trials:
                    return
        elif entry.kind == "Command" and message.command == "enqueue" and int(message.trial) in self._sent:
            self._study.belated.append(int(message.trial))
        self._lists[entry.kind].append(message)

    def _add_trial(self, trial: Any) -> None:
        study, number = self._study, int(trial.trial)
        if number in study.trials:
            study.repeated.append(number)
        study.trials.setdefault(number, trial)
        if trial.state != self._complete and number in self._answered:
            study.denied.add(number)
        if not self._lean:
            return
        trial.header, trial.study, trial.evaluator = None, sys.intern(trial.study), sys.intern(trial.evaluator)
        self._sent.pop(number, None)
        self._answered.discard(number)
        urdf = self._urdfs.pop(number, "")
        told = [evaluation for evaluation in study.evaluations if evaluation.trial == number]
        if told:
            study.evaluations[:] = [evaluation for evaluation in study.evaluations if evaluation.trial != number]
        if trial.state == self._complete and (study.best is None or trial.reach > study.best[0].reach):
            key = int(trial.attempt), trial.evaluator
            n_voxels = study.settings.spec.n_voxels
            good = [e for e in told if (int(e.attempt), e.evaluator) == key and is_good(e, n_voxels)]
            study.best = (good[0], urdf) if good else study.best
