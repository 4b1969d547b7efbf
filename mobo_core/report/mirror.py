"""Mirror twins: arms that differ by a quarter turn about z alone, so that Roll and Pitch change places."""

from __future__ import annotations

from collections.abc import Iterable

from mobo_core.design import DesignSpace, effective_joints

_SWAPPED = str.maketrans("RP", "PR")


def swapped(joints: str) -> str:
    """Return a joint order with Roll and Pitch exchanged."""
    return joints.translate(_SWAPPED)


def exact_twins(orders: Iterable[str], space: DesignSpace) -> dict[str, str]:
    """Return, of these joint orders, those with an exact twin among them: order -> twin.

    The two arms are one turned by 90 degrees about z, with the same lengths and ranges, so that in a workspace that
    is square about z they differ by the poses drawn alone. An order whose twin would break the Yaw rule has none: the
    arm that is built in its place has the ranges of its yaw joints turned. Nor has any on a base that leans.
    """
    known = set(orders)
    if space.base_tilt != 0.0:
        return {}
    pairs = {order: swapped(order) for order in known if set(order) <= set("RPY")}
    return {a: b for a, b in sorted(pairs.items()) if a != b and b in known and effective_joints(b) == b}
