"""Speed and completeness of the evaluation, both sides of each ratio measured in one run."""

from __future__ import annotations

import statistics
from collections.abc import Callable
from typing import TypedDict

from mobo_core.design import Design, DesignSpace, to_urdf
from mobo_core.evaluation.evaluate import evaluate
from mobo_core.evaluation.result import Configurations, Result
from mobo_core.evaluation.spec import EvaluationSpec, with_ik

# Arms of the paper's and of known structures, with spread and with concentrated lengths.
DESIGNS: tuple[tuple[str, tuple[float, ...]], ...] = (
    ("PRRYPY", (0.06, 0.27, 0.16, 0.11, 0.0, 0.0)),
    ("PRRYPY", (0.1, 0.1, 0.1, 0.1, 0.1, 0.1)),
    ("YPPYPY", (0.05, 0.25, 0.2, 0.05, 0.0, 0.05)),
    ("YPPYPY", (0.0, 0.3, 0.3, 0.0, 0.0, 0.0)),
    ("YPPPYP", (0.05, 0.2, 0.15, 0.1, 0.05, 0.05)),
    ("YPPPYP", (0.0, 0.3, 0.25, 0.05, 0.0, 0.0)),
    ("RPYPRP", (0.05, 0.1, 0.2, 0.15, 0.1, 0.0)),
    ("RPYPRP", (0.0, 0.0, 0.3, 0.3, 0.0, 0.0)),
    ("YPRYPY", (0.05, 0.25, 0.2, 0.1, 0.0, 0.0)),
    ("YPYPYPR", (0.05, 0.15, 0.1, 0.15, 0.05, 0.1, 0.0)),
    ("YPYPYPR", (0.0, 0.0, 0.3, 0.0, 0.3, 0.0, 0.0)),
    ("YPRRYPY", (0.05, 0.05, 0.25, 0.15, 0.1, 0.0, 0.0)),
    ("YPRRYPY", (0.0, 0.0, 0.3, 0.15, 0.15, 0.0, 0.0)),
)

_RUNS = 5
_EXHAUSTIVE_ITERATIONS = 100


class Row(TypedDict):
    """One arm's figures; see :func:`bench_evaluate`."""

    name: str
    lengths: list[float]
    reach: float
    reach_exhaustive: float | None
    recall: float | None
    us_per_pose: float
    ratio_reference: float


class EvaluationBench(TypedDict):
    """Figures of all arms; see :func:`bench_evaluate`."""

    designs: list[Row]
    median_ratio: float
    min_recall: float | None
    median_us_per_pose: float
    us_per_iteration_reference: float


def bench_evaluate(
    designs: list[Design],
    spec: EvaluationSpec,
    exhaustive_attempts: int,
    reference_poses: int,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> EvaluationBench:
    """Measure the kernel on each design, one thread, after warm-up.

    ``us_per_pose`` counts all poses, unreachable ones too (median of five runs). ``ratio_reference`` says how
    much longer the reference engine takes for a candidate in ik_mode ``paper``; it is measured on the first
    ``reference_poses`` poses of every voxel, and scaled to all. ``recall`` is the share of the poses that an
    exhaustive search reaches (``exhaustive_attempts`` blind attempts of 100 iterations; none if 0) which
    the spec's own search reaches; ``reach_exhaustive`` is that search's reach.

    Raises:
        InputError: a design that no space has, such as one of too many joints.
    """
    rows: list[Row] = []
    reference_us: list[float] = []
    plain = with_ik(spec, "paper")
    few = plain.model_copy(update={"poses_per_voxel": reference_poses})
    long = plain.model_copy(update={"restarts": exhaustive_attempts - 1, "iterations": _EXHAUSTIVE_ITERATIONS})
    urdfs = [_urdf(design) for design in designs]  # all are sound before any is measured
    for i, (design, urdf) in enumerate(zip(designs, urdfs, strict=True)):
        evaluate(urdf, spec)  # warm-up
        runs = [evaluate(urdf, spec, configurations=True) for _ in range(_RUNS)]
        seconds = statistics.median(run.seconds for run in runs)
        reference = evaluate(urdf, few, engine="reference")
        if reference.iterations:
            reference_us.append(1e6 * reference.seconds / reference.iterations)
        recall: float | None = None
        exhaustive_reach: float | None = None
        if exhaustive_attempts:
            exhaustive = evaluate(urdf, long, configurations=True)
            recall, exhaustive_reach = _recall(runs[0], exhaustive), exhaustive.reach
        rows.append(
            {
                "name": design.name,
                "lengths": list(design.lengths),
                "reach": runs[0].reach,
                "reach_exhaustive": exhaustive_reach,
                "recall": recall,
                "us_per_pose": 1e6 * seconds / (spec.n_voxels * spec.poses_per_voxel),
                "ratio_reference": reference.seconds * spec.poses_per_voxel / reference_poses / seconds,
            }
        )
        progress(i + 1, len(designs))
    return {
        "designs": rows,
        "median_ratio": statistics.median(row["ratio_reference"] for row in rows),
        "min_recall": min((row["recall"] for row in rows if row["recall"] is not None), default=None),
        "median_us_per_pose": statistics.median(row["us_per_pose"] for row in rows),
        "us_per_iteration_reference": statistics.median(reference_us) if reference_us else 0.0,
    }


def _urdf(design: Design) -> str:
    space = {"n_joints": len(design.joints), "total_length": design.total_length}
    return to_urdf(design, DesignSpace.of(space, where=f"design {design.name}"))


def _recall(own: Result, exhaustive: Result) -> float:
    """Return the share of the exhaustive search's poses that the own search reaches."""
    there = _targets(exhaustive.configurations)
    return len(there & _targets(own.configurations)) / len(there) if there else 1.0


def _targets(configurations: Configurations | None) -> set[tuple[int, int]]:
    if configurations is None:
        return set()
    return set(zip(configurations.voxel.tolist(), configurations.pose.tolist(), strict=True))
