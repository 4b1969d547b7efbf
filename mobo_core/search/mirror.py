"""Mirror twins: arms that are each other's reflection in the plane x = y, so that Roll and Pitch change places."""

from __future__ import annotations

from collections.abc import Iterable

from mobo_core.design import DesignSpace, effective_joints
from mobo_core.evaluation.spec import EvaluationSpec

_SWAPPED = str.maketrans("RP", "PR")


def swapped(joints: str) -> str:
    """Return a joint order with Roll and Pitch exchanged."""
    return joints.translate(_SWAPPED)


def exact_twins(orders: Iterable[str], space: DesignSpace, spec: EvaluationSpec) -> dict[str, str]:
    """Return, of these whole joint orders, those with an exact twin among them: order -> twin.

    With the same lengths such arms differ by the poses drawn alone, where workspace and gravity are the same in x as
    in y. An order whose reflection would break the Yaw rule has no twin: the arm that is built in its place has the
    ranges of its yaw joints turned. Nor has any on a base that leans, with joints that turn further one way than the
    other, with a tool or payload beside its axis, or among boxes, or where poses are given.
    """
    alike = (spec.workspace_min, spec.workspace_max, spec.gravity, spec.payload_com, spec.tool_xyz)
    beside = any(spec.tool_rpy) or spec.obstacles or spec.target_poses
    turned = any(center != 0.0 for center in space.centers)
    if space.base_tilt != 0.0 or turned or beside or any(of[0] != of[1] for of in alike):
        return {}
    known = set(orders)
    pairs = {order: swapped(order) for order in known if set(order) <= set("RPYS")}
    return {a: b for a, b in sorted(pairs.items()) if a != b and b in known and effective_joints(b) == b}
