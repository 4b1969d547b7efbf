"""The messages as typed dataclasses. Units and meanings stand in ``ros_pkgs/mobo_msgs/msg/*.msg``."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from mobo_core.clock import now_ns

# Of this set of messages; bags of older ones are read by the definitions they hold.
SCHEMA_VERSION = 2

# How the reason of a FAILED answer begins if the evaluator's engine or version is not up to the question.
UNABLE = "unable: "

Floats = NDArray[np.float64]
Floats32 = NDArray[np.float32]
Counts16 = NDArray[np.uint16]
Counts32 = NDArray[np.uint32]

_DTYPES = {"Floats": np.float64, "Floats32": np.float32, "Counts16": np.uint16, "Counts32": np.uint32}


def _zeros(n: int = 0) -> Floats:
    return field(default_factory=lambda: np.zeros(n))


def _counts16() -> Counts16:
    return field(default_factory=lambda: np.zeros(0, np.uint16))


def _counts32() -> Counts32:
    return field(default_factory=lambda: np.zeros(0, np.uint32))


def _texts() -> list[str]:
    return field(default_factory=list)


@dataclass(slots=True)
class Time:
    """builtin_interfaces/Time."""

    sec: int = 0
    nanosec: int = 0


@dataclass(slots=True)
class Header:
    """std_msgs/Header, in the frame ``base_link`` unless said otherwise."""

    stamp: Time = field(default_factory=Time)
    frame_id: str = "base_link"

    @classmethod
    def at(cls, time_ns: int) -> Header:
        """Return the header of a time in ns since the epoch."""
        return cls(Time(time_ns // 10**9, time_ns % 10**9))

    @classmethod
    def now(cls) -> Header:
        """Return the header of this moment."""
        return cls.at(now_ns())

    @property
    def time_ns(self) -> int:
        """Its time in ns since the epoch."""
        return self.stamp.sec * 10**9 + self.stamp.nanosec


class Message:
    """What all messages share. Fields left out are zero and empty, but for the header, which is of now.

    Attributes:
        kind: its name in ``mobo_msgs``.
    """

    __slots__ = ()
    kind: ClassVar[str]

    def __post_init__(self) -> None:
        """Make arrays of what was given for them."""
        for name, dtype in _ARRAYS[self.kind]:
            setattr(self, name, np.asarray(getattr(self, name), dtype=dtype))


@dataclass(slots=True, eq=False)
class SpecMessage(Message):
    """What is asked of an arm; see :mod:`mobo_core.evaluation.spec_message`."""

    kind: ClassVar[str] = "EvaluationSpec"
    workspace_min: Floats = _zeros(3)
    workspace_max: Floats = _zeros(3)
    voxel_size: float = 0.0
    poses_per_voxel: int = 0
    ik_mode: str = ""
    rules: int = 1
    restarts: int = 0
    iterations: int = 0
    position_tolerance: float = 0.0
    rotation_tolerance: float = 0.0
    orientation: str = ""
    self_collision: bool = False
    gravity: Floats = _zeros(3)
    payload_kg: float = 0.0
    payload_com: Floats = _zeros(3)
    tool_xyz: Floats = _zeros(3)
    tool_rpy: Floats = _zeros(3)
    floor_z: float = -math.inf
    obstacles: Floats = _zeros()
    target_poses: Floats = _zeros()
    solution: str = ""
    seed: int = 0


@dataclass(slots=True, eq=False)
class Candidate(Message):
    """An arm sent out for evaluation."""

    kind: ClassVar[str] = "Candidate"
    header: Header = field(default_factory=Header.now)
    study: str = ""
    trial: int = 0
    attempt: int = 0
    evaluator: str = ""
    sampled_joints: str = ""
    joints: str = ""
    lengths: Floats = _zeros()
    urdf: str = ""
    tip: str = ""
    spec: SpecMessage = field(default_factory=SpecMessage)
    objectives: list[str] = _texts()
    engine: str = ""
    params_json: str = ""
    schema_version: int = SCHEMA_VERSION


@dataclass(slots=True, eq=False)
class Evaluation(Message):
    """What an evaluator answers to one Candidate. Arrays hold one entry a voxel."""

    kind: ClassVar[str] = "Evaluation"
    OK: ClassVar[int] = 0
    REJECTED: ClassVar[int] = 1
    FAILED: ClassVar[int] = 2
    header: Header = field(default_factory=Header.now)
    study: str = ""
    trial: int = 0
    attempt: int = 0
    evaluator: str = ""
    status: int = 0
    reason: str = ""
    reach: float = 0.0
    torque: float = 0.0
    voxel_reach: Floats = _zeros()
    voxel_torque: Floats = _zeros()
    voxel_torque_sd: Floats32 = field(default_factory=lambda: np.zeros(0, np.float32))
    voxel_out_of_range: Counts16 = _counts16()
    voxel_not_converged: Counts16 = _counts16()
    voxel_in_collision: Counts16 = _counts16()
    attempts: int = 0
    iterations: int = 0
    seconds: float = 0.0
    audit_poses: int = 0
    audit_max_error: float = 0.0
    extra_names: list[str] = _texts()
    extra_values: Floats = _zeros()
    mobo_version: str = ""
    host_id: str = ""


@dataclass(slots=True, eq=False)
class Trial(Message):
    """The record that a trial was told to the sampler."""

    kind: ClassVar[str] = "Trial"
    COMPLETE: ClassVar[int] = 0
    FAIL: ClassVar[int] = 1
    header: Header = field(default_factory=Header.now)
    study: str = ""
    trial: int = 0
    state: int = 0
    attempt: int = 0
    evaluator: str = ""
    reach: float = 0.0
    torque: float = 0.0
    extra_names: list[str] = _texts()
    extra_values: Floats = _zeros()
    reason: str = ""


@dataclass(slots=True, eq=False)
class Command(Message):
    """A command the optimizer accepted."""

    kind: ClassVar[str] = "Command"
    header: Header = field(default_factory=Header.now)
    study: str = ""
    trial: int = 0
    command: str = ""
    arguments_json: str = ""
    source: str = ""


@dataclass(slots=True, eq=False)
class EvaluatorStatus(Message):
    """The heartbeat of an evaluator."""

    kind: ClassVar[str] = "EvaluatorStatus"
    ALIVE: ClassVar[int] = 0
    JOINED: ClassVar[int] = 1
    LEFT: ClassVar[int] = 2
    LOST: ClassVar[int] = 3
    header: Header = field(default_factory=Header.now)
    evaluator: str = ""
    state: int = 0
    workers: int = 0
    threads: int = 0
    engine: str = ""
    kernel_hash: str = ""
    objectives: list[str] = _texts()
    studies: list[str] = _texts()
    trials: Counts32 = _counts32()
    attempts: Counts32 = _counts32()
    answered: int = 0
    mobo_version: str = ""
    host_id: str = ""
    pid: int = 0


@dataclass(slots=True, eq=False)
class StudyStatus(Message):
    """How a study stands."""

    kind: ClassVar[str] = "StudyStatus"
    RUNNING: ClassVar[int] = 0
    PAUSED: ClassVar[int] = 1
    DONE: ClassVar[int] = 2
    STOPPED: ClassVar[int] = 3
    FAILED: ClassVar[int] = 4
    header: Header = field(default_factory=Header.now)
    study: str = ""
    state: int = 0
    reason: str = ""
    n_trials: int = 0
    asked: int = 0
    told: int = 0
    failed: int = 0
    evaluators: int = 0
    workers: int = 0
    front_size: int = 0
    best_reach: float = 0.0
    hypervolume: float = 0.0
    answers: int = 0
    answers_unused: int = 0
    resent: int = 0
    bag: str = ""


@dataclass(slots=True, eq=False)
class OptimizerStatus(Message):
    """Which optimizer runs a namespace, or asks to."""

    kind: ClassVar[str] = "OptimizerStatus"
    header: Header = field(default_factory=Header.now)
    optimizer: str = ""
    study: str = ""
    bag: str = ""
    host_id: str = ""
    pid: int = 0


# Relative names of the topics that a bag holds.
TOPICS: dict[str, type[Message]] = {
    "candidates": Candidate,
    "evaluations": Evaluation,
    "trials": Trial,
    "evaluators": EvaluatorStatus,
    "study": StudyStatus,
    "commands": Command,
}
_OTHERS: tuple[type[Message], ...] = (SpecMessage, OptimizerStatus)
KINDS: dict[str, type[Message]] = {cls.kind: cls for cls in (*TOPICS.values(), *_OTHERS)}
# Of each kind: the array fields, and the type of their numbers.
_ARRAYS = {
    kind: [(part.name, _DTYPES[str(part.type)]) for part in fields(cls) if str(part.type) in _DTYPES]  # type: ignore[arg-type]
    for kind, cls in KINDS.items()
}
