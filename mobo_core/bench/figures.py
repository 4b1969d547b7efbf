"""What the arms of a bench come to: a row an arm, the figures of a group, those of a spec."""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from typing import TypedDict

from mobo_core.evaluation.spec import EvaluationSpec

# Reachable poses from which on a single one missed is less than a quarter of a percent of them, and the recall that is
# then asked for.
MANY, ENOUGH = 400, 0.995


class Row(TypedDict):
    """One arm's figures; see :func:`mobo_core.bench.evaluation.bench_evaluate`. None: not measured.

    ``found`` poses the search reaches, and ``missed`` ones it does not but the exhaustive search does.
    ``torque_ratio`` is the mean torque over that of blind restarts, ``torque_se`` its standard error.
    """

    group: str
    name: str
    lengths: list[float]
    reach: float
    reach_exhaustive: float | None
    found: int
    missed: int | None
    recall: float | None
    ms: float
    us_per_pose: float
    attempts: int
    iterations: int
    ratio_reference: float | None
    us_per_iteration_reference: float | None
    torque_ratio: float | None
    torque_se: float | None


class Group(TypedDict):
    """A group's figures. None: not measured, or no arm that counts.

    ``reached`` is the share of all poses. ``recall`` is that of all arms' poses together; ``below`` counts the arms of
    MANY reachable poses whose recall is less than ENOUGH, ``most_missed`` poses are missed of an arm of fewer.
    ``torque_ratio`` is the mean over the arms of MANY reachable poses, ``torque_off`` the largest difference from 1
    among them, ``torque_beyond`` the largest that remains of a difference less two standard errors. ``speedup`` is
    over the first spec: mean ms to mean ms.
    """

    arms: int
    mean_ms: float
    median_ms: float
    worst_ms: float
    mean_us_per_pose: float
    iterations_per_pose: float
    reached: float
    found: int
    missed: int | None
    recall: float | None
    mean_recall: float | None
    min_recall: float | None
    below: int | None
    most_missed: int | None
    mean_ratio: float | None
    min_ratio: float | None
    torque_ratio: float | None
    torque_off: float | None
    torque_beyond: float | None
    speedup: float


class SpecBench(TypedDict):
    """A spec's figures: of each arm, each group, and all arms."""

    spec: str
    designs: list[Row]
    groups: dict[str, Group]
    median_ratio: float | None
    min_recall: float | None
    median_us_per_pose: float
    us_per_iteration_reference: float | None


def spec_bench(label: str, spec: EvaluationSpec, rows: list[Row]) -> SpecBench:
    """Return the figures of a spec from those of the arms."""
    poses = spec.n_voxels * spec.poses_per_voxel
    groups = dict.fromkeys(row["group"] for row in rows)
    ratios = [row["ratio_reference"] for row in rows if row["ratio_reference"] is not None]
    iteration = [row["us_per_iteration_reference"] for row in rows if row["us_per_iteration_reference"] is not None]
    return {
        "spec": label,
        "designs": rows,
        "groups": {name: _group([row for row in rows if row["group"] == name], poses) for name in groups},
        "median_ratio": statistics.median(ratios) if ratios else None,
        "min_recall": min((row["recall"] for row in rows if row["recall"] is not None), default=None),
        "median_us_per_pose": statistics.median(row["us_per_pose"] for row in rows),
        "us_per_iteration_reference": statistics.median(iteration) if iteration else None,
    }


def _group(rows: Sequence[Row], poses: int) -> Group:
    ms = [row["ms"] for row in rows]
    found = sum(row["found"] for row in rows)
    ratios = [row["ratio_reference"] for row in rows if row["ratio_reference"] is not None]
    group: Group = {
        "arms": len(rows),
        "mean_ms": statistics.fmean(ms),
        "median_ms": statistics.median(ms),
        "worst_ms": max(ms),
        "mean_us_per_pose": 1e3 * statistics.fmean(ms) / poses,
        "iterations_per_pose": statistics.fmean(row["iterations"] for row in rows) / poses,
        "reached": found / (poses * len(rows)),
        "found": found,
        "missed": None,
        "recall": None,
        "mean_recall": None,
        "min_recall": None,
        "below": None,
        "most_missed": None,
        "mean_ratio": statistics.fmean(ratios) if ratios else None,
        "min_ratio": min(ratios, default=None),
        "torque_ratio": None,
        "torque_off": None,
        "torque_beyond": None,
        "speedup": 1.0,
    }
    recalls = [
        (row["recall"], row["missed"], row["found"] + row["missed"])
        for row in rows
        if row["recall"] is not None and row["missed"] is not None
    ]
    if recalls:
        missed = sum(missed for _, missed, _ in recalls)
        group["missed"], group["recall"] = missed, found / (found + missed) if found + missed else 1.0
        group["mean_recall"] = statistics.fmean(recall for recall, _, _ in recalls)
        group["min_recall"] = min(recall for recall, _, _ in recalls)
        group["below"] = sum(recall < ENOUGH for recall, _, union in recalls if union >= MANY)
        group["most_missed"] = max((missed for _, missed, union in recalls if union < MANY), default=None)
    torques = [
        (row["torque_ratio"], row["torque_se"])
        for row in rows
        if row["torque_ratio"] is not None
        and row["torque_se"] is not None
        and row["found"] + (row["missed"] or 0) >= MANY
    ]
    if torques:
        group["torque_ratio"] = statistics.fmean(ratio for ratio, _ in torques)
        group["torque_off"] = max(abs(ratio - 1.0) for ratio, _ in torques)
        group["torque_beyond"] = max(abs(ratio - 1.0) - 2.0 * error for ratio, error in torques)
    return group
