"""What sets PRRYPY apart from YPPYPY: the same elbow arm, with its first axis laid down or upright; for paper.md.

    python docs/experiments/mounting.py bound --trials 2000
    python docs/experiments/mounting.py run --trials 1000 --seeds 0 1 2 3 4
    python docs/experiments/mounting.py table
    python docs/experiments/mounting.py same

`bound` lets joints turn freely and links pass through each other: every elbow manipulator (Paden and Sastry, IJRR 1988)
with links of equal length, and a search over all orders for one that reaches more. `run` searches one order at a time,
on bases that lean and with ranges of joints that are turned; a search is kept trial by trial, and gone on with. `table`
evaluates the best arms of each search on poses that it did not see, and says how they differ from PRRYPY's: means over
the seeds, with 95 % intervals (Student's t, pairs of equal seeds) that hold the chance of the search and that of the
poses. A row of one seed has none. `same` searches nothing: it turns one YPPYPY step by step until it is PRRYPY.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy import stats
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
MOST_TORQUE = 375.0  # N m; PRRYPY's best arm takes about as much
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


def settings_of(case: str, seed: int = 0) -> mobo.StudySettings:
    """Return the settings of a search of one order."""
    order, values = CASES[case]
    space = DesignSpace.of({"joints": list(order), **values})
    return mobo.StudySettings(space=space, spec=SPEC, sampler="structured", in_flight=8, seed=seed)


def file_of(case: str, seed: int) -> Path:
    """Return where the trials of a search are."""
    return FOLDER / f"{case.replace(', ', '_').replace(' ', '_')}_{seed}.jsonl"


def designs_of(case: str, seed: int) -> Iterator[tuple[Design, float, float]]:
    """Yield the arms of a search, their reach and their torque in N m."""
    space = settings_of(case).space
    for line in file_of(case, seed).read_text(encoding="utf-8").splitlines():
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


class Search(NamedTuple):
    """What a search found: its hypervolume, and on unseen poses the arm that reaches most, and most at a torque."""

    hypervolume: float
    highest: Score
    within: Score
    mounting: str


def searched(case: str, seed: int, resamples: Resamples) -> Search:
    """Return a search's outcome; ``within`` takes no more than MOST_TORQUE by the search's own poses."""
    space, arms = settings_of(case).space, list(designs_of(case, seed))
    highest = max(arms, key=lambda arm: arm[1])
    within = max((arm for arm in arms if arm[2] <= MOST_TORQUE), key=lambda arm: arm[1])
    volume = hypervolume([arm[1:] for arm in arms], aims_of(("reach", "torque"), SPEC))
    score = [resamples.score(to_urdf(arm[0], space)) for arm in (highest, within)]
    return Search(volume, score[0], score[1], mounting_of(within[0]))


def mounting_of(design: Design) -> str:
    """Return how an arm's base and the middles of its joints' ranges lie."""
    said = [f"tilt {np.degrees(design.base_tilt):.0f}°"] * bool(design.base_tilt)
    said += [f"middles {'/'.join(f'{np.degrees(c):.0f}' for c in design.joint_centers)}°"] * bool(design.joint_centers)
    return ", ".join(said + [f"height {design.base_height:.2f} m"] * bool(design.base_height))


def more(differences: list[Interval]) -> str:
    """Return the mean of some searches' differences, and its 95 % interval.

    The variance is that of the mean over searches, and that of the poses, which are the same for all searches.
    """
    values = np.array([each.value for each in differences])
    n, mean = len(values), float(values.mean())
    if n < 2:
        return f"{mean:+.1f}"
    poses = np.mean([each.half for each in differences]) / stats.norm.ppf(0.975)
    half = stats.t.ppf(0.975, n - 1) * np.sqrt(values.var(ddof=1) / n + poses**2)
    return f"{mean:+.1f} [{mean - half:+.1f}, {mean + half:+.1f}]"


def table() -> None:
    """Print the best arms of the searches on unseen poses, against those of the first case."""
    resamples, first = Resamples(UNSEEN), next(iter(CASES))
    seeds = [seed for seed in range(100) if file_of(first, seed).exists()]
    base = {seed: searched(first, seed, resamples) for seed in seeds}
    print(
        "| search | seeds | hypervolume | highest reach | its torque, N m | reach more than PRRYPY's "
        f"| reach at {MOST_TORQUE:.0f} N m | more than PRRYPY's | such an arm |"
    )
    print("| --- | ---: | ---: | ---: | ---: | --- | ---: | --- | --- |")
    for case in CASES:
        found = {seed: searched(case, seed, resamples) for seed in seeds if file_of(case, seed).exists()}
        if not found:
            continue
        one = list(found.values())
        cells = [case, f"{len(one)}", f"{np.mean([each.hypervolume for each in one]):.3f}"]
        cells += [f"{np.mean([each.highest.reach for each in one]):.1f}"]
        cells += [f"{np.mean([each.highest.torque for each in one]):.0f}"]
        cells += [more([each.highest.over(base[seed].highest)[0] for seed, each in found.items()])]
        cells += [f"{np.mean([each.within.reach for each in one]):.1f}"]
        cells += [more([each.within.over(base[seed].within)[0] for seed, each in found.items()]), one[0].mounting]
        print("| " + " | ".join(cells) + " |", flush=True)


def same() -> None:
    """Print what YPPYPY of PRRYPY's best lengths reaches, laid on its side and with ranges turned one by one."""
    lengths, side = (0.0, 0.3, 0.0, 0.3, 0.0, 0.0), np.pi / 2
    space, resamples = settings_of("YPPYPY, all").space, Resamples(UNSEEN)
    base = resamples.score(to_urdf(Design("PRRYPY", lengths), DesignSpace()))
    steps = {
        "upright": (0.0, (0.0,) * 6),
        "on its side": (-side, (0.0,) * 6),
        "and the middle of joint 2 at 90°": (-side, (0.0, side, 0.0, 0.0, 0.0, 0.0)),
        "and that of joint 4 at 90°": (-side, (0.0, side, 0.0, side, 0.0, 0.0)),
    }
    print("| arm | reach | torque, N m | reach more than PRRYPY's | torque more |\n| --- | ---: | ---: | --- | --- |")
    print(f"| PRRYPY, upright | {base.reach:.1f} | {base.torque:.0f} | | |")
    for name, (tilt, centers) in steps.items():
        score = resamples.score(to_urdf(Design("YPPYPY", lengths, 0.0, tilt, centers), space))
        reach, torque, *_ = score.over(base)
        print(f"| YPPYPY, {name} | {score.reach:.1f} | {score.torque:.0f} | {text_of(reach)} | {text_of(torque)} |")


def text_of(interval: Interval) -> str:
    """Return a value and its 95 % interval."""
    return f"{interval.value:+.1f} [{interval.low:+.1f}, {interval.high:+.1f}]"


def main() -> None:
    """Run as a script."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["bound", "run", "table", "same"])
    parser.add_argument("--trials", type=int, default=1000, help="of a search [1000]")
    parser.add_argument("--seeds", type=int, nargs="+", default=[0], help="of the searches, below 100 [0]")
    parser.add_argument("--cases", nargs="+", choices=list(CASES), default=list(CASES), metavar="CASE", help="[all]")
    args = parser.parse_args()
    FOLDER.mkdir(parents=True, exist_ok=True)
    if args.what == "bound":
        bound(args.trials)
    elif args.what == "run":
        for seed in args.seeds:
            for case in args.cases:
                run(settings_of(case, seed), args.trials, file_of(case, seed))
    elif args.what == "table":
        table()
    else:
        same()


if __name__ == "__main__":
    main()
