"""What an atlas says: the structures themselves, every order searched alone."""

from __future__ import annotations

from mobo_core.atlas.atlas import SEARCHED, Atlas
from mobo_core.errors import InputError, MoboError
from mobo_core.report.claims.evidence import Arm, Evidence, Maps

# Share of the box that as many trials again may be expected to add to an order's own, at most, for it to be known;
# about what 2 voxels of 75 are worth at the reach and torque of good arms.
KNOWN_GAIN = 0.01


def of_atlas(atlas: Atlas) -> Evidence:
    """Return the arms of an atlas as evidence; the voxels of those that claims ask for are evaluated.

    An order is known if it got a thousand trials, or if little is expected of more.

    Raises:
        InputError: its space or spec do not fit, or it holds no arm.
    """
    from mobo_core.design import to_urdf
    from mobo_core.evaluation.evaluate import evaluate

    if not len(atlas):
        raise InputError("holds no arm", where="atlas", expected="one with arms")
    space, spec = atlas.space, atlas.spec
    known = (atlas.trials_of_order >= SEARCHED) | (atlas.expected_gain <= KNOWN_GAIN)
    columns = zip(
        atlas.joints, atlas.lengths.tolist(), atlas.values["reach"].tolist(), atlas.values["torque"].tolist(),
        atlas.trials_of_order.tolist(), known.tolist(), strict=True,
    )  # fmt: skip
    arms = [
        Arm(joints, tuple(lengths), reach, torque, row, trials, enough)
        for row, (joints, lengths, reach, torque, trials, enough) in enumerate(columns)
    ]

    def urdf(arm: Arm) -> tuple[str, str] | None:
        try:
            return to_urdf(atlas.design(arm.trial), space), ""
        except MoboError:
            return None

    def maps(arm: Arm) -> Maps | None:
        made = urdf(arm)
        try:
            result = evaluate(made[0], spec) if made is not None else None
        except MoboError:
            return None
        return (result.voxel_reach, result.voxel_torque, result.voxel_torque_sd) if result is not None else None

    return Evidence(arms, space, spec, fair=True, maps=maps, urdf=urdf)
