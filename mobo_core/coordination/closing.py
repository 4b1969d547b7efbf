"""The last line of a study: what there is, and the command that comes next."""

from __future__ import annotations

import shlex
from pathlib import Path

from mobo_core.bag.blank import is_blank
from mobo_core.bag.collector import read_study
from mobo_core.bag.validity import values_of
from mobo_core.coordination.arguments import command_line, parameter_word
from mobo_core.coordination.options import OptimizerOptions, StudyOptions
from mobo_core.errors import InputError
from mobo_core.messages import StudyStatus
from mobo_core.search.front import RunningFront

# What the bag does not say: how a study is run.
_HOW = ("bag", "lease_s", "max_attempts", "evaluation_timeout_s")
_ON_THIS_HOST = ("evaluators", "workers", "threads", "engine", "simulated_s", "memory_mb")


def go_on_command(options: OptimizerOptions, name: str, namespace: str = "/") -> str:
    """Return the command that goes on with a study that was run with ``options``, from its bag."""
    words = [] if namespace == "/" else ["-r", f"__ns:={namespace}"]
    words += ["-p", parameter_word("study_name", name)]
    for field in (*_HOW, *_ON_THIS_HOST):
        if field in options.model_fields_set:
            words += ["-p", parameter_word(field, getattr(options, field))]
    executable = "study" if isinstance(options, StudyOptions) else "optimizer"
    return command_line(executable, [*words, "-p", "resume:=true"])


def is_last(status: StudyStatus | None) -> bool:
    """Return whether nothing comes after a status."""
    return status is not None and status.state in (StudyStatus.DONE, StudyStatus.STOPPED, StudyStatus.FAILED)


def closing_line(status: StudyStatus | None, folder: Path, go_on: str) -> str:
    """Return the line on a study that ended.

    Args:
        status: the last that was heard of it; unless it is its last word, the bag is asked.
        folder: of the bag.
        go_on: the command that goes on with it.
    """
    if not is_last(status):
        status = _from_bag(folder, status)
    if status is None or not status.asked or not folder.is_dir() or is_blank(folder):
        return f"stopped before the first trial; nothing is left in {folder} that would hinder a new start"
    told = f"{status.told:,}"
    if status.state == StudyStatus.DONE:
        failed = f", {status.failed:,} of them failed" if status.failed else ""
        found = f"best reach {status.best_reach:.1f}, {status.front_size} arms on the front"
        return f"done: {told} trials{failed}, {found}, {folder}; next: {_report(folder)}"
    of = f" of {status.n_trials:,}" if status.n_trials else ""
    return f"stopped at {told}{of} trials, {folder}; go on: {go_on}"


def _report(folder: Path) -> str:
    return shlex.join(["mobo", "report", str(folder), "-o", "report"])


def _from_bag(folder: Path, heard: StudyStatus | None) -> StudyStatus | None:
    """Return what the bag says of a study whose optimizer had no last word."""
    try:
        study = read_study(folder)
    except InputError:
        return None
    total, told, complete = study.n_trials, len(study.trials), study.complete_trials()
    if not total and heard is not None:
        total = int(heard.n_trials)
    front = RunningFront(study.settings.aims)
    for trial in complete:
        front.add(values_of(trial, study.settings.objectives))
    return StudyStatus(
        study=study.name,
        state=StudyStatus.DONE if 0 < total <= told else StudyStatus.STOPPED,
        n_trials=total,
        asked=len({candidate.trial for candidate in study.candidates}),
        told=told,
        failed=told - len(complete),
        best_reach=max((trial.reach for trial in complete), default=0.0),
        front_size=len(front),
    )
