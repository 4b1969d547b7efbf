"""Known arms as the first trials of a study."""

from __future__ import annotations

from mobo_core.arms.catalogue import catalogue
from mobo_core.design import Design, DesignSpace
from mobo_core.design.numbers import middle
from mobo_core.errors import InputError

# m, to which lengths of twins are told apart.
_SAME = 1e-3


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
