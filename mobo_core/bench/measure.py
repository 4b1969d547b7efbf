"""One arm under one spec: time, poses reached and torques; the same by an exhaustive search and by blind restarts."""

from __future__ import annotations

import hashlib
import math
import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mobo_core.evaluation.chain import Array, Chain, asked_chain
from mobo_core.evaluation.engines import kernel_call, reference_call
from mobo_core.evaluation.kernel import CACHE
from mobo_core.evaluation.kernel.arguments import Outputs
from mobo_core.evaluation.result import Engine
from mobo_core.evaluation.spec import EvaluationSpec, with_ik
from mobo_core.evaluation.targets import given_rotations
from mobo_core.jit.cache import cache_base
from mobo_core.jit.numerics import target_rotation
from mobo_core.outputs import replace_whole
from mobo_core.version import __version__

Mask = NDArray[np.bool_]

EXHAUSTIVE_ITERATIONS = 100
BLIND_SEEDS = 8


@dataclass(frozen=True)
class Measured:
    """One evaluation.

    Attributes:
        reached: (voxels, poses).
        torque: (voxels, poses) N m, of the poses reached.
        attempts, iterations: IK effort in all.
        seconds: CPU time of this thread, which does all the work, without reading the URDF.
    """

    reached: Mask
    torque: Array
    attempts: int
    iterations: int
    seconds: float


def chain_of(urdf: str, spec: EvaluationSpec) -> Chain:
    """Return the chain that a spec's evaluations of a URDF are about."""
    return asked_chain(urdf, "", spec)


def measure(chain: Chain, spec: EvaluationSpec, engine: Engine = "kernel", rotations: Array | None = None) -> Measured:
    """Evaluate a chain; ``rotations`` (voxels, poses, 3, 3) takes the place of those that the spec's seed draws."""
    centres = spec.voxel_centres()
    out = Outputs.empty(spec.n_voxels, spec.poses_per_voxel, chain.n)
    if engine == "kernel":
        began = time.thread_time()
        given = given_rotations(spec) if rotations is None else rotations
        compute, _ = kernel_call(chain, spec, 1, centres, given)
    else:
        compute, middle = reference_call(chain, spec, centres), spec.n_voxels // 2
        compute(middle, middle + 1, Outputs.empty(1, spec.poses_per_voxel, chain.n))  # warm-up
        began = time.thread_time()
    compute(0, spec.n_voxels, out)
    seconds = time.thread_time() - began
    attempts, iterations = out.effort.sum(axis=0).tolist()
    return Measured(out.outcome == 0, out.torque, attempts, iterations, seconds)


class ExhaustiveSearch:
    """Blind attempts, many and long ones. What they reach is kept in the user's cache folder.

    Args:
        attempts: from random starts, of EXHAUSTIVE_ITERATIONS iterations each.
    """

    def __init__(self, attempts: int = 200) -> None:
        self.attempts = attempts

    def reached(self, urdf: str, spec: EvaluationSpec) -> Mask:
        """Return which of a spec's poses (voxels, poses) the search reaches."""
        effort = {"restarts": self.attempts - 1, "iterations": EXHAUSTIVE_ITERATIONS}
        long = with_ik(spec, "paper").model_copy(update=effort)
        shape = (spec.n_voxels, spec.poses_per_voxel)
        key = hashlib.sha256("\n".join((urdf, long.to_json(), CACHE.source_hash(), __version__)).encode()).hexdigest()
        file = cache_base() / "bench" / f"{key[:32]}.bits"
        try:
            bits = np.frombuffer(file.read_bytes(), np.uint8)
            if len(bits) == (math.prod(shape) + 7) // 8:
                return np.unpackbits(bits, count=math.prod(shape)).astype(bool).reshape(shape)
        except OSError:
            pass
        reached = measure(chain_of(urdf, long), long).reached
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
            replace_whole(file, np.packbits(reached).tobytes())
        except OSError:
            pass  # a cache, no more
        return reached


def target_rotations(spec: EvaluationSpec) -> Array:
    """Return the orientations (voxels, poses, 3, 3) of a spec's targets."""
    if spec.target_poses:
        return given_rotations(spec)
    rotations = np.empty((spec.n_voxels, spec.poses_per_voxel, 3, 3))
    for voxel in range(spec.n_voxels):
        for pose in range(spec.poses_per_voxel):
            target_rotation(spec.seed, voxel, pose, rotations[voxel, pose])
    return rotations


def blind_restarts(chain: Chain, spec: EvaluationSpec) -> tuple[Array, Array]:
    """Return how many of BLIND_SEEDS searches from random starts reach a pose, and its mean torque over them (N m).

    They are those of ik_mode ``paper``. All have the spec's targets, and starts of other seeds than the spec's.
    """
    plain, rotations = with_ik(spec, "paper"), target_rotations(spec)
    times, total = np.zeros(rotations.shape[:2]), np.zeros(rotations.shape[:2])
    for i in range(BLIND_SEEDS):
        other = plain.model_copy(update={"seed": (spec.seed + 1 + i) % 2**63})
        found = measure(chain, other, rotations=rotations)
        times += found.reached
        total += np.where(found.reached, found.torque, 0.0)
    return times, total / np.maximum(times, 1)


def torque_ratio(own: Measured, times: Array, blind: Array) -> tuple[float, float]:
    """Return mean torque against that of blind restarts, over the poses both reach, and its standard error.

    A ratio of means over pairs (Cochran, Sampling Techniques, section 2.11): its error is that of the mean of
    own - ratio * blind, which holds the chance of either's starts. NaN where fewer than two poses count.
    """
    both = own.reached & (times > 0)
    count = int(np.count_nonzero(both))
    if count < 2:
        return math.nan, math.nan
    a, b = own.torque[both], blind[both]
    if not b.sum() > 0:
        return math.nan, math.nan
    ratio = float(a.sum() / b.sum())
    rest = a - ratio * b
    return ratio, float(rest.std(ddof=1) / math.sqrt(count) / b.mean())
