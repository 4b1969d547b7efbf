"""What arms can hardly do, said before a study finds out."""

from __future__ import annotations

import numpy as np

from mobo_core.design import DesignSpace
from mobo_core.design.joints import built_types, effective_joints, yaw_rule
from mobo_core.design.numbers import middle
from mobo_core.evaluation.result import Result
from mobo_core.evaluation.spec import EvaluationSpec

# Joints that it takes to meet a pose of each kind.
_FREEDOMS = {"full": 6, "free_roll": 5, "none": 3}


def joints_advice(n_joints: int, spec: EvaluationSpec) -> list[str]:
    """Return a remark if arms of so many joints can hardly meet what the spec asks."""
    needed = _FREEDOMS[spec.orientation]
    if n_joints >= needed:
        return []
    what = "orientation and position" if needed > 3 else "a position"
    joints = f"{n_joints} joint{'s' * (n_joints != 1)}"
    return [f"{joints} can hardly meet {what}, which take {needed}: reach will be near 0"]


def result_advice(result: Result) -> list[str]:
    """Return remarks on an arm that can hardly meet what was asked of it."""
    spec = result.spec
    remarks = joints_advice(len(result.joints), spec)
    far = int((result.out_of_range == spec.poses_per_voxel).sum())
    if 2 * far > spec.n_voxels:
        remarks.append(f"{far} of {spec.n_voxels} {_places(spec)} lie farther from the base than the arm reaches")
    return remarks


def space_advice(space: DesignSpace, spec: EvaluationSpec) -> str:
    """Return a line on what arms of a space can hardly do, or are built as; ``""`` if there is nothing to say."""
    remarks = joints_advice(space.n_joints, spec)
    longest = space.longest_reach + spec.tool_length
    base = np.array([0.0, 0.0, middle(space.base_height)])
    centres = spec.voxel_centres()
    far = int((np.linalg.norm(centres - base, axis=1) > longest + spec.position_tolerance).sum())
    if 2 * far > len(centres):
        what = f"{far} of {len(centres)} {_places(spec)}"
        remarks.append(f"{what} lie farther from the base than the arm's {longest:g} m")
    if space.n_joints > 1 and not space.joints and space.n_orders == 1:
        built = effective_joints(space.joint_types * space.n_joints)
        remarks.append(f"joint_types {space.joint_types} builds {built} alone")
    elif space.n_joints > 1 and (others := _others(space)):
        remarks.append(f"joints {others} are built too, though {space.letters} are drawn: {yaw_rule(space.letters)}")
    return "; ".join(remarks)


def _places(spec: EvaluationSpec) -> str:
    return "given poses" if spec.target_poses else "voxel centres"


def _others(space: DesignSpace) -> str:
    return "".join(joint.letter for joint in built_types(space.letters) if joint.letter not in space.letters)
