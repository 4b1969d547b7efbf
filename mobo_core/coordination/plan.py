"""Which study an optimizer's options mean: a new one, or the one of a bag, which says all that they do not name."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from mobo_core.bag.study_bag import check_new, recorded_study
from mobo_core.coordination.options import OptimizerOptions
from mobo_core.errors import InputError
from mobo_core.search.study import StudySettings, first_difference

_DEFAULT_TRIALS: int = OptimizerOptions.model_fields["n_trials"].default


@dataclass(frozen=True)
class StudyPlan:
    """A study to run.

    Attributes:
        name: of the study.
        folder: of its bag.
        settings: what its trials depend on.
        goes_on: whether the bag exists.
    """

    name: str
    folder: Path
    settings: StudySettings
    goes_on: bool

    def notice(self, options: OptimizerOptions) -> str:
        """Return a line for who asked to go on with a bag that is not there, or ""."""
        return f"no bag {self.folder} to resume: a new study" if options.resume and not self.goes_on else ""


def plan_study(options: OptimizerOptions) -> StudyPlan:
    """Return the study that ``options`` mean, touching nothing.

    Raises:
        InputError: a value or file that does not fit; a bag that exists, or does not, or is of another study; a
            named setting that differs from the bag's.
    """
    plan = _plan(options)
    options.check(plan.settings)
    return plan


def _plan(options: OptimizerOptions) -> StudyPlan:
    folder = options.folder
    if not (options.resume or options.must_resume):
        check_new(folder)
        return StudyPlan(options.study_name, folder, options.settings(), goes_on=False)
    recorded = recorded_study(folder)
    if recorded is None:
        if options.must_resume:
            raise InputError("no such bag", where=str(folder), expected="one to go on with, as must_resume says")
        return StudyPlan(options.study_name, folder, options.settings(), goes_on=False)
    name, settings = recorded
    if "study_name" in options.model_fields_set and options.study_name != name:
        raise InputError(f"holds study {name!r}", where=str(folder), expected=f"study {options.study_name!r}")
    _check_named(options.named(settings), settings, str(folder))
    return StudyPlan(name, folder, settings, goes_on=True)


def total_trials(options: OptimizerOptions, recorded: int, told: int) -> int:
    """Return the trials that a bag shall hold in all.

    Args:
        options: of the optimizer.
        recorded: what the bag says; 0 if nothing.
        told: trials that it holds: a smaller total asks for none.
    """
    named = "n_trials" in options.model_fields_set
    return max(options.n_trials if named else recorded or _DEFAULT_TRIALS, told)


def _check_named(asked: dict[str, object], settings: StudySettings, where: str) -> None:
    difference = first_difference(settings.to_dict(), asked)
    if difference:
        setting, old, new = difference
        raise InputError(f"{setting} is {old!r} in the bag", where=where, expected=f"{new!r}, as asked for now")
