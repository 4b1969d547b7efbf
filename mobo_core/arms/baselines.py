"""Arms that are the first trials of a study: known ones, or those of a table."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

from mobo_core.arms.table import table_arms
from mobo_core.arms.twins import TWIN_OF, known_twins
from mobo_core.bag.files import bag_files
from mobo_core.bag.reader import with_sessions
from mobo_core.coordination.options import OptimizerOptions
from mobo_core.coordination.plan import StudyPlan, plan_study
from mobo_core.design import Design, DesignSpace
from mobo_core.errors import InputError
from mobo_core.messages import Command, decode

KNOWN = "known"
_ROW = re.compile(r"(.+), row \d+")  # how table_arms names arms


def first_arms(
    baselines: str, space: DesignSpace, log: Callable[[str], None] = lambda text: None
) -> tuple[tuple[str, Design], ...]:
    """Return arms that a new study tries first, and where each is from; say so where the space holds no known one.

    Args:
        baselines: ``known`` for :func:`~mobo_core.arms.twins.known_twins`, the path of a table for
            :func:`~mobo_core.arms.table.table_arms`, "" for none.
        space: of the study.
        log: takes a line for people.

    Raises:
        InputError: the table cannot be read, or holds an arm that is none of the space.
    """
    if not baselines:
        return ()
    if baselines != KNOWN:
        return table_arms(baselines, space)
    twins = known_twins(space)
    if not twins:
        log("no known arm has a twin in the space: none is tried first")
    return twins


def checked_plan(options: OptimizerOptions) -> StudyPlan:
    """Return the study that options mean, as :func:`mobo_core.coordination.plan.plan_study` does.

    Raises:
        InputError: likewise; and baselines are named other than those that the bag to go on with began with.
    """
    plan = plan_study(options)
    if not plan.goes_on or "baselines" not in options.model_fields_set:
        return plan
    began, named = _began_with(plan.folder), options.baselines
    wanted = named if named == KNOWN else Path(named).name
    # Where there are no arms to begin with, in a space that holds no twin, nothing differs.
    if began != wanted and (began or first_arms(named, plan.settings.space)):
        expected = f"{named!r}, as asked for now"
        raise InputError(f"baselines is {began!r} in the bag", where=str(plan.folder), expected=expected)
    return plan


def _began_with(folder: Path) -> str:
    """Return ``known``, or the name of the table, by what was enqueued before the first candidate; else ""."""
    for _, entry in with_sessions(bag_files(folder)):
        if entry.kind == "Candidate":
            break
        if entry.kind == "Command":
            command = decode(Command, entry.data)
            if command.command == "enqueue":
                if command.source.startswith(TWIN_OF):
                    return KNOWN
                if row := _ROW.fullmatch(command.source):
                    return row.group(1)
    return ""
