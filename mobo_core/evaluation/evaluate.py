"""What an arm is worth: reach and torque over the voxels of a spec."""

from __future__ import annotations

import functools
import math
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any, Literal

import numpy as np

from mobo_core.errors import InputError
from mobo_core.evaluation.audit import audit
from mobo_core.evaluation.chain import Array, Chain, chain_from_urdf
from mobo_core.evaluation.compiled import kernel
from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.evaluation.starts import GRID, no_table, sort_table, unit_samples

Engine = Literal["kernel", "reference"]

# Poses whose postures are held in memory at a time.
_CHUNK_POSES = 1 << 16
# Postures sampled for the starts of ik_mode complete.
TABLE_SAMPLES = 20_000
# No orientations given: the kernel draws them.
_DRAWN = np.zeros((0, 0, 3, 3))


@dataclass(frozen=True)
class Postures:
    """Accepted postures.

    Attributes:
        voxel, pose: (m,) which target each belongs to.
        q: (m, n) rad.
        torque: (m,) N m, norm of the gravity torque.
    """

    voxel: Array
    pose: Array
    q: Array
    torque: Array


@dataclass
class Result:
    """What an arm is worth. Arrays have one entry a voxel.

    Attributes:
        reach: sum of voxel_reach, at most the number of voxels.
        torque: N m, sum of voxel_torque.
        voxel_reach: share of the poses reached, 0 to 1.
        voxel_torque: N m, mean norm of the gravity torque over the poses reached; 0 where there is none.
        voxel_torque_sd: N m, standard deviation of the same.
        out_of_range, not_converged, in_collision: poses that failed, by reason.
        attempts, iterations: IK effort in all.
        seconds: wall time of the evaluation alone.
        joints, tip: names of the joints on the path, and of the tip link.
        audit_poses, audit_max_error: accepted poses checked again with Pinocchio and Coal, and the largest
            error found among them (m, rad or N m).
        audit_fault: what failed, if a check did.
        ignored_shapes: collision shapes that were neither cylinder nor sphere.
        postures: the accepted postures, if asked for.
    """

    reach: float
    torque: float
    voxel_reach: Array
    voxel_torque: Array
    voxel_torque_sd: Array
    out_of_range: Array
    not_converged: Array
    in_collision: Array
    attempts: int
    iterations: int
    seconds: float
    joints: tuple[str, ...]
    tip: str
    audit_poses: int = 0
    audit_max_error: float = 0.0
    audit_fault: str = ""
    ignored_shapes: int = 0
    postures: Postures | None = field(default=None, repr=False)


def evaluate(
    urdf: str | bytes,
    spec: EvaluationSpec,
    *,
    tip: str = "",
    engine: Engine = "kernel",
    threads: int = 1,
    audit_poses: int = 0,
    audit_number: int = 0,
    postures: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> Result:
    """Evaluate the arm that ``urdf`` describes.

    The result depends on ``urdf``, ``spec`` and ``tip`` alone, to the bit, whatever ``threads`` is.

    Args:
        urdf: the robot's description.
        spec: what is asked.
        tip: link that has to reach; by default the only leaf.
        engine: ``kernel``, or ``reference`` (Pinocchio and Coal, one pose at a time, one thread).
        threads: threads of the kernel.
        audit_poses: number of accepted poses to check again.
        audit_number: chooses them; the trial's number, so that trials differ.
        postures: whether to return the accepted postures.
        progress: called with (voxels done, voxels in all).

    Raises:
        InputError: the URDF or the tip is not fit (see :func:`mobo_core.evaluation.chain.chain_from_urdf`).
    """
    chain = chain_from_urdf(urdf, tip, payload_kg=spec.payload_kg, gravity=spec.gravity)
    if engine == "kernel":
        compute, seconds = _kernel_call(chain, spec, threads, spec.voxel_centres(), _DRAWN)
    else:
        compute, seconds = _reference_call(chain, spec), 0.0
    n_voxels, poses = spec.n_voxels, spec.poses_per_voxel
    counts = np.zeros((n_voxels, 4), np.int64)
    mean, deviation = np.zeros(n_voxels), np.zeros(n_voxels)
    kept: list[Postures] = []
    checked, worst, fault = 0, 0.0, ""
    effort = np.zeros(2, np.int64)
    for first, last in _chunks(n_voxels, poses):
        began = time.perf_counter()
        out = _Outputs(last - first, poses, chain.n)
        compute(first, last, out)
        seconds += time.perf_counter() - began
        effort += out.effort.sum(axis=0)
        for voxel in range(first, last):
            outcome = out.outcome[voxel - first]
            counts[voxel] = [np.count_nonzero(outcome == reason) for reason in range(4)]
            mean[voxel], deviation[voxel] = _mean_and_deviation(out.torque[voxel - first][outcome == 0])
        if postures or audit_poses:
            found = out.postures(first)
            if postures:
                kept.append(found)
            if audit_poses:
                share = max(1, round(audit_poses * (last - first) / n_voxels))
                poses_checked, error, message = audit(chain, spec, found, share, audit_number)
                checked, worst, fault = checked + poses_checked, max(worst, error), fault or message
        if progress:
            progress(last, n_voxels)
    voxel_reach = counts[:, 0] / poses
    return Result(
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
        tip=chain.tip,
        audit_poses=checked,
        audit_max_error=worst,
        audit_fault=fault,
        ignored_shapes=chain.ignored_shapes,
        postures=_joined(kept, chain.n) if postures else None,
    )


class _Outputs:
    """What the kernel writes for a range of voxels."""

    def __init__(self, voxels: int, poses: int, n: int) -> None:
        self.outcome = np.zeros((voxels, poses), np.uint8)
        self.torque = np.zeros((voxels, poses))
        self.q = np.zeros((voxels, poses, n))
        self.effort = np.zeros((voxels, 2), np.int64)

    def part(self, first: int, last: int) -> tuple[Array, Array, Array, Array]:
        return self.outcome[first:last], self.torque[first:last], self.q[first:last], self.effort[first:last]

    def postures(self, first_voxel: int) -> Postures:
        voxel, pose = np.nonzero(self.outcome == 0)
        return Postures(voxel + first_voxel, pose, self.q[voxel, pose], self.torque[voxel, pose])


def _joined(parts: list[Postures], n: int) -> Postures:
    if not parts:
        return Postures(np.empty(0, int), np.empty(0, int), np.empty((0, n)), np.empty(0))
    return Postures(*(np.concatenate([getattr(p, name) for p in parts]) for name in ("voxel", "pose", "q", "torque")))


def _chunks(n_voxels: int, poses: int) -> Iterator[tuple[int, int]]:
    step = max(1, _CHUNK_POSES // poses)
    for first in range(0, n_voxels, step):
        yield first, min(first + step, n_voxels)


def _mean_and_deviation(values: Array) -> tuple[float, float]:
    # fsum rounds once, whatever the order: NumPy's own sums differ between processors.
    if not len(values):
        return 0.0, 0.0
    mean = math.fsum(values) / len(values)
    return mean, math.sqrt(math.fsum((float(v) - mean) * (float(v) - mean) for v in values) / len(values))


def half_angle_sine(angle: float) -> float:
    """Return twice the sine of half of ``angle`` (rad), the measure in which orientation errors are compared."""
    from mobo_core.evaluation.numerics import sin_cos

    return 2.0 * float(sin_cos(0.5 * angle)[0])


def _question(spec: EvaluationSpec) -> tuple[Any, ...]:
    return (
        spec.seed, spec.poses_per_voxel, spec.restarts + 1, spec.iterations,
        spec.position_tolerance, half_angle_sine(spec.rotation_tolerance),
        spec.self_collision, spec.solution == "least_torque",
    )  # fmt: skip


@functools.lru_cache(4)
def _unit_samples(seed: int, n: int) -> Array:
    """Return the sampled postures that all arms of ``n`` joints share, as shares of their joint ranges."""
    samples = np.empty((TABLE_SAMPLES, n))
    unit_samples(seed, samples)
    return samples


def _table(compiled: ModuleType, chain: Chain, constants: Array, seed: int) -> tuple[Array, ...]:
    """Return the arm's table of starts: (q, order, cell_first, poses) as the kernel takes it."""
    q = chain.lower + _unit_samples(seed, chain.n) * (chain.upper - chain.lower)
    m = len(q)
    tips, poses, order = np.empty((12, m)), np.empty((12, m)), np.empty(m, np.int64)
    cell_first = np.empty(GRID**3 + 1, np.int64)
    compiled.table_tips(constants, q, tips)
    sort_table(tips, chain.placement_p[0], chain.reach_radius, np.empty(m, np.int64), order, cell_first, poses)
    return q, order, cell_first, poses


def _kernel_call(
    chain: Chain, spec: EvaluationSpec, threads: int, centres: Array, rotations: Array
) -> tuple[Callable[[int, int, _Outputs], None], float]:
    """Return the function that evaluates a range of voxels, and the seconds its preparation took."""
    compiled = kernel(chain.n)
    began = time.perf_counter()
    constants = np.empty((chain.n + 1, 12))
    constants[:-1, :9], constants[:-1, 9:] = chain.placement_r.reshape(-1, 9), chain.placement_p
    constants[-1, :9], constants[-1, 9:] = chain.tip_r.ravel(), chain.tip_p
    complete = spec.ik_mode == "complete"
    arrays = (
        chain.placement_r, chain.placement_p, chain.tip_r, chain.tip_p, constants, chain.lower, chain.upper,
        chain.mass, chain.com, chain.reach_radius, chain.capsule_joint, chain.capsule_a, chain.capsule_b,
        chain.capsule_radius, chain.pairs,
        *(_table(compiled, chain, constants, spec.seed) if complete else no_table(chain.n)),
        centres, rotations,
    )  # fmt: skip
    question = (*_question(spec), np.array(spec.gravity))

    def compute(first: int, last: int, out: _Outputs) -> None:
        def part(bounds: tuple[int, int]) -> None:
            low, high = bounds
            compiled.evaluate_voxels(*arrays, low, high, *question, *out.part(low - first, high - first))

        if threads == 1:
            return part((first, last))
        # Voxels differ much in cost: many small parts keep all threads busy to the end.
        size = max(1, (last - first) // (8 * threads))
        parts = [(low, min(low + size, last)) for low in range(first, last, size)]
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(part, parts))

    return compute, time.perf_counter() - began


def _reference_call(chain: Chain, spec: EvaluationSpec) -> Callable[[int, int, _Outputs], None]:
    from mobo_core.evaluation.reference import evaluate_voxels_reference

    if spec.ik_mode != "paper":
        raise InputError(f"ik_mode {spec.ik_mode!r}", where="reference engine", expected="'paper'")
    centres, question = spec.voxel_centres(), _question(spec)

    def compute(first: int, last: int, out: _Outputs) -> None:
        arguments = (*question, *out.part(0, last - first))
        evaluate_voxels_reference(chain, centres, first, last, *arguments)

    return compute
