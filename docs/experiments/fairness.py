"""How well studies know every joint order: their best arms of each, against those of long_search.py (see search.md).

    python docs/experiments/fairness.py bags/structured_0 bags/tpe_0 --trials 3000 20000

Prints a row for each bag and number of trials. Orders count whose long search reaches 10 voxels of the workspace or
more, twins if one of them does in the study. Short: by how much a study's best reach of an order is below the long
search's; it may be above.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import mobo_core as mobo
from mobo_core.search.front import aims_of, hypervolume
from mobo_core.search.samplers.structured.orders import twins

FILE = Path(__file__).with_name("long_search.npz")
LEAST_REACH = 10.0
HEADINGS = (
    "study", "sampler", "trials", "hypervolume", "orders tried", "that reach 10", "best reach, mean of all",
    "short, mean", "within 3", "within 1.5",
    "own hypervolume, short", "within 0.015", "twins apart, worst", "within 2",
)  # fmt: skip
Values = list[tuple[float, float]]
Array = np.ndarray[Any, Any]


class Long(NamedTuple):
    """What a long search found of an order: best reach, and the hypervolume of its front."""

    reach: float
    volume: float


def long_searches(file: Path, spec: mobo.EvaluationSpec) -> dict[str, Long]:
    """Return those of all orders in a file of long_search.py."""
    data = np.load(file)
    found: dict[str, Values] = {}
    for order, (reach, torque) in zip(data["order"].tolist(), data["values"].tolist(), strict=True):
        found.setdefault(order, []).append((reach, torque))
    aims = aims_of(("reach", "torque"), spec)
    return {
        order: Long(max(reach for reach, _ in values), hypervolume(values, aims)) for order, values in found.items()
    }


def row(rows: Sequence[Any], settings: mobo.StudySettings, long: dict[str, Long]) -> list[str]:
    """Return the figures of a study's first trials as text, from the number of orders tried on."""
    aims = aims_of(("reach", "torque"), settings.spec)
    own: dict[str, Values] = {}
    for trial in rows:
        if trial.complete:
            own.setdefault(trial.joints, []).append((trial.reach, trial.torque))
    best = {order: max(reach for reach, _ in values) for order, values in own.items()}
    volumes = {order: hypervolume(values, aims) for order, values in own.items()}
    counted = [order for order, found in long.items() if found.reach >= LEAST_REACH]
    short = np.array([long[order].reach - best.get(order, 0.0) for order in counted])
    lacking = np.array([long[order].volume - volumes.get(order, 0.0) for order in counted])
    pairs = twins(settings.space, settings.spec, ("reach", "torque"))
    reached = [(best.get(a, 0.0), best.get(b, 0.0)) for a, b in pairs.items() if a < b]
    apart = np.array([abs(one - other) for one, other in reached if max(one, other) >= LEAST_REACH])
    return [
        f"{hypervolume([value for values in own.values() for value in values], aims):.4f}",
        f"{len(own)}",
        f"{sum(reach >= LEAST_REACH for reach in best.values())}",
        f"{sum(best.values()) / settings.space.n_orders:.1f}",
        *(_mean(short, ".2f"), _mean(short <= 3.0, ".1%"), _mean(short <= 1.5, ".1%")),
        *(_mean(lacking, ".4f"), _mean(lacking <= 0.015, ".1%")),
        f"{apart.max(initial=0.0):.1f}",
        _mean(apart <= 2.0, ".1%"),
    ]


def _mean(values: Array, form: str) -> str:
    return format(float(values.mean()), form) if len(values) else "–"


def unseen(rows: Sequence[Any], settings: mobo.StudySettings, least: float) -> str:
    """Return how the best arm of each order does on poses of another seed."""
    spec = settings.spec.model_copy(update={"seed": settings.spec.seed + 1})
    best: dict[str, Any] = {}
    for trial in rows:
        if trial.complete and trial.reach >= max(least, best[trial.joints].reach if trial.joints in best else 0.0):
            best[trial.joints] = trial
    lost = [
        trial.reach - mobo.evaluate(mobo.Design(trial.sampled_joints, trial.lengths), spec, space=settings.space).reach
        for trial in best.values()
    ]
    return f"{len(lost)} best arms on unseen poses: reach lower by {np.mean(lost):+.2f}, at most {max(lost):+.2f}"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bags", type=Path, nargs="+", metavar="BAG")
    parser.add_argument("--trials", type=int, nargs="*", default=[], help="after how many; all by default")
    parser.add_argument("--long", type=Path, default=FILE, help="file of long_search.py")
    parser.add_argument("--unseen", action="store_true", help="re-score each order's best arm on other poses, too")
    args = parser.parse_args()
    print("| " + " | ".join(HEADINGS) + " |\n| --- | --- |" + " ---: |" * (len(HEADINGS) - 2))
    said = []
    for bag in args.bags:
        study = mobo.read_study(bag)
        rows, settings = mobo.study_table(study).rows, study.settings
        long = long_searches(args.long, settings.spec)
        for count in args.trials or [len(rows)]:
            if count <= len(rows):
                cells = [bag.name, settings.sampler, f"{count:,}", *row(rows[:count], settings, long)]
                print("| " + " | ".join(cells) + " |", flush=True)
        if args.unseen:
            said.append(f"{bag.name}: {unseen(rows, settings, LEAST_REACH)}")
    print("", *said, sep="\n")


if __name__ == "__main__":
    main()
