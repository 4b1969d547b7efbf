"""Run studies on the evaluation itself, and print what search.md compares samplers by.

    python docs/experiments/studies.py run --samplers structured tpe como --trials 3000
    python docs/experiments/studies.py run --samplers structured tpe --seeds 0 --trials 20000
    python docs/experiments/studies.py alone --samplers structured structured:1 --trials 250
    python docs/experiments/studies.py tables

`structured:1` is that sampler by its earlier rules. A study is kept trial by trial, so that it can be stopped, gone on
with, and made longer. `tables` prints which arms the studies found (hypervolumes, how the arms on the fronts do on
poses that no study saw) and what they say of the structures, against long_search.npz. `alone` searches single orders.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from fairness import FILE, HEADINGS, LEAST_REACH, long_searches, row
from scipy import stats

import mobo_core as mobo
from mobo_core.design import Design, DesignSpace
from mobo_core.design.prepared import PreparedXacro
from mobo_core.evaluation import EvaluationSpec, load_spec
from mobo_core.evaluation.evaluate import evaluate
from mobo_core.search.front import aims_of, hypervolume, pareto_front
from mobo_core.search.study import OrderedStudy, Told

FOLDER = Path("bags/studies")
SPEC = load_spec("mobo").model_copy(update={"rules": 2})  # fixed, so that results stay comparable
UNSEEN = SPEC.model_copy(update={"seed": 1})
AIMS = aims_of(("reach", "torque"), SPEC)
IN_FLIGHT = {"como": 1}  # of others 8
CONFIDENCE = 0.9
ALONE = (16, 32, 64, 84, 125, 250)
Values = list[tuple[float, float]]


class Row(NamedTuple):
    """A trial: sampled and effective joints, lengths in m, and reach and torque in N m."""

    sampled_joints: str
    joints: str
    lengths: tuple[float, ...]
    reach: float
    torque: float
    complete: bool = True


def settings_of(sampler: str, seed: int, joints: int) -> mobo.StudySettings:
    """Return a study's settings; after a colon the sampler's rules, by default the latest."""
    space, in_flight = DesignSpace(n_joints=joints), IN_FLIGHT.get(sampler, 8)
    name, _, rules = sampler.partition(":")
    given = {"sampler": name, "sampler_rules": int(rules or 0), "seed": seed, "in_flight": in_flight}
    return mobo.StudySettings(space=space, spec=SPEC, **given)


def run(settings: mobo.StudySettings, trials: int, file: Path) -> None:
    """Go on with a study up to a number of trials, a line of its file each: parameters, reach and torque."""
    study, xacro = OrderedStudy(settings), PreparedXacro(settings.space)
    known = [json.loads(line) for line in _whole_lines(file)]
    began, last = time.process_time(), 0.0
    with file.open("a", encoding="utf-8") as out:
        while len(study.told) < trials:
            number = len(study.asked)
            if number < trials and study.may_ask():
                if number < len(known):
                    study.recall(known[number][0])
                else:
                    study.ask()
                continue
            number = len(study.told)
            if number < len(known):
                values = tuple(known[number][1])
            else:
                result = evaluate(xacro.to_urdf(study.asked[number].design), settings.spec)
                values = result.reach, result.torque
                print(json.dumps([study.asked[number].params, values]), file=out)
            study.tell(Told(number, values))
            if time.perf_counter() - last > 2:
                last = time.perf_counter()
                print(f"{file.stem}: {number:,} of {trials:,}", end="\r", flush=True)
    seconds, new = time.process_time() - began, trials - len(known)
    print(f"{file.stem}: {trials:,} trials, {seconds:.0f} s of CPU for {new:,} of them", flush=True)


def _whole_lines(file: Path) -> list[str]:
    """Return a file's lines; what was left of one that was not finished is cut off."""
    text = file.read_text(encoding="utf-8") if file.exists() else ""
    whole = text[: text.rfind("\n") + 1]
    if len(whole) < len(text):
        file.write_text(whole, encoding="utf-8")
    return whole.splitlines()


def rows_of(file: Path, space: DesignSpace) -> list[Row]:
    """Return the trials of a study."""
    rows = []
    for line in _whole_lines(file):
        params, (reach, torque) = json.loads(line)
        design = space.design(params)
        rows.append(Row(design.sampled_joints, design.joints, design.lengths, reach, torque))
    return rows


def studies(folder: Path, joints: int) -> Iterator[tuple[str, mobo.StudySettings, list[Row]]]:
    """Yield sampler, settings and trials of a folder's studies, by sampler and seed."""
    for file in sorted(folder.glob(f"*_{joints}_*.jsonl")):
        sampler, _, seed = file.stem.split("_")
        settings = settings_of(sampler, int(seed), joints)
        yield sampler, settings, rows_of(file, settings.space)


def unseen(rows: list[Row], space: DesignSpace, spec: EvaluationSpec = UNSEEN) -> tuple[float, float]:
    """Return by how much the reach of a front's arms is lower on unseen poses, mean; and their hypervolume there."""
    front = [rows[i] for i in pareto_front([(r.reach, r.torque) for r in rows], AIMS)]
    results = [evaluate(Design(r.sampled_joints, r.lengths), spec, space=space) for r in front]
    lower = [r.reach - result.reach for r, result in zip(front, results, strict=True)]
    return float(np.mean(lower)), hypervolume([(result.reach, result.torque) for result in results], AIMS)


def which_arms(folder: Path, joints: int, counts: list[int], base: str) -> None:
    """Print hypervolumes, a row for each sampler and number of trials, and how the fronts do on unseen poses."""
    volumes: dict[int, dict[str, list[float]]] = {count: {} for count in counts}
    again: dict[tuple[int, str], list[tuple[float, float]]] = {}
    for sampler, settings, rows in studies(folder, joints):
        for count in (count for count in counts if count <= len(rows)):
            values = [(r.reach, r.torque) for r in rows[:count]]
            volumes[count].setdefault(sampler, []).append(hypervolume(values, AIMS))
            again.setdefault((count, sampler), []).append(unseen(rows[:count], settings.space))
    print(
        f"| trials | sampler | studies | hypervolume | lowest – highest | ahead of {base}, {CONFIDENCE:.0%} interval "
        "| on unseen poses | reach of the front's arms lower there |"
    )
    print("| ---: | --- | ---: | ---: | ---: | ---: | ---: | ---: |")
    for count in counts:
        for sampler, found in volumes[count].items():
            lower, there = np.mean(again[count, sampler], axis=0)
            ahead = "" if sampler == base else _ahead(found, volumes[count].get(base, []))
            cells = [f"{count:,}", sampler, f"{len(found)}", f"{np.mean(found):.4f}"]
            cells += [f"{min(found):.4f} – {max(found):.4f}", ahead, f"{there:.4f}", f"{lower:.2f}"]
            print("| " + " | ".join(cells) + " |", flush=True)


def _ahead(found: list[float], others: list[float]) -> str:
    """Return the difference of the means, with its interval (Welch's t) if there are studies enough."""
    if not others:
        return "–"
    mean = np.mean(found) - np.mean(others)
    if min(len(found), len(others)) < 2:
        return f"{mean:+.4f}"
    low, high = stats.ttest_ind(found, others, equal_var=False).confidence_interval(CONFIDENCE)
    return f"{mean:+.4f} [{low:+.4f}, {high:+.4f}]"


def which_structures(folder: Path, joints: int, counts: list[int], long: Path) -> None:
    """Print what the studies say of every order, against the long searches if there are any of so many joints."""
    searched = long_searches(long, SPEC) if joints == DesignSpace().n_joints and long.exists() else {}
    print("\n| sampler, seed | trials | " + " | ".join(HEADINGS[3:]) + " |")
    print("| --- |" + " ---: |" * (len(HEADINGS) - 2))
    for sampler, settings, rows in studies(folder, joints):
        for count in (count for count in counts if count <= len(rows)):
            cells = row(rows[:count], settings, searched)
            print(f"| {sampler}, {settings.seed} | {count:,} | " + " | ".join(cells) + " |", flush=True)


def alone(folder: Path, samplers: list[str], trials: int, long: Path, orders: list[str]) -> None:
    """Search single orders, and print how their best reach and hypervolume fall short of the long searches', mean."""
    counts = [count for count in ALONE if count <= trials]
    searched = {order: found for order, found in long_searches(long, SPEC).items() if found.reach >= LEAST_REACH}
    orders = orders or list(searched)
    print("| sampler | short of, mean | " + " | ".join(f"{count} arms" for count in counts) + " | within 1.5, 0.015 |")
    print("| --- | --- |" + " ---: |" * (len(counts) + 1))
    for sampler in samplers:
        short = np.empty((2, len(orders), len(counts)))
        for i, order in enumerate(orders):
            file, space = folder / f"{sampler}_{order}.jsonl", DesignSpace.of({"joints": list(order)})
            run(settings_of(sampler, 0, 6).model_copy(update={"space": space}), trials, file)
            values = [(r.reach, r.torque) for r in rows_of(file, space)]
            for j, count in enumerate(counts):
                short[0, i, j] = searched[order].reach - max(reach for reach, _ in values[:count])
                short[1, i, j] = searched[order].volume - hypervolume(values[:count], AIMS)
        for what, found, most in (("reach", short[0], 1.5), ("hypervolume", short[1], 0.015)):
            cells = [f"{mean:.4f}" for mean in found.mean(axis=0)] + [
                f"{(found[:, -1] <= most).sum()} of {len(orders)}"
            ]
            print(f"| {sampler} | {what} | " + " | ".join(cells) + " |")


def main() -> None:
    """Run what is missing, or print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("run", "alone", "tables"))
    parser.add_argument("--folder", type=Path, default=FOLDER)
    parser.add_argument("--samplers", nargs="*", default=["structured", "tpe"])
    parser.add_argument("--seeds", type=int, nargs="*", default=list(range(5)))
    parser.add_argument("--joints", type=int, default=6)
    parser.add_argument("--trials", type=int, nargs="*", default=[3000, 20000, 60000], help="of `run` the last")
    parser.add_argument("--base", default="tpe", help="the sampler that others are compared with")
    parser.add_argument("--long", type=Path, default=FILE, help="file of long_search.py")
    parser.add_argument("--orders", nargs="*", default=[], help="of `alone`; all of the long searches by default")
    args = parser.parse_args()
    (args.folder / "alone").mkdir(parents=True, exist_ok=True)
    if args.what == "run":
        for seed in args.seeds:
            for sampler in args.samplers:
                file = args.folder / f"{sampler}_{args.joints}_{seed}.jsonl"
                run(settings_of(sampler, seed, args.joints), args.trials[-1], file)
    elif args.what == "alone":
        alone(args.folder / "alone", args.samplers, args.trials[-1], args.long, args.orders)
    else:
        which_arms(args.folder, args.joints, args.trials, args.base)
        which_structures(args.folder, args.joints, args.trials, args.long)


if __name__ == "__main__":
    main()
