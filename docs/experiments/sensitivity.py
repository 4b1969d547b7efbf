"""Evaluate the best arm of each prefix that the paper names once more, by what it leaves open; for paper.md.

    python docs/experiments/sensitivity.py docs/paper/tpe6_best
    python docs/experiments/sensitivity.py docs/paper/tpe6_best --front

A row for each way to ask: other IK, tolerances, limits, collisions, voxels. `--front` asks the arms of the front, with
voxels of 0.1 m, 100 poses each and complete IK, and says how far their ranking holds. The bag may be a study's, or the
one of its best arms. EusLisp's IK (`irteus`) is not compiled, and takes minutes an arm: `--only` and the names of rows
leave it out.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy import stats

from mobo_core.bag.collector import read_study
from mobo_core.design import Design, DesignSpace
from mobo_core.evaluation import EvaluationSpec
from mobo_core.evaluation.evaluate import evaluate
from mobo_core.evaluation.spec import load_spec, with_ik
from mobo_core.report.prefixes import found, groups
from mobo_core.report.row import Row
from mobo_core.report.table import study_table
from mobo_core.search.front import aims_of, pareto_front


@dataclass(frozen=True)
class Way:
    """A way to ask: what of the study's spec and space differs; whether only voxels strictly within reach count."""

    name: str
    spec: dict[str, object] = field(default_factory=dict)
    space: dict[str, object] = field(default_factory=dict)
    ik: str = ""
    inside: bool = False


WAYS = (
    Way("as the study"),
    Way("one attempt", {"restarts": 0}),
    Way("20 restarts", {"restarts": 20}),
    Way("complete IK", ik="complete"),
    Way("irteus", ik="irteus"),
    Way("2 mm", {"position_tolerance": 2e-3}),
    Way("no self-collision", {"self_collision": False}),
    Way("links twice as thick", space={"link_radius": 0.03, "link_density": 250.0}),
    Way("limits ±3π/2", space={"joint_limit": "270deg"}),
    Way("voxels strictly inside", inside=True),
    Way("other poses (seed 1)", {"seed": 1}),
)


def values(row: Row, spec: EvaluationSpec, space: DesignSpace, inside: bool = False) -> tuple[float, float]:
    """Return reach in voxels and torque in N m."""
    design = Design(row.sampled_joints, row.lengths)
    result = evaluate(design, spec, space=space, engine="reference" if spec.ik_mode == "irteus" else "kernel")
    distance = np.linalg.norm(spec.voxel_centres(), axis=1)
    counted = distance < space.total_ends[1] - 1e-9 if inside else np.ones(spec.n_voxels, bool)
    return float(result.voxel_reach[counted].sum()), float(result.voxel_torque[counted].sum())


def main() -> None:
    """Run as a script."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bag", type=Path)
    parser.add_argument("--front", action="store_true", help="the front's arms, on finer voxels")
    names = [way.name for way in WAYS]
    parser.add_argument("--only", nargs="+", choices=names, default=names, metavar="ROW", help=", ".join(names))
    args = parser.parse_args()
    study = read_study(args.bag)
    table, settings = study_table(study), study.settings
    if args.front:
        front(table.useful_front, settings.space)
        return
    best = {group.prefix: group.best for group in found(groups(table), others=0) if group.best}
    print("| " + " | ".join(["asked", *best, "ranks of reach, of torque"]) + " |")
    print("| --- |" + " ---: |" * (len(best) + 1))
    base = None
    for way in (way for way in WAYS if way is WAYS[0] or way.name in args.only):
        spec = settings.spec if not way.ik else with_ik(settings.spec, way.ik)
        spec = EvaluationSpec.of({**spec.to_dict(), **way.spec})
        space = DesignSpace.of({**settings.space.to_dict(), **way.space})
        found_values = np.array([values(row, spec, space, way.inside) for row in best.values()])
        base = found_values if base is None else base
        ranks = ", ".join(f"{stats.spearmanr(base[:, k], found_values[:, k]).statistic:.2f}" for k in (0, 1))
        cells = [f"{reach:.1f} / {torque:.0f}" for reach, torque in found_values]
        print("| " + " | ".join([way.name, *cells, ranks]) + " |", flush=True)


def front(rows: list[Row], space: DesignSpace) -> None:
    """Print how far the ranking of a front's arms holds when more is asked of them."""
    fine = with_ik(load_spec("paper_fine"), "complete").model_copy(update={"poses_per_voxel": 100})
    again = []
    for i, row in enumerate(rows, start=1):
        print(f"{i} of {len(rows)} arms", end="\r", flush=True)
        again.append(values(row, fine, space))
    before, after = np.array([(row.reach, row.torque) for row in rows]), np.array(again)
    reach, torque = (stats.spearmanr(before[:, k], after[:, k]).statistic for k in (0, 1))
    remain = len(pareto_front(again, aims_of(("reach", "torque"), fine)))
    print(
        f"{len(rows)} arms of the front above the reach floor: Spearman {reach:.3f} of reach, {torque:.3f} of torque; "
        f"{remain} are not dominated by another of them"
    )


if __name__ == "__main__":
    main()
