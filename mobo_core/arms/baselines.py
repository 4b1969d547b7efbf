"""Known arms in a study: their idealised twins, which may be its first trials."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from mobo_core.arms.catalogue import catalogue
from mobo_core.arms.real import RealArm
from mobo_core.bag.files import bag_files
from mobo_core.bag.reader import with_sessions
from mobo_core.coordination.options import OptimizerOptions
from mobo_core.coordination.plan import StudyPlan, plan_study
from mobo_core.design import Design, DesignSpace
from mobo_core.design.numbers import middle
from mobo_core.errors import InputError
from mobo_core.messages import Command, decode

_TWIN_OF = "twin of "  # what the source of a command that enqueues one begins with
# m, to which lengths of twins are told apart.
_SAME = 1e-3


@dataclass(frozen=True, eq=False)
class Twin:
    """A design that stands for real arms: of their joint order and the ratio of their lengths.

    Attributes:
        design: of the first arm.
        arms: whose twins are the same to a millimetre.
    """

    design: Design
    arms: tuple[RealArm, ...]


def twins_in(space: DesignSpace) -> tuple[Twin, ...]:
    """Return the idealised twins of the catalogue's arms that lie in a space, in the catalogue's order."""
    found: dict[tuple[object, ...], tuple[Design, list[RealArm]]] = {}
    for arm in catalogue():
        order = arm.order
        if order is None or arm.n != space.n_joints:
            continue
        try:
            design = space.arm(order.joints, order.twin(middle(space.total_length)))
            space.params(design)
        except InputError:  # too long a link for the space, say, or a joint that it lacks
            continue
        key = (order.joints, *(round(length / _SAME) for length in design.lengths))
        found.setdefault(key, (design, []))[1].append(arm)
    return tuple(Twin(design, tuple(arms)) for design, arms in found.values())


def known_twins(space: DesignSpace) -> tuple[tuple[str, Design], ...]:
    """Return the twins of :func:`twins_in` as first trials: the name of the first arm, which stands for all, and it."""
    return tuple((f"{_TWIN_OF}{twin.arms[0].maker} {twin.arms[0].name}", twin.design) for twin in twins_in(space))


def first_arms(
    options: OptimizerOptions, space: DesignSpace, log: Callable[[str], None] = print
) -> tuple[tuple[str, Design], ...]:
    """Return the first trials that an optimizer is told of; say so where it is told of some, and there are none."""
    twins = known_twins(space) if options.baselines else ()
    if options.baselines and not twins:
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
    began = "known" if _begins_with_twins(plan.folder) else ""
    # In a space that holds no twin there are none to begin with.
    if began != options.baselines and (began or known_twins(plan.settings.space)):
        expected = f"{options.baselines!r}, as asked for now"
        raise InputError(f"baselines is {began!r} in the bag", where=str(plan.folder), expected=expected)
    return plan


def _begins_with_twins(folder: Path) -> bool:
    """Return whether the bag has a twin enqueued before its first candidate; no more of it is read."""
    for _, entry in with_sessions(bag_files(folder)):
        if entry.kind == "Candidate":
            return False
        if entry.kind == "Command":
            command = decode(Command, entry.data)
            if command.command == "enqueue" and command.source.startswith(_TWIN_OF):
                return True
    return False
