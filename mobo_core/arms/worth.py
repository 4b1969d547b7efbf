"""What real arms are worth: as they are, at the size and with the masses of a design space, and idealised."""

from __future__ import annotations

from dataclasses import dataclass

from mobo_core.arms.real import Order, RealArm
from mobo_core.design import Design, DesignSpace, to_urdf
from mobo_core.design.numbers import middle
from mobo_core.evaluation.evaluate import evaluate
from mobo_core.evaluation.result import Result
from mobo_core.evaluation.spec import EvaluationSpec


@dataclass(frozen=True)
class Worth:
    """Three evaluations of an arm.

    Attributes:
        own: as it is, in a workspace as much larger than the spec's, floor and boxes with it, as it is longer than an
            arm of the space.
        scaled: scaled to the space's total length, strokes with it, with the space's masses, its own offsets and
            limits.
        twin: the idealised twin in the space: its joint order and the ratio of its lengths alone.
    """

    own: Result
    scaled: Result
    twin: Result

    def to_dict(self) -> dict[str, object]:
        """Return reach, torque (N m) and mean torque of a reached voxel (N m, None if there is none) of each."""
        return {
            name: {"reach": result.reach, "torque": result.torque, "mean_torque": result.to_dict()["mean_torque"]}
            for name, result in vars(self).items()
        }


def worth(arm: RealArm, spec: EvaluationSpec, space: DesignSpace | None = None, order: Order | None = None) -> Worth:
    """Evaluate an arm three times, its first joint at the origin each time.

    Args:
        arm: a real arm.
        spec: what is asked of an arm of the space.
        space: of the scaled arm and the twin, with as many joints as the arm.
        order: of the arm; its own if None.
    """
    using = space or DesignSpace(n_joints=arm.n)
    total = middle(using.total_length)
    order = order or arm.order
    assert order is not None
    return Worth(
        evaluate(arm.urdf(), larger(spec, arm.length / total)),
        evaluate(arm.urdf(total, using), spec),
        evaluate(to_urdf(Design(order.joints, order.twin(total)), using), spec),
    )


def larger(spec: EvaluationSpec, times: float) -> EvaluationSpec:
    """Return the same question in a workspace so many times as large, with as many voxels.

    Floor and boxes are part of the workspace and grow with it; tool and payload stay as they are. Given poses are
    places in m: where they are asked all stays.
    """
    if spec.target_poses:
        return spec
    around: dict[str, object] = {
        "floor_z": None if spec.floor_z is None else times * spec.floor_z,
        "obstacles": [
            {"centre": [times * v for v in box.centre], "rpy": box.rpy, "size": [times * v for v in box.size]}
            for box in spec.obstacles
        ],
    }
    box = {name: tuple(times * v for v in getattr(spec, name)) for name in ("workspace_min", "workspace_max")}
    return EvaluationSpec.of({**spec.to_dict(), **box, **around, "voxel_size": times * spec.voxel_size})
