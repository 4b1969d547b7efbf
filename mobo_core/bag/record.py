"""What a bag says of its study: settings, candidates, evaluations, and what was told."""

from __future__ import annotations

import json
import platform
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from mobo_core.bag.reader import Entry, FileContent
from mobo_core.bag.validity import evaluation_fault
from mobo_core.design import DesignSpace
from mobo_core.errors import InputError
from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.messages import (
    SCHEMA_VERSION,
    VERSIONS,
    Candidate,
    Command,
    Evaluation,
    EvaluatorStatus,
    Message,
    Trial,
)
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


def study_record(name: str, settings: StudySettings, schema_version: int = SCHEMA_VERSION) -> dict[str, str]:
    """Return the metadata record ``mobo`` that every file of a bag begins with."""
    values = settings.to_dict()
    return {
        "study": name,
        "space": settings.space.to_json(),
        "spec": settings.spec.to_json(),
        "objectives": ",".join(settings.objectives),
        **{key: str(values[key]) for key in (*_PLAIN, "sampler_rules")},
        "engine": settings.engine,
        "versions": json.dumps(versions(), sort_keys=True),
        "schema_version": str(schema_version),
    }


def schema_version_of(record: dict[str, str], where: str) -> int:
    """Return the schema version that a metadata record names.

    Raises:
        InputError: none that this mobo knows.
    """
    named = record.get("schema_version")
    for known in VERSIONS:
        if named == str(known):
            return known
    raise InputError(f"schema_version {named}", where=where, expected=" or ".join(map(str, VERSIONS)))


def settings_of(record: dict[str, str], where: str) -> StudySettings:
    """Return the settings that a metadata record holds.

    Raises:
        InputError: no such record, or one of another schema, or one that does not fit.
    """
    if not record:
        raise InputError("holds no study", where=where, expected="a bag that mobo recorded")
    schema_version_of(record, where)
    try:
        return StudySettings.of(
            {
                "space": DesignSpace.of(json.loads(record["space"]), where=f"{where}: space"),
                "spec": EvaluationSpec.of(json.loads(record["spec"]), where=f"{where}: spec"),
                "objectives": record.get("objectives", "reach,torque"),  # which older bags do not say
                "engine": record.get("engine", ""),
                "sampler_rules": record.get("sampler_rules", "1"),  # likewise
                **{key: record[key] for key in _PLAIN},
            },
            where=where,
        )
    except (KeyError, ValueError, TypeError, RecursionError) as error:
        raise InputError(f"metadata record not readable ({error!r:.80})", where=where, expected="a study") from None


@dataclass(repr=False)
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
        messages: all in their order, each with the record of its session and as the bag holds it; None for what is
            none of mobo's. Empty in :func:`past_study`.
        contents: the files.
        n_trials: the total that its last session was to reach; 0 if no session says.
        best: Evaluation and URDF of the trial of the highest reach; of :func:`past_study` only.
    """

    path: Path
    name: str
    settings: StudySettings
    record: dict[str, str]
    candidates: list[Candidate] = field(default_factory=list)
    evaluations: list[Evaluation] = field(default_factory=list)
    commands: list[Command] = field(default_factory=list)
    evaluators: list[EvaluatorStatus] = field(default_factory=list)
    trials: dict[int, Trial] = field(default_factory=dict)
    repeated: list[int] = field(default_factory=list)
    messages: list[tuple[dict[str, str], Entry, Message | None]] = field(default_factory=list)
    contents: list[FileContent] = field(default_factory=list)
    n_trials: int = 0
    best: tuple[Evaluation, str] | None = None

    def __repr__(self) -> str:
        """Return a line: name, trials, bag."""
        told, complete = len(self.trials), len(self.complete_trials())
        failed = f", {told - complete} failed" if told > complete else ""
        return f"StudyRecord({self.name!r}: {told} trials told{failed}; {self.path})"

    @property
    def faults(self) -> list[str]:
        """What is wrong with the files, a line each."""
        return [f"{content.path.name}: {content.fault}" for content in self.contents if content.fault]

    def candidate_of(self, trial: int) -> Candidate | None:
        """Return the first candidate of a trial."""
        return self._first_candidates().get(trial)

    def _first_candidates(self) -> dict[int, Candidate]:
        if not hasattr(self, "_first"):
            self._first: dict[int, Candidate] = {}
            for candidate in self.candidates:
                self._first.setdefault(candidate.trial, candidate)
        return self._first

    def accepted(self, trial: int) -> Evaluation | None:
        """Return the evaluation that a trial was told from: the first good one its record names; None if it failed."""
        told = self.trials.get(trial)
        if told is None or told.state != Trial.COMPLETE:
            return None
        return self._good_answers().get((trial, told.attempt, told.evaluator))

    def _good_answers(self) -> dict[tuple[int, int, str], Evaluation]:
        if not hasattr(self, "_good"):
            self._good: dict[tuple[int, int, str], Evaluation] = {}
            n_voxels, objectives = self.settings.spec.n_voxels, self.settings.objectives
            for evaluation in self.evaluations:
                if evaluation.status == Evaluation.OK and not evaluation_fault(evaluation, n_voxels, objectives):
                    key = (evaluation.trial, evaluation.attempt, evaluation.evaluator)
                    self._good.setdefault(key, evaluation)
        return self._good

    def complete_trials(self) -> list[Trial]:
        """Return the Trial messages that carry values, by number."""
        return [self.trials[n] for n in sorted(self.trials) if self.trials[n].state == Trial.COMPLETE]
