"""Search every joint order by itself for long, by another algorithm than the sampler `structured`, as a measure of it.

Each order gets a genetic search of its own (NSGA-II: Deb et al. 2002, with differential evolution's moves), whatever
the others are worth. Finished orders are kept one a file, so that it can be stopped and gone on with; at the
end, or with `--workers 0`, the fronts of those finished join those of one .npz file, which fairness.py and studies.py
read and whose orders are not searched again.
Which order is next is drawn at random, so that those finished are a fair sample. Best reach and front are lower bounds
of what an order can do.
"""

from __future__ import annotations

import argparse
import multiprocessing
import time
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from mobo_core.design import DesignSpace
from mobo_core.design.joints import effective_orders
from mobo_core.design.prepared import PreparedXacro
from mobo_core.evaluation import load_spec
from mobo_core.evaluation.evaluate import evaluate
from mobo_core.search.front import aims_of, pareto_front

FOLDER, FILE = Path("bags/long_search"), Path(__file__).with_suffix(".npz")
SPACE = DesignSpace()
SPEC = load_spec("mobo").model_copy(update={"rules": 2})  # fixed, so that results stay comparable
ORDERS = list(effective_orders(SPACE.n_joints, SPACE.letters))
POPULATION, FIRST = 60, 200
Array = np.ndarray[Any, Any]
Value = Callable[[str, Array], tuple[float, float]]


def anywhere(rng: np.random.Generator) -> Array:
    """Return lengths in m drawn evenly from those that may be, some of them zero."""
    n = SPACE.n_joints
    return settled(rng.exponential(size=n) * (rng.random(n) > rng.choice([0.0, 0.2, 0.4])))


def settled(lengths: Array) -> Array:
    """Return lengths put to what the space allows, those below 2 mm to zero."""
    total, most = SPACE.total_ends[1], np.full(len(lengths), SPACE.max_length)
    most[-1] = total
    found = np.clip(np.where(lengths < 2e-3, 0.0, lengths), 0.0, most)
    for _ in range(20):
        if not (room := (found > 0) & ((found < most) | (found.sum() > total))).any():
            found[0], room = 1e-3, np.arange(len(found)) == 0
        found[room] *= max(0.0, 1 + (total - found.sum()) / found[room].sum())
        found = np.minimum(found, most)
    return np.array(SPACE.links.settled(found.tolist(), total))


def ranked(values: Array) -> Array:
    """Return the arms from the best to the worst: by front, and in a front by how lonely they are, its ends first."""
    aims, left, order = aims_of(("reach", "torque"), SPEC), list(range(len(values))), []
    while left:
        front = [left[i] for i in pareto_front(values[left].tolist(), aims)]  # ascending in reach
        reach, torque = values[front].T
        lonely = np.full(len(front), np.inf)
        spans = max(np.ptp(reach), 1e-9), max(np.ptp(torque), 1e-9)
        lonely[1:-1] = (reach[2:] - reach[:-2]) / spans[0] + (torque[2:] - torque[:-2]) / spans[1]
        order += [front[i] for i in np.argsort(-lonely, kind="stable")]
        gone = set(front)
        left = [i for i in left if i not in gone]
    return np.array(order)


def bred(rng: np.random.Generator, arms: Array) -> Array:
    """Return the lengths of an arm bred from some, the best first."""
    a, b = (min(rng.integers(len(arms), size=2)) for _ in "ab")
    lengths = arms[a].copy()
    way = rng.random()
    if way < 0.4:
        c, d = rng.integers(len(arms), size=2)
        lengths += rng.uniform(0.2, 0.9) * (arms[c] - arms[d])
    elif way < 0.6:
        lengths += rng.uniform(-0.2, 1.2) * (arms[b] - arms[a])
    elif way < 0.8:
        lengths += rng.normal(size=len(lengths)) * rng.choice([0.003, 0.01, 0.03, 0.08]) * (rng.random(6) < 0.5)
    else:
        i, j = rng.permutation(len(lengths))[:2]
        share = rng.choice([1.0, rng.random()])
        lengths[j] += share * lengths[i]
        lengths[i] -= share * lengths[i]
    return settled(np.maximum(lengths, 0.0))


def search(order: str, evaluations: int, value: Value, seed: int = 0) -> tuple[Array, Array]:
    """Return the arms of an order's front, lengths in m (k, n), and reach and torque in N m (k, 2)."""
    rng = np.random.default_rng([seed, zlib.crc32(order.encode())])
    arms = np.array([anywhere(rng) for _ in range(min(FIRST, evaluations))])
    values = np.array([value(order, lengths) for lengths in arms])
    done = len(arms)
    while True:
        best = ranked(values)[: max(POPULATION, len(pareto_front(values.tolist(), aims_of(("reach", "torque"), SPEC))))]
        arms, values = arms[best], values[best]
        if done >= evaluations:
            front = pareto_front(values.tolist(), aims_of(("reach", "torque"), SPEC))
            return arms[front], values[front]
        count = min(POPULATION // 2, evaluations - done)
        new = np.array([bred(rng, arms[:POPULATION]) for _ in range(count)])
        arms, values = np.vstack([arms, new]), np.vstack([values, [value(order, lengths) for lengths in new]])
        done += count


def _value(order: str, lengths: Array) -> tuple[float, float]:
    result = evaluate(XACRO.to_urdf(SPACE.arm(order, lengths.tolist())), SPEC)
    return result.reach, result.torque


XACRO = PreparedXacro(SPACE)


def _one(task: tuple[str, int, Path]) -> str:
    order, evaluations, file = task
    began = time.perf_counter()
    tried: list[tuple[float, ...]] = []  # lengths, reach, torque

    def value(order: str, lengths: Array) -> tuple[float, float]:
        found = _value(order, lengths)
        tried.append((*lengths.tolist(), *found))
        return found

    lengths, values = search(order, evaluations, value)
    part = file.with_suffix(".part.npz")
    np.savez(part, lengths=lengths, values=values, evaluations=evaluations, tried=np.array(tried))
    part.rename(file)
    return f"{order}: reach {values[-1, 0]:.1f}, {len(values)} arms, {time.perf_counter() - began:.0f} s"


def finished(file: Path) -> dict[str, dict[str, Array]]:
    """Return lengths, values and evaluations of the orders that a file of fronts holds."""
    if not file.exists():
        return {}
    with np.load(file) as stored:
        held = {name: stored[name] for name in stored.files}
    orders = np.unique(held["order"])  # as `join` sorts them
    parts = {}
    for order, evaluations in zip(orders.tolist(), held["evaluations"], strict=True):
        of_order = held["order"] == order
        parts[order] = {name: held[name][of_order] for name in ("lengths", "values")} | {"evaluations": evaluations}
    return parts


def join(folder: Path, file: Path) -> None:
    """Add the fronts of all orders that are finished to a file's."""
    parts = finished(file) | {each.stem: dict(np.load(each)) for each in folder.glob("[A-Z]*[A-Z].npz")}
    parts = dict(sorted(parts.items()))
    np.savez_compressed(
        file,
        order=np.repeat(list(parts), [len(part["values"]) for part in parts.values()]),
        lengths=np.concatenate([part["lengths"] for part in parts.values()]),
        values=np.concatenate([part["values"] for part in parts.values()]),
        evaluations=np.array([int(part["evaluations"]) for part in parts.values()]),
    )


def main() -> None:
    """Search what is not searched yet, and join all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", type=Path, default=FOLDER, help="of finished orders")
    parser.add_argument("--evaluations", type=int, default=2000, help="of arms, an order")
    parser.add_argument("--orders", nargs="*", help="some of them; all by default")
    parser.add_argument("--workers", type=int, default=2, help="processes; 0 to join what is finished and no more")
    parser.add_argument("-o", "--output", type=Path, default=FILE, help=".npz file")
    args = parser.parse_args()
    args.folder.mkdir(parents=True, exist_ok=True)
    there = finished(args.output)
    orders = args.orders or np.random.default_rng(0).permutation(ORDERS).tolist()
    tasks = [(order, args.evaluations, args.folder / f"{order}.npz") for order in orders]
    tasks = [task for task in tasks if not (task[2].exists() or task[0] in there)]
    if args.workers:
        with multiprocessing.get_context("spawn").Pool(args.workers) as pool:
            for i, line in enumerate(pool.imap_unordered(_one, tasks), start=1):
                print(f"{i}/{len(tasks)} {line}", flush=True)
    join(args.folder, args.output)


if __name__ == "__main__":
    main()
