"""The trials of a study as Optuna's own: to measure with its means, and to look at in its dashboard."""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable, Sequence
from datetime import datetime, timedelta
from typing import TYPE_CHECKING

from mobo_core.bag.record import StudyRecord
from mobo_core.errors import InputError, MoboError
from mobo_core.report.row import Row
from mobo_core.report.table import study_table

if TYPE_CHECKING:
    from optuna.storages import BaseStorage
    from optuna.trial import FrozenTrial

_CHUNK = 200  # trials between two notices of progress


def optuna_trials(study: StudyRecord, rows: Sequence[Row]) -> list[FrozenTrial]:
    """Return trials with the sampler's parameters, their values, and when they were sent and told.

    Failed ones have no values; user attributes hold joints, lengths and what else is known of the arm. Rows whose
    candidate is lost or holds no parameters of this space are left out.
    """
    from optuna.trial import TrialState, create_trial

    space, trials = study.settings.space, []
    for row in rows:
        candidate = study.candidate_of(row.trial)
        try:
            params = json.loads(candidate.params_json) if candidate is not None else {}
            distributions = space.distributions(params) if params else {}
            trial = create_trial(
                state=TrialState.COMPLETE if row.complete else TrialState.FAIL,
                params=params,
                distributions=distributions,
                values=list(row.values) if row.complete else None,
                user_attrs=_attributes(row),
            )
        # A bag may claim anything.
        except (ValueError, KeyError, TypeError, AttributeError, ArithmeticError, RecursionError, MoboError):
            continue
        if candidate is not None:
            trial.datetime_start = _time(candidate.header.time_ns)
        trial.datetime_complete = _time(study.trials[row.trial].header.time_ns)
        trials.append(trial)
    return trials


def _attributes(row: Row) -> dict[str, object]:
    attributes: dict[str, object] = {"trial": row.trial, "joints": row.joints, "lengths": list(row.lengths)}
    if row.complete:
        attributes |= {"reach": row.reach, "torque": row.torque}
    return attributes | ({"reason": row.reason} if row.reason else {})


def _time(time_ns: int) -> datetime:
    return datetime.fromtimestamp(0) + timedelta(microseconds=time_ns // 1000)


def export_study(
    study: StudyRecord, url: str, progress: Callable[[int, int], None] = lambda done, total: None
) -> tuple[str, int]:
    """Write a study into a storage of Optuna, under its own name; return the name and the number of trials.

    Args:
        study: as read from its bag.
        url: ``sqlite:///FILE`` or another database that SQLAlchemy knows, or the path of a journal file.
        progress: called with (trials written, trials in all).

    Raises:
        InputError: no such storage, or one that has a study of this name.
    """
    import optuna

    table = study_table(study)
    aims = zip(study.settings.objectives, table.aims, strict=True)
    name = study.name or "study"
    try:
        made = optuna.create_study(
            storage=_storage(url),
            study_name=name,
            directions=["maximize" if aim.maximize else "minimize" for _, aim in aims],
        )
    except optuna.exceptions.DuplicatedStudyError:
        raise InputError(f"has a study {name!r}", where=url, expected="a storage without one of that name") from None
    except Exception as error:  # whatever SQLAlchemy or the file system raises
        reason = " ".join(str(error).split())[:120]
        raise InputError(f"not usable ({reason})", where=url, expected="sqlite:///FILE or a journal file") from None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # experimental, says Optuna
        made.set_metric_names(list(study.settings.objectives))
    trials = optuna_trials(study, table.rows)
    for first in range(0, len(trials), _CHUNK):
        progress(first, len(trials))
        made.add_trials(trials[first : first + _CHUNK])
    progress(len(trials), len(trials))
    return name, len(trials)


def _storage(url: str) -> str | BaseStorage:
    if "://" in url:
        return url
    from optuna.storages import JournalStorage
    from optuna.storages.journal import JournalFileBackend

    return JournalStorage(JournalFileBackend(url))
