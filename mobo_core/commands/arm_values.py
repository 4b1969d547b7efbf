"""Real arms as plain values, for ``--json``."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mobo_core.arms.real import RealArm


def arm_dict(arm: RealArm) -> dict[str, object]:
    """Return an arm as plain values: m, kg, rad; limits of joints that slide, whose pinions ``slides`` has, in m."""
    order = arm.order
    assert order is not None
    return {
        "name": arm.name, "maker": arm.maker, "paper": arm.paper, "joints": order.joints, "length": arm.length,
        "lengths": list(order.lengths), "skew": order.skew, "offset": order.offset, "straightened": list(order.q),
        "limits": [[joint.lower, joint.upper] for joint in arm.joints],
        "slides": [joint.slide if joint.slides else None for joint in arm.joints], "segments": list(arm.segments),
        "masses": None if arm.bodies is None else [mass for mass, _ in arm.bodies],
        "estimated": list(arm.estimated), "source": arm.source, "licence": arm.licence,
    }  # fmt: skip
