"""The joint orders of a space, and which of them are mirror twins."""

from __future__ import annotations

from mobo_core.design import DesignSpace
from mobo_core.design.joints import effective_joints
from mobo_core.evaluation.objectives import OBJECTIVES
from mobo_core.evaluation.spec import EvaluationSpec

# Of a roll's axis, x, and a pitch's, y; those of the others are their own mirror images.
_SWAPPED = str.maketrans("RP", "PR")
_SYMMETRIC = "RPYS"


def sampled_orders(space: DesignSpace) -> dict[str, str]:
    """Return for each order that the space builds letters that may be drawn for it, in the order of its letters."""
    found: dict[str, str] = {"": ""}
    for letters in space.places:
        longer: dict[str, str] = {}
        for sampled in found.values():
            for letter in letters:
                longer.setdefault(effective_joints(sampled + letter), sampled + letter)
        found = longer
    return found


def twins(space: DesignSpace, spec: EvaluationSpec, objectives: tuple[str, ...]) -> dict[str, str]:
    """Return for each order that has one its mirror twin: rolls as pitches, and the other way round.

    A mirror that swaps x and y makes of an arm of any lengths its twin of the same lengths. So the two are worth
    alike, but for where poses happen to lie, if workspace, gravity and base are the same in the mirror. Orders whose
    twin the space does not build, as after a yaw there is always a pitch, have none.
    """
    (x_low, y_low, _), (x_high, y_high, _) = spec.workspace_min, spec.workspace_max
    same = (x_low, x_high, spec.gravity[0]) == (y_low, y_high, spec.gravity[1]) and space.base_tilt == 0.0
    built_in = {objective.name for objective in OBJECTIVES.built_in}
    if not same or not set(space.letters) <= set(_SYMMETRIC) or not set(objectives) <= built_in:
        return {}
    orders = sampled_orders(space)
    pairs = {order: order.translate(_SWAPPED) for order in orders}
    return {order: twin for order, twin in pairs.items() if twin != order and twin in orders}
