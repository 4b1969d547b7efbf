"""The two engines as one kind of function: evaluate a range of voxels, write outcomes and configurations."""

from __future__ import annotations

import functools
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from mobo_core.errors import UnableError
from mobo_core.evaluation.chain import Array, Chain
from mobo_core.evaluation.kernel.arguments import Arm, Outputs, Question, Starts
from mobo_core.evaluation.kernel.load import kernel
from mobo_core.evaluation.kernel.starts import GRID, no_table, sort_table, unit_samples
from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.jit.numerics import sin_cos

# Configurations sampled for the starts of ik_mode complete.
TABLE_SAMPLES = 20_000
# Poses of the smallest part that a thread takes.
_LEAST_POSES = 96
# Orientations of no targets: the kernel draws them.
DRAWN = np.zeros((0, 0, 3, 3))


Compute = Callable[[int, int, Outputs], None]


def half_angle_sine(angle: float) -> float:
    """Return twice the sine of half of ``angle`` (rad), the measure in which orientation errors are compared."""
    return 2.0 * float(sin_cos(0.5 * angle)[0])


def _question(spec: EvaluationSpec, centres: Array, rotations: Array) -> Question:
    return Question(
        centres, rotations, spec.seed, spec.poses_per_voxel, spec.restarts + 1, spec.iterations,
        spec.position_tolerance, half_angle_sine(spec.rotation_tolerance),
        spec.self_collision, spec.solution == "least_torque", np.array(spec.gravity),
    )  # fmt: skip


@functools.lru_cache(4)
def _unit_samples(seed: int, n: int) -> Array:
    """Return the sampled configurations that all arms of ``n`` joints share, as shares of their joint ranges."""
    samples = np.empty((TABLE_SAMPLES, n))
    unit_samples(seed, samples)
    return samples


def _share(work: Callable[[int, int], None], parts: Iterable[tuple[int, int]], threads: int) -> None:
    """Have ``threads`` threads, this one among them, do ``work`` on the parts, each taking the next one in turn."""
    left = iter(list(parts))

    def take() -> None:
        for low, high in left:
            work(low, high)

    if threads == 1:
        return take()
    with ThreadPoolExecutor(threads - 1) as pool:
        others = [pool.submit(take) for _ in range(threads - 1)]
        take()
    for other in others:
        other.result()


def _parts(first: int, last: int, poses: int, threads: int) -> Iterator[tuple[int, int]]:
    """Yield ranges of voxels that make up ``first`` to ``last`` - 1, ever smaller ones.

    Voxels differ much in cost, so threads end together only if the last parts are small. Each part costs
    something, since lanes run empty at its end.
    """
    least = max(1, _LEAST_POSES // poses)
    while first < last:
        left = last - first
        size = min(left, max(least, left * 7 // (8 * threads))) if threads > 1 else left
        yield first, first + size
        first += size


class _Workspace(threading.local):
    """The arrays of a table of starts, kept from one evaluation of a thread to the next.

    They are 5 MB; fresh ones each time would cost as much in page faults as all else about the table.
    """

    def __init__(self) -> None:
        self._arrays: dict[int, tuple[Starts, Array, NDArray[np.int64]]] = {}

    def arrays(self, n: int) -> tuple[Starts, Array, NDArray[np.int64]]:
        """Return a table, tips (12, m) and cells (m,) for arms of ``n`` joints."""
        if n not in self._arrays:
            m = TABLE_SAMPLES
            self._arrays[n] = (
                Starts(np.empty((m, n)), np.empty(m, np.int64), np.empty(GRID**3 + 1, np.int64), np.empty((12, m))),
                np.empty((12, m)),
                np.empty(m, np.int64),
            )
        return self._arrays[n]


_workspace = _Workspace()


def _table(compiled: ModuleType, chain: Chain, constants: Array, seed: int, threads: int) -> Starts:
    """Return the arm's table of starts.

    The arrays are this thread's, and the next call's too.
    """
    unit = _unit_samples(seed, chain.n)
    table, tips, cells = _workspace.arrays(chain.n)
    q = table.q
    span = chain.upper - chain.lower

    def sample(low: int, high: int) -> None:
        np.multiply(unit[low:high], span, out=q[low:high])
        np.add(q[low:high], chain.lower, out=q[low:high])
        compiled.table_tips(constants, q, low, high, tips)

    m = len(unit)
    _share(sample, [(m * i // threads, m * (i + 1) // threads) for i in range(threads)], threads)
    sort_table(tips, chain.placement_p[0], chain.reach_radius, cells, table.order, table.cell_first, table.poses)
    return table


def kernel_call(
    chain: Chain, spec: EvaluationSpec, threads: int, centres: Array, rotations: Array
) -> tuple[Compute, float]:
    """Return the function that evaluates a range of voxels, and the seconds its preparation took."""
    compiled = kernel(chain.n)
    began = time.perf_counter()
    constants = np.empty((chain.n + 1, 12))
    constants[:-1, :9], constants[:-1, 9:] = chain.placement_r.reshape(-1, 9), chain.placement_p
    constants[-1, :9], constants[-1, 9:] = chain.tip_r.ravel(), chain.tip_p
    complete = spec.ik_mode == "complete"
    arm = Arm(
        chain.placement_r, chain.placement_p, chain.tip_r, chain.tip_p, constants, chain.lower, chain.upper,
        chain.mass, chain.com, chain.reach_radius, chain.capsule_joint, chain.capsule_a, chain.capsule_b,
        chain.capsule_radius, chain.pairs,
    )  # fmt: skip
    table = _table(compiled, chain, constants, spec.seed, threads) if complete else no_table(chain.n)
    question = _question(spec, centres, rotations)

    def compute(first: int, last: int, out: Outputs) -> None:
        def work(low: int, high: int) -> None:
            compiled.evaluate_voxels(arm, table, question, low, high, out.part(low - first, high - first))

        _share(work, _parts(first, last, spec.poses_per_voxel, threads), threads)

    return compute, time.perf_counter() - began


def reference_call(chain: Chain, spec: EvaluationSpec, centres: Array) -> Compute:
    """Return the function that evaluates a range of voxels by the reference engine.

    Raises:
        UnableError: an ik_mode that it does not have.
    """
    from mobo_core.evaluation.reference import evaluate_voxels_reference

    if spec.ik_mode != "paper":
        raise UnableError(f"ik_mode {spec.ik_mode!r}", where="reference engine", expected="'paper'")
    question = _question(spec, centres, DRAWN)

    def compute(first: int, last: int, out: Outputs) -> None:
        evaluate_voxels_reference(chain, question, first, last, out)

    return compute
