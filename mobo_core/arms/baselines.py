"""Arms that are the first trials of a study: known ones, or those of a table."""

from __future__ import annotations

from mobo_core.arms.catalogue import catalogue
from mobo_core.arms.table import table_arms
from mobo_core.design import Design, DesignSpace
from mobo_core.design.numbers import middle
from mobo_core.errors import InputError

KNOWN = "known"
# m, to which lengths of twins are told apart.
_SAME = 1e-3


def first_arms(baselines: str, space: DesignSpace) -> tuple[tuple[str, Design], ...]:
    """Return arms that a new study tries first, and where each is from.

    Args:
        baselines: ``known`` for :func:`known_twins`, the path of a table for
            :func:`~mobo_core.arms.table.table_arms`, "" for none.
        space: of the study.

    Raises:
        InputError: the table cannot be read, or holds an arm that is none of the space.
    """
    if not baselines:
        return ()
    return known_twins(space) if baselines == KNOWN else table_arms(baselines, space)


def known_twins(space: DesignSpace) -> tuple[tuple[str, Design], ...]:
    """Return the idealised twins of the catalogue's arms that lie in a space, and the names of the arms.

    Of arms whose twins are the same to a millimetre the first stands for all.
    """
    found: dict[tuple[object, ...], tuple[str, Design]] = {}
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
        found.setdefault(key, (f"twin of {arm.maker} {arm.name}", design))
    return tuple(found.values())
