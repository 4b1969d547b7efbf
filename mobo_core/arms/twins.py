"""Known arms in a study: their idealised twins."""

from __future__ import annotations

from dataclasses import dataclass

from mobo_core.arms.catalogue import catalogue
from mobo_core.arms.real import RealArm
from mobo_core.design import Design, DesignSpace
from mobo_core.design.numbers import middle
from mobo_core.errors import InputError

TWIN_OF = "twin of "  # what the names of known arms' twins begin with
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
    return tuple((f"{TWIN_OF}{twin.arms[0].maker} {twin.arms[0].name}", twin.design) for twin in twins_in(space))
