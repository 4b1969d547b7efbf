"""What an arm is worth: reach and torque over the voxels of a spec."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from mobo_core.design import Design, DesignSpace, to_urdf
from mobo_core.errors import UnableError
from mobo_core.evaluation.audit import Audit
from mobo_core.evaluation.batch import Batch
from mobo_core.evaluation.chain import Array, Chain, asked_chain
from mobo_core.evaluation.engines import kernel_call, reference_call
from mobo_core.evaluation.joint_torque import JointTorques
from mobo_core.evaluation.kernel.arguments import Outputs
from mobo_core.evaluation.objectives import OBJECTIVES, Accumulator
from mobo_core.evaluation.result import Configurations, Engine, Result
from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.evaluation.targets import given_rotations

# Poses whose configurations are held in memory at a time.
_CHUNK_POSES = 1 << 16
_NOT_TRIED = 255  # an outcome that is counted as none
_PAPER = EvaluationSpec()


def evaluate(
    arm: Design | str | bytes,
    spec: EvaluationSpec = _PAPER,
    *,
    space: DesignSpace | None = None,
    tip: str = "",
    engine: Engine = "kernel",
    threads: int = 1,
    objectives: Sequence[str] = (),
    audit_poses: int = 0,
    audit_number: int = 0,
    joint_torques: bool = False,
    configurations: bool = False,
    voxels: NDArray[np.bool_] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Result:
    """Evaluate an arm.

    The result depends on ``arm``, ``space``, ``spec`` and ``tip`` alone, to the bit, whatever ``threads`` is.

    Args:
        arm: a design, or a robot's description as URDF.
        spec: what is asked; by default the paper's question.
        space: masses, radius and limits of a design; those of the default space if None.
        tip: link that has to reach; by default the only leaf.
        engine: ``kernel``, or ``reference`` (Pinocchio and Coal, one pose at a time, one thread).
        threads: threads of the kernel.
        objectives: names of the objectives wanted in ``Result.extra``; reach and torque are always there.
        audit_poses: number of accepted poses to check again.
        audit_number: chooses them; the trial's number, so that trials differ.
        joint_torques: whether to return what each joint has to hold.
        configurations: whether to return the accepted configurations.
        voxels: (n_voxels,) which to try, each as it would be among all; nothing of the others is counted. None: all.
        progress: called with (voxels done, voxels in all).

    Raises:
        InputError: the URDF or the tip is not fit (see :func:`mobo_core.evaluation.chain.chain_from_urdf`), or
            an objective is unknown.
        UnableError: the engine cannot answer, or an objective's value is not a finite number.
    """
    urdf = to_urdf(arm, space or DesignSpace()) if isinstance(arm, Design) else arm
    chain = asked_chain(urdf, tip, spec)
    values = _begun(objectives, chain, spec)
    centres = spec.voxel_centres()
    if engine == "kernel":
        compute, seconds = kernel_call(chain, spec, threads, centres, given_rotations(spec))
    else:
        compute, seconds = reference_call(chain, spec, centres), 0.0
    n_voxels, poses = spec.n_voxels, spec.poses_per_voxel
    counts = np.zeros((n_voxels, 4), np.int64)
    mean, deviation = np.zeros(n_voxels), np.zeros(n_voxels)
    kept: list[Configurations] = []
    held = JointTorques(chain.joint_names) if joint_torques else None
    audit = Audit(chain, spec, audit_poses, audit_number)
    gravity = np.array(spec.gravity)
    effort = np.zeros(2, np.int64)
    for first, last in _chunks(n_voxels, poses):
        began = time.perf_counter()
        out = Outputs.empty(last - first, poses, chain.n)
        if voxels is None:
            compute(first, last, out)
        else:
            out.outcome.fill(_NOT_TRIED)
            for low, high in _runs(voxels[first:last]):
                compute(first + low, first + high, out.part(low, high))
        seconds += time.perf_counter() - began
        effort += out.effort.sum(axis=0)
        for reason in range(4):
            counts[first:last, reason] = np.count_nonzero(out.outcome == reason, axis=1)
        for voxel in np.flatnonzero(counts[first:last, 0]):
            torques = out.torque[voxel][out.outcome[voxel] == 0]
            mean[first + voxel], deviation[first + voxel] = _mean_and_deviation(torques.tolist())
        if configurations or audit_poses or values or held:
            found = _accepted(out, first)
            if configurations:
                kept.append(found)
            audit.add(found)
            batch = Batch(chain, gravity, found.voxel, found.pose, found.q, found.torque)
            for value in values.values():
                value.add(batch)
            if held:
                held.add(batch)
        if progress:
            progress(last, n_voxels)
    voxel_reach = counts[:, 0] / poses
    checked, worst, fault = audit.result(centres)
    return Result(
        spec=spec,
        reach=math.fsum(voxel_reach),
        torque=math.fsum(mean),
        voxel_reach=voxel_reach,
        voxel_torque=mean,
        voxel_torque_sd=deviation,
        out_of_range=counts[:, 1],
        not_converged=counts[:, 2],
        in_collision=counts[:, 3],
        attempts=int(effort[0]),
        iterations=int(effort[1]),
        seconds=seconds,
        joints=chain.joint_names,
        slides={name: radius for name, radius in zip(chain.joint_names, chain.slide.tolist(), strict=True) if radius},
        tip=chain.tip,
        audit_poses=checked,
        audit_max_error=worst,
        audit_fault=fault,
        ignored_shapes=chain.ignored_shapes,
        extra={name: _finite(name, value) for name, value in values.items()},
        joint_torques=held.value() if held else None,
        configurations=_joined(kept, chain.n) if configurations else None,
    )


def _begun(objectives: Sequence[str], chain: Chain, spec: EvaluationSpec) -> dict[str, Accumulator]:
    asked = {name: OBJECTIVES.of(name).begin for name in objectives}
    return {name: begin(chain, spec) for name, begin in asked.items() if begin is not None}


def _finite(name: str, accumulator: Accumulator) -> float:
    value = float(accumulator.value())
    if not math.isfinite(value):
        raise UnableError(f"{value}", where=f"objective {name!r}", expected="a finite number")
    return value


def _accepted(out: Outputs, first_voxel: int) -> Configurations:
    voxel, pose = np.nonzero(out.outcome == 0)
    return Configurations(voxel + first_voxel, pose, out.q[voxel, pose], out.torque[voxel, pose])


def _joined(parts: list[Configurations], n: int) -> Configurations:
    if not parts:
        return Configurations(np.empty(0, int), np.empty(0, int), np.empty((0, n)), np.empty(0))
    names = ("voxel", "pose", "q", "torque")
    return Configurations(*(np.concatenate([getattr(p, name) for p in parts]) for name in names))


def _chunks(n_voxels: int, poses: int) -> Iterator[tuple[int, int]]:
    step = max(1, _CHUNK_POSES // poses)
    for first in range(0, n_voxels, step):
        yield first, min(first + step, n_voxels)


def _runs(wanted: NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """Yield where the runs of True begin and end."""
    ends = np.flatnonzero(np.diff(np.concatenate(([False], wanted, [False])).astype(np.int8)))
    yield from zip(ends[::2].tolist(), ends[1::2].tolist(), strict=True)


def _mean_and_deviation(values: list[float]) -> tuple[float, float]:
    # fsum rounds once, whatever the order: NumPy's own sums differ between processors.
    mean = math.fsum(values) / len(values)
    return mean, math.sqrt(math.fsum((v - mean) * (v - mean) for v in values) / len(values))


def solve_poses(
    urdf: str | bytes,
    spec: EvaluationSpec,
    positions: Array,
    rotations: Array,
    *,
    tip: str = "",
    threads: int = 1,
) -> tuple[NDArray[np.uint8], Array, Array]:
    """Solve given poses by the kernel, with the means and limits of ``spec`` but not its workspace.

    Args:
        urdf: the robot's description.
        spec: how to solve, and what counts as reached.
        positions: (m, 3) m, base frame.
        rotations: (m, 3, 3), tip to base.
        tip: link that has to reach; by default the only leaf.
        threads: threads of the kernel.

    Returns:
        Outcome (m,), 0 where reached (see :mod:`mobo_core.evaluation.kernel.configuration`); joint angles (m, n) in
        rad; and norms of the gravity torque (m,) in N m; the last two of poses reached only.

    Raises:
        InputError: the URDF or the tip is not fit.
    """
    chain = asked_chain(urdf, tip, spec)
    one = spec.model_copy(update={"poses_per_voxel": 1, "target_poses": ()})
    m = len(positions)
    given = np.ascontiguousarray(rotations, dtype=float).reshape(m, 1, 3, 3)
    compute, _ = kernel_call(chain, one, threads, np.ascontiguousarray(positions, dtype=float), given)
    out = Outputs.empty(m, 1, chain.n)
    compute(0, m, out)
    return out.outcome[:, 0], out.q[:, 0], out.torque[:, 0]
