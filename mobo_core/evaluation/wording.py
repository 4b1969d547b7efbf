"""What a spec asks beyond reaching poses in voxels, in words. Light to import."""

from __future__ import annotations

import math
from collections.abc import Sequence

from mobo_core.evaluation.spec import EvaluationSpec

_FREE = {"free_roll": "roll about the tool's z axis free", "none": "position alone, in any orientation"}


def poses_text(spec: EvaluationSpec) -> str:
    """Return what is to be reached, such as ``75 voxels of 0.2 m, 30 poses each``."""
    if spec.target_poses:
        return f"{spec.n_voxels} given poses"
    return f"{spec.n_voxels} voxels of {spec.voxel_size:g} m, {spec.poses_per_voxel} poses each"


def further_asked(spec: EvaluationSpec) -> list[str]:
    """Return a phrase for each thing a spec asks for beyond the paper's question."""
    phrases = [_FREE[spec.orientation]] if spec.orientation in _FREE else []
    if spec.payload_kg:
        at = f" with its centre at {_numbers(spec.payload_com)} m in the tool's frame" if any(spec.payload_com) else ""
        phrases.append(f"payload {spec.payload_kg:g} kg{at}")
    if any((*spec.tool_xyz, *spec.tool_rpy)):
        turned = f", turned by {_numbers(map(math.degrees, spec.tool_rpy))}°" if any(spec.tool_rpy) else ""
        phrases.append(f"tool at {_numbers(spec.tool_xyz)} m from the tip{turned}")
    if spec.floor_z is not None:
        phrases.append(f"floor at {spec.floor_z:g} m")
    if spec.obstacles:
        phrases.append(f"{len(spec.obstacles)} box{'es' * (len(spec.obstacles) > 1)} in the way")
    return phrases


def _numbers(values: Sequence[float] | map[float]) -> str:
    return " ".join(f"{value:.4g}" for value in values)
