"""The two engines as one kind of function: evaluate a range of voxels, write outcomes and configurations."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import numpy as np

from mobo_core.errors import UnableError
from mobo_core.evaluation.chain import Array, Chain
from mobo_core.evaluation.effort import effort as effort_of
from mobo_core.evaluation.kernel.arguments import Effort, Obstacles, Outputs, Question, Starts, Table
from mobo_core.evaluation.kernel.load import kernel
from mobo_core.evaluation.kernel.orientation import ORIENTATIONS
from mobo_core.evaluation.kernel.starts import no_table
from mobo_core.evaluation.obstacles import flat_arm, obstacles_of
from mobo_core.evaluation.spec import EvaluationSpec, lacks
from mobo_core.evaluation.tables import share, start_table_1, start_table_2
from mobo_core.evaluation.targets import given_rotations
from mobo_core.jit.numerics import sin_cos

# Poses of the smallest part that a thread takes.
_LEAST_POSES = 96

Compute = Callable[[int, int, Outputs], None]


def half_angle_sine(angle: float) -> float:
    """Return twice the sine of half of ``angle`` (rad), the measure in which orientation errors are compared."""
    return 2.0 * float(sin_cos(0.5 * angle)[0])


def _question(spec: EvaluationSpec, centres: Array, rotations: Array, obstacles: Obstacles) -> Question:
    return Question(
        centres, rotations, spec.seed, spec.poses_per_voxel, spec.restarts + 1, spec.iterations,
        spec.position_tolerance, half_angle_sine(spec.rotation_tolerance),
        spec.self_collision, spec.solution == "least_torque", np.array(spec.gravity),
        ORIENTATIONS[spec.orientation], obstacles,
    )  # fmt: skip


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


def kernel_call(
    chain: Chain, spec: EvaluationSpec, threads: int, centres: Array, rotations: Array
) -> tuple[Compute, float]:
    """Return the function that evaluates a range of voxels, and the seconds its preparation took.

    Raises:
        UnableError: an ik_mode that it does not have.
    """
    if lack := lacks("kernel", spec.ik_mode):
        raise UnableError(lack, where="kernel", expected="'paper' or 'complete'; or engine 'reference'")
    compiled = kernel(chain.n)
    began = time.perf_counter()
    arm = flat_arm(chain)
    table: Starts | Table = no_table(chain.n)
    effort: Effort | None = None
    if spec.ik_mode == "complete":
        make = start_table_1 if spec.rules == 1 else start_table_2
        table = make(compiled, chain, arm.constants, spec.seed, threads)
        if spec.rules > 1:
            effort = effort_of(spec.rules, chain.n, spec.iterations)
    question = _question(spec, centres, rotations, obstacles_of(arm, spec))

    def compute(first: int, last: int, out: Outputs) -> None:
        def work(low: int, high: int) -> None:
            part = out.part(low - first, high - first)
            if effort is None:
                compiled.evaluate_voxels(arm, table, question, low, high, part)
            else:
                compiled.evaluate_voxels_complete(arm, table, question, effort, low, high, part)

        share(work, _parts(first, last, spec.poses_per_voxel, threads), threads)

    return compute, time.perf_counter() - began


def reference_call(chain: Chain, spec: EvaluationSpec, centres: Array) -> Compute:
    """Return the function that evaluates a range of voxels by the reference engine.

    Raises:
        UnableError: an ik_mode that it does not have.
    """
    from mobo_core.evaluation import irteus
    from mobo_core.evaluation.reference import evaluate_voxels_reference

    if lack := lacks("reference", spec.ik_mode):
        raise UnableError(lack, where="reference engine", expected="'paper' or 'irteus'")
    method = (irteus.start, irteus.advance) if spec.ik_mode == "irteus" else None
    question = _question(spec, centres, given_rotations(spec), obstacles_of(flat_arm(chain), spec))

    def compute(first: int, last: int, out: Outputs) -> None:
        evaluate_voxels_reference(chain, question, first, last, out, method)

    return compute
