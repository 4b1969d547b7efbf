"""What is asked of an arm."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from mobo_core.errors import InputError
from mobo_core.evaluation.pose_file import MAX_TARGETS, Pose, read_poses
from mobo_core.settings import Settings

MAX_VOXELS = 1_000_000
MAX_POSES = 50_000_000
MOST_RULES = 3
MAX_BOXES = 64

Vector = tuple[float, float, float]
NOWHERE: Vector = (0.0, 0.0, 0.0)
_MOST = 1e3  # m or rad


class Box(Settings):
    """A box that an arm must not touch."""

    centre: Vector = Field(description="m, base frame")
    rpy: Vector = Field(NOWHERE, description="rad, roll, pitch, yaw about fixed axes")
    size: Vector = Field(description="m, of its sides")

    @model_validator(mode="after")
    def _measures(self) -> Box:
        if max(map(abs, (*self.centre, *self.rpy, *self.size))) > _MOST or min(self.size) <= 0:
            raise ValueError(f"numbers of {_MOST:g} at most, either way, and sides above 0")
        return self


class EvaluationSpec(Settings):
    """The workspace, the poses in it, and what counts as reached. The defaults are the paper's experiment.

    The workspace is cut into cubic voxels; at the centre of each, ``poses_per_voxel`` orientations are
    drawn uniformly on SO(3) from (seed, voxel, pose) alone, so that every arm meets the same poses. Or the poses are
    given (``target_poses``): then each stands for a voxel.
    """

    later: ClassVar[tuple[str, ...]] = ("payload_com", "tool_xyz", "tool_rpy", "floor_z", "obstacles", "target_poses")

    workspace_min: Vector = Field((-0.5, -0.5, -0.1), description="m, base frame, corner of the workspace")
    workspace_max: Vector = Field((0.5, 0.5, 0.5), description="m, base frame, the corner opposite")
    voxel_size: float = Field(0.2, gt=0, description="m, of which each side is a multiple")
    poses_per_voxel: int = Field(30, ge=1, le=65535, description="orientations at each voxel's centre")
    ik_mode: Literal["paper", "complete", "irteus"] = Field(
        "paper",
        description="inverse kinematics: from random starts (paper), from better ones (complete), or as EusLisp's "
        "irteus has it (engine reference alone)",
    )
    rules: int = Field(
        1, ge=1, le=MOST_RULES, description="of ik_mode complete: how starts are chosen and attempts given up"
    )
    restarts: int = Field(5, ge=0, le=1000, description="attempts after the first")
    iterations: int = Field(50, ge=1, le=10000, description="most steps in one attempt")
    position_tolerance: float = Field(1e-3, gt=0, le=1, description="m, of the tool from the pose")
    rotation_tolerance: float = Field(math.radians(1), gt=0, le=math.pi, description="rad, likewise")
    orientation: Literal["full", "free_roll", "none"] = Field(
        "full", description="what of a pose's orientation counts: all, all but roll about the tool's z axis, nothing"
    )
    self_collision: bool = Field(True, description="whether links must not touch each other")
    gravity: Vector = Field((0.0, 0.0, -9.81), description="m/s^2, base frame")
    payload_kg: float = Field(0.0, ge=0, le=1e4, description="kg, a point at the tool")
    payload_com: Vector = Field(NOWHERE, description="m, where the payload's centre of mass is, in the tool's frame")
    tool_xyz: Vector = Field(NOWHERE, description="m, the tool's point in the frame of the tip: what has to reach")
    tool_rpy: Vector = Field(NOWHERE, description="rad, roll, pitch, yaw about the tip's fixed axes: the tool's frame")
    floor_z: float | None = Field(
        None, ge=-_MOST, le=_MOST, description="m, height of a floor in the base frame that the arm must stay above"
    )
    obstacles: tuple[Box, ...] = Field(
        (), max_length=MAX_BOXES, description="boxes that the arm must not touch: centre, rpy and size, base frame"
    )
    target_poses: tuple[Pose, ...] = Field(
        (), max_length=MAX_TARGETS, description="poses of the tool, x y z (m) roll pitch yaw (rad), in place of voxels"
    )
    solution: Literal["first", "least_torque"] = Field(
        "first", description="which solution of a pose counts: the first found, or that of least torque"
    )
    seed: int = Field(0, ge=0, lt=2**63, description="of the poses and of the starts")

    @model_validator(mode="before")
    @classmethod
    def _one_pose_each(cls, values: Any) -> Any:
        if isinstance(values, dict) and values.get("target_poses"):
            return {"poses_per_voxel": 1, **values}
        return values

    @model_validator(mode="after")
    def _workspace(self) -> EvaluationSpec:
        shape = self._exact_shape()
        if min(shape) < 1:
            raise ValueError(f"at least one voxel of {self.voxel_size:g} m along each axis, not {shape}")
        if math.prod(shape) > MAX_VOXELS:
            raise ValueError(f"at most {MAX_VOXELS} voxels, not {math.prod(shape)}")
        if math.prod(shape) * self.poses_per_voxel > MAX_POSES:
            raise ValueError(f"at most {MAX_POSES} poses, not {math.prod(shape) * self.poses_per_voxel}")
        for low, high, n in zip(self.workspace_min, self.workspace_max, shape, strict=True):
            if abs(n * self.voxel_size - (high - low)) > 1e-6 * self.voxel_size or max(abs(low), abs(high)) > 1e3:
                raise ValueError(f"sides that are whole numbers of voxels of {self.voxel_size:g} m, within 1 km")
        return self

    @model_validator(mode="after")
    def _measures(self) -> EvaluationSpec:
        for name in ("payload_com", "tool_xyz", "tool_rpy"):
            if max(map(abs, getattr(self, name))) > _MOST:
                raise ValueError(f"{name} of {_MOST:g} at most, either way")
        if any(max(map(abs, pose)) > _MOST for pose in self.target_poses):
            raise ValueError(f"target_poses of {_MOST:g} at most, either way")
        if self.target_poses and self.poses_per_voxel != 1:
            raise ValueError(f"poses_per_voxel of 1 where poses are given, not {self.poses_per_voxel}")
        return self

    @classmethod
    def _from_file(cls, values: object, path: Path) -> object:
        if not isinstance(values, dict) or not isinstance(values.get("poses"), str):
            return values
        poses = read_poses(path.parent / values["poses"])
        return {**{name: value for name, value in values.items() if name != "poses"}, "target_poses": poses}

    def _sizes(self) -> list[float]:
        return [b - a for a, b in zip(self.workspace_min, self.workspace_max, strict=True)]

    def _exact_shape(self) -> tuple[int, int, int]:
        nx, ny, nz = (
            int(min(max(size / self.voxel_size + 0.5, 0.0), 1e9)) for size in self._sizes()
        )
        return nx, ny, nz

    @property
    def shape(self) -> tuple[int, int, int]:
        """Number of voxels along x, y and z; given poses are in a row."""
        return (len(self.target_poses), 1, 1) if self.target_poses else self._exact_shape()

    @property
    def n_voxels(self) -> int:
        """Number of voxels in all, or of given poses; the largest reach an arm can score."""
        return math.prod(self.shape)

    @property
    def tool_length(self) -> float:
        """Distance of the tool's point from the tip, m."""
        return math.sqrt(math.fsum(v * v for v in self.tool_xyz))

    def voxel_centres(self) -> NDArray[np.float64]:
        """Return the voxel centres in metres, base frame, shape (n_voxels, 3), index (ix*ny + iy)*nz + iz.

        Where poses are given, their positions.
        """
        if self.target_poses:
            return np.array([pose[:3] for pose in self.target_poses])
        axes = [
            np.array([low + (i + 0.5) * self.voxel_size for i in range(n)])
            for low, n in zip(self.workspace_min, self.shape, strict=True)
        ]
        return np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")], axis=1)


PRESETS: dict[str, dict[str, object]] = {
    "paper": {},
    "paper_fine": {"voxel_size": 0.1},
    "mobo": {"ik_mode": "complete", "rules": 3, "restarts": 303, "iterations": 12},
}
IRTEUS: dict[str, object] = {"rules": 1, "restarts": 5, "iterations": 49}  # as its authors have it
# What studies and commands ask where no spec is named. The fields' own defaults stay as older bags mean them.
DEFAULT_PRESET = "mobo"


def lacks(engine: str, ik_mode: str) -> str:
    """Say which ik_mode an engine lacks; "" if it has it. Engines other than these two do no inverse kinematics."""
    missing = {"kernel": "irteus", "reference": "complete"}.get(engine)
    return f"ik_mode {ik_mode!r}" if ik_mode == missing else ""


def with_ik(spec: EvaluationSpec, ik_mode: str) -> EvaluationSpec:
    """Return ``spec`` with another ik_mode, and the rules, restarts and iterations that go with it.

    Raises:
        InputError: no such mode.
    """
    effort: dict[str, object] = {"ik_mode": ik_mode, **(IRTEUS if ik_mode == "irteus" else {})}
    for preset in (EvaluationSpec.of(values) for values in PRESETS.values()):
        if preset.ik_mode == ik_mode:
            effort |= {"rules": preset.rules, "restarts": preset.restarts, "iterations": preset.iterations}
            break
    return EvaluationSpec.of({**spec.to_dict(), **effort})


def with_poses(spec: EvaluationSpec, poses: tuple[Pose, ...]) -> EvaluationSpec:
    """Return ``spec`` with given poses in place of voxels.

    Raises:
        InputError: they do not fit.
    """
    return EvaluationSpec.of({**spec.to_dict(), "poses_per_voxel": 1, "target_poses": poses})


def load_spec(name_or_path: str) -> EvaluationSpec:
    """Return a preset by its name, or read a YAML file, in which ``poses`` may name a file of target_poses.

    Raises:
        InputError: neither a preset nor a readable file, or a field that does not fit.
    """
    if name_or_path in PRESETS:
        return EvaluationSpec.of(PRESETS[name_or_path])
    if not Path(name_or_path).is_file():
        raise InputError(
            f"no preset or file {name_or_path!r}", where="spec", expected=f"{', '.join(PRESETS)} or a YAML file"
        )
    return EvaluationSpec.from_yaml(name_or_path)
