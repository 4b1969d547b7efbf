"""The joint orders of a space, and which of them are mirror twins."""

from __future__ import annotations

from mobo_core.design import DesignSpace
from mobo_core.design.joints import effective_joints
from mobo_core.evaluation.objectives import OBJECTIVES
from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.search.mirror import exact_twins


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
    """Return for each order that has one its exact mirror twin, where objectives are worth the same in the mirror.

    Orders whose twin the space does not build, as after a yaw there is always a pitch, have none.
    """
    built_in = {objective.name for objective in OBJECTIVES.built_in}
    return exact_twins(sampled_orders(space), space, spec) if set(objectives) <= built_in else {}
