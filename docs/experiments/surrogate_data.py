"""Evaluate tens of thousands of arms of the kinds that searches visit, from which surrogate.py learns (see search.md).

Chunk after chunk goes to a folder; what is there already is not made again, so that it can be stopped at any time.
"""

from __future__ import annotations

import argparse
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import optuna

from mobo_core.design import Design, DesignSpace
from mobo_core.design.prepared import PreparedXacro
from mobo_core.evaluation import load_spec
from mobo_core.evaluation.evaluate import evaluate
from mobo_core.search.front import aims_of, pareto_front

FOLDER = Path("bags/surrogate")
SPACE, SPEC = DesignSpace(), load_spec("paper")
XACRO = PreparedXacro(SPACE)
CHUNK = 1000
KINDS = ("random", "tpe", "bred", "nsga2", "bred")  # of chunks, in turn
FRONTS = 30  # Pareto fronts, peeled one by one, that arms are bred from
OF_STRUCTURE = 8  # best arms of a structure that arms are bred from
Array = np.ndarray[Any, Any]
Values = Callable[[Design], tuple[float, float]]


class Chunk:
    """Arms evaluated, as columns.

    Attributes:
        joints: sampled joint orders.
        u: fractions in [0, 1], shape (5,) each.
        reached: poses reached in each voxel, shape (75,) each.
        voxel_torque: N m, shape (75,) each.
        reach, torque: as `mobo evaluate` has them; torque in N m.
    """

    def __init__(self) -> None:
        self.columns: dict[str, list[Any]] = {
            name: [] for name in ("joints", "u", "reached", "voxel_torque", "reach", "torque")
        }

    def evaluate(self, joints: str, u: tuple[float, ...]) -> tuple[float, float]:
        """Evaluate an arm for real and keep it; return reach and torque (N m)."""
        result = evaluate(XACRO.to_urdf(arm(joints, u)), SPEC)
        reached = np.round(result.voxel_reach * SPEC.poses_per_voxel).astype(np.uint8)
        row = (joints, u, reached, result.voxel_torque.astype(np.float32), result.reach, result.torque)
        for column, value in zip(self.columns.values(), row, strict=True):
            column.append(value)
        return result.reach, result.torque

    def save(self, file: Path) -> None:
        """Write all columns to an .npz file, all or nothing."""
        part = file.with_suffix(".part.npz")
        np.savez_compressed(part, **{name: np.array(column) for name, column in self.columns.items()})
        part.rename(file)


def arm(joints: str, u: tuple[float, ...]) -> Design:
    """Return the arm of a sampled joint order and fractions."""
    return SPACE.design({f"J{i + 1}": j for i, j in enumerate(joints)} | {f"u{i + 1}": x for i, x in enumerate(u)})


def load(files: list[Path]) -> dict[str, Array]:
    """Return the columns of some chunks joined, and in ``chunk`` the number of the chunk of each arm."""
    chunks = [dict(np.load(file)) for file in files]
    numbers = [np.full(len(chunk["reach"]), int(file.stem[:3])) for file, chunk in zip(files, chunks, strict=True)]
    return {name: np.concatenate([c[name] for c in chunks]) for name in chunks[0]} | {"chunk": np.concatenate(numbers)}


def _study(sampler: optuna.samplers.BaseSampler, chunk: Chunk) -> None:
    def value(trial: optuna.Trial) -> tuple[float, float]:
        design = SPACE.suggest(trial)
        return chunk.evaluate(design.sampled_joints, tuple(trial.params[f"u{i + 1}"] for i in range(5)))

    optuna.create_study(directions=["maximize", "minimize"], sampler=sampler).optimize(value, n_trials=CHUNK)


def _random(rng: np.random.Generator) -> tuple[str, Array]:
    return "".join(rng.choice(list("RPY"), 6)), rng.random(5)


def _parents(past: dict[str, Array]) -> tuple[list[int], dict[str, list[int]]]:
    """Return the arms of the first fronts of all, and of each structure the ones of its first fronts."""
    structures: dict[str, list[int]] = {}
    for i, joints in enumerate(past["joints"]):
        structures.setdefault(Design(str(joints), (0.1,) * 6).joints, []).append(i)
    best = {name: list(_peel(members, past, most=OF_STRUCTURE)) for name, members in structures.items()}
    return list(_peel(list(range(len(past["reach"]))), past, fronts=FRONTS)), best


def _peel(members: list[int], past: dict[str, Array], most: int = 10**9, fronts: int = 10**9) -> Iterator[int]:
    """Yield arms front by front."""
    values, aims = np.stack([past["reach"], past["torque"]], axis=1), aims_of(("reach", "torque"), SPEC)
    while members and most > 0 and fronts > 0:
        front = [members[i] for i in pareto_front(values[members].tolist(), aims)]
        yield from front[:most]
        most, fronts = most - len(front), fronts - 1
        gone = set(front)
        members = [i for i in members if i not in gone]


def _bred(rng: np.random.Generator, past: dict[str, Array], fronts: list[int], best: dict[str, list[int]]) -> Any:
    """Return an arm near a good one: half of the time good among all, else good for its structure."""
    names = list(best)

    def parent() -> int:
        members = fronts if rng.random() < 0.5 else best[names[rng.integers(len(names))]]
        return int(members[rng.integers(len(members))])

    a = parent()
    joints, u = list(str(past["joints"][a])), past["u"][a].copy()
    if rng.random() < 0.3:
        other = parent()
        if rng.random() < 0.5:
            joints = list(str(past["joints"][other]))
        taken = rng.random(5) < 0.5
        u[taken] = past["u"][other][taken]
    if rng.random() < 0.4:
        joints[rng.integers(6)] = rng.choice(list("RPY"))
    for i in range(5):
        chance = rng.random()
        if chance < 0.4:
            u[i] = np.clip(u[i] + rng.normal(0, rng.choice([0.03, 0.1, 0.25])), 0, 1)
        elif chance < 0.5:
            u[i] = rng.choice([0.0, 1.0, rng.random(), 0.1 * rng.random(), 1 - 0.1 * rng.random()])
    return "".join(joints), u


def make(number: int, folder: Path) -> Chunk:
    """Evaluate the arms of one chunk: a function of its number and of the chunks before it."""
    chunk, kind = Chunk(), KINDS[number % len(KINDS)]
    rng = np.random.default_rng(number)
    if kind == "tpe":
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            _study(optuna.samplers.TPESampler(multivariate=True, n_startup_trials=100, seed=number), chunk)
    elif kind == "nsga2":
        _study(optuna.samplers.NSGAIISampler(population_size=40, seed=number), chunk)
    elif kind == "random":
        for _ in range(CHUNK):
            joints, u = _random(rng)
            chunk.evaluate(joints, tuple(u))
    else:
        past = load(sorted(folder.glob("[0-9][0-9][0-9].npz"))[:number])
        fronts, best = _parents(past)
        for _ in range(CHUNK):
            joints, u = _bred(rng, past, fronts, best)
            chunk.evaluate(joints, tuple(u))
    return chunk


def main() -> None:
    """Make the chunks that are missing."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", type=Path, default=FOLDER)
    parser.add_argument("--chunks", type=int, default=40, help=f"of {CHUNK} arms each")
    args = parser.parse_args()
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    args.folder.mkdir(parents=True, exist_ok=True)
    for number in range(args.chunks):
        file = args.folder / f"{number:03}.npz"
        if not file.exists():
            began = time.perf_counter()
            make(number, args.folder).save(file)
            print(f"{file.name}: {KINDS[number % len(KINDS)]}, {time.perf_counter() - began:.0f} s", flush=True)


if __name__ == "__main__":
    main()
