"""Compare searches by the hypervolume after equal trials, on the surrogate of surrogate.py (see search.md).

Each run (a method and a seed) is kept in a file, so that it can be stopped and gone on with; `tables` prints Markdown
from the summary that is committed beside this script.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import Any

import numpy as np
from search_methods import METHODS, Value
from surrogate import Surrogate
from surrogate_data import FOLDER, SPEC, XACRO

from mobo_core.design import Design
from mobo_core.evaluation.evaluate import evaluate
from mobo_core.search.front import aims_of, hypervolume, pareto_front

SUMMARY = Path(__file__).with_suffix(".json")
IN_FLIGHT = "mobo tpe, in_flight "
AIMS = aims_of(("reach", "torque"), SPEC)
CHECKPOINTS = (200, 500, 1000, 3000, 10000, 20000)


def run(method: str, seed: int, n_trials: int, value: Value, file: Path) -> dict[str, Any]:
    """Run one search; write hypervolumes at the checkpoints, seconds a trial, and the arms of the front to a file.

    At every checkpoint what is known by then goes to a file ending in .part.
    """
    reach: list[float] = []
    torque: list[float] = []
    arms: list[Design] = []
    result: dict[str, Any] = {"method": method, "seed": seed, "trials": n_trials, "hypervolume": {}}
    part = file.with_suffix(".part")
    began = time.process_time()
    for design, values in METHODS[method](seed, n_trials, value):
        arms.append(design)
        reach.append(values[0])
        torque.append(values[1])
        done = len(reach)
        if done in CHECKPOINTS or done == n_trials:
            result["hypervolume"][str(done)] = hypervolume(list(zip(reach, torque, strict=True)), AIMS)
            result["ms_a_trial"] = 1e3 * (time.process_time() - began) / done
            result["front"] = [
                [arms[i].sampled_joints, arms[i].lengths, reach[i], torque[i]]
                for i in pareto_front(list(zip(reach, torque, strict=True)), AIMS)
            ]
            part.write_text(json.dumps(result))
    part.rename(file)
    return result


def real_value(design: Design) -> tuple[float, float]:
    """Return reach and torque (N m) by the evaluation itself."""
    result = evaluate(XACRO.to_urdf(design), SPEC)
    return result.reach, result.torque


def surrogate_value(folder: Path) -> Value:
    """Return reach and torque (N m) by the surrogate."""
    surrogate = Surrogate(folder / "weights.npz")
    return lambda design: surrogate(design.joints, design.lengths)


def run_all(args: argparse.Namespace) -> None:
    """Run what is missing and keep it."""
    runs = args.folder / "runs"
    runs.mkdir(parents=True, exist_ok=True)
    value = surrogate_value(args.folder)
    for seed in args.seeds:
        for method in args.methods or METHODS:
            file = runs / f"{method.replace(' ', '_')}__{args.trials}__{seed}.json"
            if not file.exists():
                result = run(method, seed, args.trials, value, file)
                values = ", ".join(f"{n}: {v:.4f}" for n, v in result["hypervolume"].items())
                print(f"{method}, seed {seed}: {values}; {result['ms_a_trial']:.1f} ms a trial", flush=True)


def summarise(args: argparse.Namespace) -> None:
    """Join all runs into the summary: per method, checkpoint and seed the hypervolume."""
    summary: dict[str, Any] = {}
    for file in sorted((args.folder / "runs").glob("*.json")):
        result = json.loads(file.read_text())
        row = summary.setdefault(result["method"], {"hypervolume": {}, "ms_a_trial": {}})
        for n, found in result["hypervolume"].items():
            row["hypervolume"].setdefault(n, {})[str(result["seed"])] = round(found, 5)
        times = row["ms_a_trial"].setdefault(str(result["trials"]), [])
        times.append(round(result["ms_a_trial"], 2))
    SUMMARY.write_text(json.dumps(summary, indent=0, sort_keys=True) + "\n")


def check(args: argparse.Namespace) -> None:
    """Evaluate the arms of the fronts for real, and print how far off the surrogate was."""
    print("| method | arms | reach: mean error | MAE | torque, N m: mean error | MAE | hypervolume: surrogate | real |")
    print("| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |")
    by_method: dict[str, list[dict[str, Any]]] = {}
    for file in sorted((args.folder / "runs").glob("*.json")):
        result = json.loads(file.read_text())
        if (not args.methods or result["method"] in args.methods) and result["seed"] in args.seeds:
            by_method.setdefault(result["method"], []).append(result)
    for method, results in by_method.items():
        errors, volumes = [], []
        for result in results:
            predicted = np.array([row[2:] for row in result["front"]])
            real = np.array([real_value(Design(row[0], tuple(row[1]))) for row in result["front"]])
            errors.append(predicted - real)
            volumes.append([hypervolume(values.tolist(), AIMS) for values in (predicted, real)])
        error, volume = np.concatenate(errors), np.mean(volumes, axis=0)
        mean, mae = error.mean(axis=0), np.abs(error).mean(axis=0)
        print(f"| {method} | {len(error)} | {mean[0]:+.2f} | {mae[0]:.2f} | {mean[1]:+.1f} | {mae[1]:.1f} | "
              f"{volume[0]:.4f} | {volume[1]:.4f} |", flush=True)  # fmt: skip


def interval(values: list[float]) -> tuple[float, float]:
    """Return the mean and half the width of its 95 % interval (Student's t); no width below three values."""
    from scipy import stats

    if len(values) < 3:
        return float(np.mean(values)), float("nan")
    half = stats.t.ppf(0.975, len(values) - 1) * np.std(values, ddof=1) / np.sqrt(len(values))
    return float(np.mean(values)), float(half)


def tables(_: argparse.Namespace) -> None:
    """Print the tables from the summary: of numbers in flight, and of methods.

    Methods of fewer than five seeds say little, and are left out.
    """
    summary = json.loads(SUMMARY.read_text())
    summary = {name: row for name, row in summary.items() if min(map(len, row["hypervolume"].values())) >= 5}
    flight = {name: row for name, row in summary.items() if name.startswith(IN_FLIGHT)}
    _table(flight, base=f"{IN_FLIGHT}1")
    others = [f"{IN_FLIGHT}1", f"{IN_FLIGHT}8", *(name for name in summary if name not in flight)]
    _table({name: summary[name] for name in others}, base=f"{IN_FLIGHT}8")


def _table(methods: dict[str, Any], base: str) -> None:
    """Print a row a method, the best first; the difference to ``base`` is at the last checkpoint, seed by seed."""
    points = sorted({int(n) for row in methods.values() for n in row["hypervolume"]})
    last = str(points[-1])

    def at(method: str, n: str) -> dict[str, float]:
        return dict(methods[method]["hypervolume"].get(n, {}))

    head = [f"{n:,} trials" for n in points] + [f"difference to {base}", "ms a trial"]
    print("\n| method | seeds | " + " | ".join(head) + " |\n| --- | ---: |" + " ---: |" * len(head))
    for method in sorted(methods, key=lambda m: -float(np.mean(list(at(m, last).values()) or [0.0]))):
        cells = [_cell(list(at(method, str(n)).values())) for n in points]
        mine, theirs = at(method, last), at(base, last)
        cells.append(_cell([mine[s] - theirs[s] for s in mine if s in theirs], "+") if method != base else "")
        times = [ms for of in methods[method]["ms_a_trial"].values() for ms in of]
        seeds = max(len(found) for found in methods[method]["hypervolume"].values())
        print(f"| {method} | {seeds} | " + " | ".join(cells) + f" | {np.median(times):.1f} |")


def _cell(values: list[float], sign: str = "") -> str:
    mean, half = interval(values) if values else (float("nan"), float("nan"))
    return "–" if np.isnan(mean) else f"{mean:{sign}.4f}" + ("" if np.isnan(half) else f" ± {half:.4f}")


def main() -> None:
    """Run, check, summarise or print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=("run", "check", "summarise", "tables"))
    parser.add_argument("--folder", type=Path, default=FOLDER)
    parser.add_argument("--methods", nargs="*", help="by name; all if none is given")
    parser.add_argument("--seeds", type=int, nargs="*", default=list(range(10)))
    parser.add_argument("--trials", type=int, default=3000)
    args = parser.parse_args()
    {"run": run_all, "check": check, "summarise": summarise, "tables": tables}[args.what](args)


if __name__ == "__main__":
    main()
