"""What sets PRRYPY apart from YPPYPY: the same elbow arm, with its first axis laid down or upright; for paper.md.

    python docs/experiments/mounting.py bound --trials 2000
    python docs/experiments/mounting.py run --trials 1000
    python docs/experiments/mounting.py table

`bound` lets joints turn freely and links pass through each other: every elbow manipulator (Paden and Sastry, IJRR 1988)
with links of equal length, and a search over all orders for one that reaches more. `run` searches one order at a time,
on bases that lean and with ranges of joints that are turned; a search is kept trial by trial, and gone on with. `table`
evaluates the best arms of each search on poses that it did not see.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from studies import SPEC, run

import mobo_core as mobo
from mobo_core.arms.resample import Interval, Resamples, Score
from mobo_core.atlas.regret import voxels_within
from mobo_core.design import Design, DesignSpace
from mobo_core.design.description import to_urdf
from mobo_core.design.joints import effective_orders
from mobo_core.evaluation.evaluate import evaluate
from mobo_core.search.front import aims_of, hypervolume

FOLDER = Path("bags/mounting")
SIDEWAYS = ["-90deg", "90deg"]
FREE = {"joint_limit": "360deg"}
UNSEEN = SPEC.model_copy(update={"seed": 1, "poses_per_voxel": 100})
CASES: dict[str, tuple[str, dict[str, object]]] = {
    "PRRYPY": ("PRRYPY", {}),
    "YPPYPY": ("YPPYPY", {}),
    "YPPYPY, base tilted": ("YPPYPY", {"base_tilt": SIDEWAYS}),
    "YPPYPY, joint 2 centred": ("YPPYPY", {"joint_center": [0, SIDEWAYS, 0, 0, 0, 0]}),
    "YPPYPY, tilted and centred": ("YPPYPY", {"base_tilt": SIDEWAYS, "joint_center": [0, SIDEWAYS, 0, 0, 0, 0]}),
    "PRRYPY, tilted and centred": ("PRRYPY", {"base_tilt": SIDEWAYS, "joint_center": [0, SIDEWAYS, 0, 0, 0, 0]}),
    "PRRYPY, all": ("PRRYPY", {"base_tilt": SIDEWAYS, "base_height": [-0.2, 0.4], "joint_center": [SIDEWAYS] * 6}),
    "YPPYPY, all": ("YPPYPY", {"base_tilt": SIDEWAYS, "base_height": [-0.2, 0.4], "joint_center": [SIDEWAYS] * 6}),
}


def settings_of(case: str) -> mobo.StudySettings:
    """Return the settings of a search of one order."""
    order, values = CASES[case]
    space = DesignSpace.of({"joints": list(order), **values})
    return mobo.StudySettings(space=space, spec=SPEC, sampler="structured", in_flight=8)


def file_of(case: str) -> Path:
    """Return where the trials of a search are."""
    return FOLDER / f"{case.replace(', ', '_').replace(' ', '_')}.jsonl"


def designs_of(case: str) -> Iterator[tuple[Design, float, float]]:
    """Yield the arms of a search, their reach and their torque in N m."""
    space = settings_of(case).space
    for line in file_of(case).read_text(encoding="utf-8").splitlines():
        params, (reach, torque) = json.loads(line)
        yield space.design(params), reach, torque


def is_elbow(order: str) -> bool:
    """Return whether six joints make an elbow manipulator if all links but the second and third have no length.

    The second axis is at right angles to the first, the third parallel to it, and the last three, each at right angles
    to the one before, meet in one point.
    """
    return order[0] != order[1] == order[2] and order[3] != order[4] != order[5]


def bound(trials: int) -> None:
    """Print what elbow manipulators reach without limits and collisions, and the most that a search finds."""
    spec = SPEC.model_copy(update={"self_collision": False})
    space = DesignSpace.of(FREE)
    half = 0.5 * space.total_ends[1]
    elbows = [order for order in effective_orders(6, "RPY") if is_elbow(order)]
    inside = sum(np.linalg.norm(spec.voxel_centres(), axis=1) < space.total_ends[1] - 1e-9)
    reach = {}
    for i, order in enumerate(elbows, start=1):
        reach[order] = evaluate(to_urdf(Design(order, (0.0, half, half, 0.0, 0.0, 0.0)), space), spec).reach
        print(f"elbow manipulators: {i} of {len(elbows)}", end="\r", flush=True)
    print(f"voxels strictly within the arm's length: {inside}; within or on it: {voxels_within(space, spec)}")
    worst, best = min(reach, key=reach.__getitem__), max(reach, key=reach.__getitem__)
    print(f"{len(elbows)} elbow orders: {reach[worst]:.2f} ({worst}) to {reach[best]:.2f} ({best}) voxels")
    settings = mobo.StudySettings(space=space, spec=spec, sampler="structured", in_flight=8)
    file = FOLDER / "bound.jsonl"
    run(settings, trials, file)
    found = [(values[0], space.design(params)) for params, values in map(json.loads, file.open(encoding="utf-8"))]
    most, design = max(found, key=lambda pair: pair[0])
    lengths = "/".join(f"{length:.3f}" for length in design.lengths)
    print(f"of {len(found):,} arms of all orders the highest reach: {most:.2f} ({design.joints} {lengths})")


def text_of(interval: Interval, digits: int = 1) -> str:
    """Return a value and its 95 % interval."""
    return f"{interval.value:+.{digits}f} [{interval.low:+.{digits}f}, {interval.high:+.{digits}f}]"


def table() -> None:
    """Print the best arms of each search on unseen poses, against those of the first case."""
    resamples, aims = Resamples(UNSEEN), aims_of(("reach", "torque"), SPEC)
    first: tuple[Score, Score] | None = None
    print(
        "| search | trials | hypervolume | highest reach: arm | its reach on unseen poses | more than PRRYPY's "
        "| its torque N m | reach at PRRYPY's torque or less | more than PRRYPY's |"
    )
    print("| --- | ---: | ---: | --- | ---: | ---: | ---: | ---: | ---: |")
    limit = np.inf
    for case in (case for case in CASES if file_of(case).exists()):
        space, arms = settings_of(case).space, list(designs_of(case))
        design, reach, torque = max(arms, key=lambda arm: arm[1])
        if first is None:
            limit = torque
        within = max((arm for arm in arms if arm[2] <= limit), key=lambda arm: arm[1])
        own = [resamples.score(to_urdf(each, space)) for each in (design, within[0])]
        first = first or (own[0], own[1])
        more = [text_of(mine.over(its)[0]) for mine, its in zip(own, first, strict=True)]
        base = f", tilt {np.degrees(design.base_tilt):.0f}°" * bool(design.base_tilt)
        centers = "/".join(f"{np.degrees(center):.0f}" for center in design.joint_centers)
        base += f", centres {centers}°" * bool(centers)
        base += f", height {design.base_height:.2f}" * bool(design.base_height)
        lengths = "/".join(f"{length:.2f}" for length in design.lengths)
        volume = hypervolume([arm[1:] for arm in arms], aims)
        print(
            f"| {case} | {len(arms):,} | {volume:.4f} | {lengths}{base} | {own[0].reach:.1f} | {more[0]} "
            f"| {own[0].torque:.0f} | {own[1].reach:.1f} | {more[1]} |",
            flush=True,
        )


def main() -> None:
    """Run as a script."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["bound", "run", "table"])
    parser.add_argument("--trials", type=int, default=1000, help="of a search [1000]")
    parser.add_argument("--cases", nargs="+", choices=list(CASES), default=list(CASES), metavar="CASE", help="[all]")
    args = parser.parse_args()
    FOLDER.mkdir(parents=True, exist_ok=True)
    if args.what == "bound":
        bound(args.trials)
    elif args.what == "run":
        for case in args.cases:
            run(settings_of(case), args.trials, file_of(case))
    else:
        table()


if __name__ == "__main__":
    main()
