"""Real arms, where they stand and what they have to hold as plain values, for ``--json``."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mobo_core.arms.place import Distance, Place, Rival
    from mobo_core.arms.real import RealArm
    from mobo_core.arms.size import Sizing
    from mobo_core.arms.what_if import WhatIf
    from mobo_core.atlas.atlas import Atlas


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


def place_dict(
    found: Place, atlas: Atlas, name: str, few: str, which: str, changes: list[WhatIf] | None
) -> dict[str, object]:
    """Return where an arm stands as plain values.

    Args:
        found: where.
        atlas: in which.
        name: of the atlas.
        few: how partial it is; "" if it is not.
        which: arm the changes are of: scaled or own.
        changes: of it; None if none were asked for.
    """

    def distance(one: Distance) -> dict[str, object]:
        values: dict[str, object] = {"better": one.better}
        for key in ("more_reach", "less_torque"):
            rival: Rival | None = getattr(one, key)
            values[key] = None if rival is None else {
                "joints": rival.design.joints, "lengths": list(rival.design.lengths),
                "study": atlas.study[rival.row], "trial": int(atlas.trial[rival.row]),
                "reach": rival.reach.to_dict(), "torque": rival.torque.to_dict(),
                "moves": [{"m": by, "from": source, "to": sink} for by, source, sink in rival.moves],
            }  # fmt: skip
        return values

    def point(result: object) -> dict[str, float]:
        return {key: getattr(result, key) for key in ("reach", "torque")}

    return {
        "arm": arm_dict(found.arm), "evaluation": "scaled", "in": name, "partial": few, "spec": atlas.spec.to_dict(),
        "voxels": atlas.about.n_voxels, "scaled": point(found.scaled),
        "twin": None if found.twin is None else point(found.twin),
        "gains_spec": found.resamples.spec.to_dict(), "front_of_all": distance(found.of_all),
        "front_of_order": None if found.of_order is None else distance(found.of_order),
        "trials_of_order": found.trials_of_order,
        "what_if": None if changes is None else {"of": which, "changes": [change.to_dict() for change in changes]},
    }  # fmt: skip


def sizing_dict(found: Sizing, use: float) -> dict[str, object]:
    """Return what an arm's joints have to hold as plain values; ``use``: share of the motors' torque."""
    centres = found.result.spec.voxel_centres()
    return {
        "payload_kg": found.payload_kg, "use": use, "spec": found.result.spec.to_dict(), "reach": found.result.reach,
        "poses": int(round(found.result.reach * found.result.spec.poses_per_voxel)),
        "payload": kg_or_word(found.payload), "tip": found.result.tip,
        "joints": [
            {
                "joint": one.joint, "median": one.median, "p95": one.p95, "peak": one.peak,
                "peak_at": {
                    "voxel": one.voxel, "pose": one.pose, "centre": centres[one.voxel].tolist(), "q": one.q.tolist(),
                },
                "motor": None if one.motor is None else one.motor.to_dict(),
                "holds": None if math.isinf(one.holds) else one.holds, "payload": kg_or_word(one.payload),
            }
            for one in found.joints
        ],
        "voxel_payload": [None if math.isnan(kg) else kg_or_word(kg) for kg in found.voxel_payload.tolist()],
    }  # fmt: skip


def kg_or_word(payload: float) -> float | str:
    """Return kg, ``any``, or ``none``: not even the arm itself is held."""
    return payload if math.isfinite(payload) else "any" if payload > 0 else "none"
