"""Speed and completeness of the evaluation over groups of arms, both sides of each ratio measured in one run."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from mobo_core.bench.figures import Row, SpecBench, spec_bench
from mobo_core.bench.groups import Arm
from mobo_core.bench.measure import (
    ExhaustiveSearch,
    Mask,
    Measured,
    blind_restarts,
    chain_of,
    measure,
    torque_ratio,
)
from mobo_core.evaluation.chain import Array, Chain
from mobo_core.evaluation.spec import EvaluationSpec, with_ik

_RUNS = 5


@dataclass(frozen=True)
class Wanted:
    """What to measure beside the time.

    Attributes:
        exhaustive_attempts: of the exhaustive search; 0: no recall.
        reference_poses: of each voxel, for the comparison with the reference engine; 0: none.
        torque: whether to compare torques with blind restarts.
    """

    exhaustive_attempts: int = 200
    reference_poses: int = 2
    torque: bool = False


def bench_evaluate(
    arms: Sequence[Arm],
    specs: dict[str, EvaluationSpec],
    wanted: Wanted,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> list[SpecBench]:
    """Measure the kernel on each arm by each spec, one thread, after warm-up.

    All times are CPU time of the thread, without reading the URDF: the median of five runs, in which the specs take
    turns. They count all poses, unreachable ones too. ``ratio_reference`` says how much longer the reference engine
    takes for a candidate in ik_mode ``paper``; it is measured on the first ``reference_poses`` poses of every voxel,
    and scaled to all. ``recall`` is the share that the spec's own search reaches of the poses that it or an exhaustive
    search reaches (blind attempts of 100 iterations).
    """
    labels = list(specs)
    rows: dict[str, list[Row]] = {label: [] for label in labels}
    for done, arm in enumerate(arms):
        chains = {label: chain_of(arm.urdf, spec) for label, spec in specs.items()}
        runs: dict[str, list[Measured]] = {label: [] for label in labels}
        for turn in range(1 + _RUNS):
            for label, spec in specs.items():
                run = measure(chains[label], spec)
                if turn:  # the first is to warm up
                    runs[label].append(run)
        others = _Others(arm, wanted)
        for label, spec in specs.items():
            rows[label].append(_row(arm, spec, chains[label], runs[label], others))
        progress(done + 1, len(arms))
    benches = [spec_bench(label, specs[label], rows[label]) for label in labels]
    for bench in benches:
        for name, group in bench["groups"].items():
            group["speedup"] = benches[0]["groups"][name]["mean_ms"] / group["mean_ms"]
    return benches


class _Others:
    """What an arm is compared with, measured once for all specs that differ in their own search alone."""

    def __init__(self, arm: Arm, wanted: Wanted) -> None:
        self._arm, self._wanted = arm, wanted
        self._reference: dict[str, Measured] = {}
        self._exhaustive: dict[str, Mask] = {}
        self._blind: dict[str, tuple[Array, Array]] = {}

    def reference(self, spec: EvaluationSpec, chain: Chain) -> Measured | None:
        if not self._wanted.reference_poses:
            return None
        few = with_ik(spec, "paper").model_copy(update={"poses_per_voxel": self._wanted.reference_poses})
        key = few.to_json()
        if key not in self._reference:
            self._reference[key] = measure(chain, few, "reference")
        return self._reference[key]

    def exhaustive(self, spec: EvaluationSpec) -> Mask | None:
        if not self._wanted.exhaustive_attempts:
            return None
        key = with_ik(spec, "paper").to_json()
        if key not in self._exhaustive:
            search = ExhaustiveSearch(self._wanted.exhaustive_attempts)
            self._exhaustive[key] = search.reached(self._arm.urdf, spec)
        return self._exhaustive[key]

    def blind(self, spec: EvaluationSpec, chain: Chain) -> tuple[Array, Array] | None:
        if not self._wanted.torque:
            return None
        key = with_ik(spec, "paper").to_json()
        if key not in self._blind:
            self._blind[key] = blind_restarts(chain, spec)
        return self._blind[key]


def _row(arm: Arm, spec: EvaluationSpec, chain: Chain, runs: list[Measured], others: _Others) -> Row:
    own, poses = runs[0], spec.poses_per_voxel
    total = spec.n_voxels * poses
    seconds = statistics.median(run.seconds for run in runs)
    row: Row = {
        "group": arm.group,
        "name": arm.design.name,
        "lengths": list(arm.design.lengths),
        "reach": _reach(own.reached),
        "reach_exhaustive": None,
        "found": int(np.count_nonzero(own.reached)),
        "missed": None,
        "recall": None,
        "ms": 1e3 * seconds,
        "us_per_pose": 1e6 * seconds / total,
        "attempts": own.attempts,
        "iterations": own.iterations,
        "ratio_reference": None,
        "us_per_iteration_reference": None,
        "torque_ratio": None,
        "torque_se": None,
    }
    reference = others.reference(spec, chain)
    if reference is not None:
        row["ratio_reference"] = reference.seconds * total / reference.reached.size / seconds
        if reference.iterations:
            row["us_per_iteration_reference"] = 1e6 * reference.seconds / reference.iterations
    exhaustive = others.exhaustive(spec)
    if exhaustive is not None:
        row["reach_exhaustive"] = _reach(exhaustive)
        missed = int(np.count_nonzero(exhaustive & ~own.reached))
        union = row["found"] + missed
        row["missed"] = missed
        row["recall"] = row["found"] / union if union else 1.0
    blind = others.blind(spec, chain)
    if blind is not None:
        ratio, error = torque_ratio(own, *blind)
        if not math.isnan(ratio):
            row["torque_ratio"], row["torque_se"] = ratio, error
    return row


def _reach(reached: Mask) -> float:
    return int(np.count_nonzero(reached)) / int(reached.shape[1])
