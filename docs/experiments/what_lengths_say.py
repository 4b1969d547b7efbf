"""How far an order's arms tell of its others, and one order of another: what the sampler `structured` rests on.

Prints the share of the variance of reach and torque that a Gaussian process explains, by the number of arms it knows,
with lengths as square roots of shares or as they are; and how far the reach of arms of equal lengths differs between
orders. Arms are drawn at random (docs/experiments/long_search.py).
"""

from __future__ import annotations

import argparse
import itertools
from typing import Any

import numpy as np
from long_search import SPACE, SPEC, XACRO, anywhere

from mobo_core.design.joints import effective_orders
from mobo_core.evaluation.evaluate import evaluate
from mobo_core.search.samplers.structured.model import WIDE
from mobo_core.search.samplers.structured.orders import twins

HELD_OUT = 60
SCALE, NOISE = WIDE
Array = np.ndarray[Any, Any]


def values_of(order: str, arms: Array) -> Array:
    """Return reach and torque (N m) of arms of one order, (k, 2)."""
    results = [evaluate(XACRO.to_urdf(SPACE.arm(order, lengths.tolist())), SPEC) for lengths in arms]
    return np.array([[result.reach, result.torque] for result in results])


def kernel(a: Array, b: Array) -> Array:
    """Return the sampler's kernel between points (k, d) and (l, d)."""
    r = np.sqrt(5) * np.linalg.norm(a[:, None] - b[None], axis=2) / SCALE
    return np.asarray((1 + r + r * r / 3) * np.exp(-r))


def explained(z: Array, y: Array, known: int) -> float:
    """Return the share of the variance of the last values that the first ``known`` explain."""
    middle = y[:known].mean()
    weights = np.linalg.solve(kernel(z[:known], z[:known]) + NOISE * np.eye(known), y[:known] - middle)
    errors = y[-HELD_OUT:] - middle - kernel(z[-HELD_OUT:], z[:known]) @ weights
    return 1.0 - float(np.mean(errors**2) / np.var(y[-HELD_OUT:]))


def main() -> None:
    """Evaluate and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--orders", type=int, default=12, help="drawn at random, of those whose reach varies")
    parser.add_argument("--shared", type=int, default=10, help="arms of equal lengths in every order")
    args = parser.parse_args()
    rng, orders = np.random.default_rng(0), list(effective_orders(SPACE.n_joints, SPACE.letters))
    counts = (12, 24, 48, 84)
    rows: dict[tuple[str, str], list[list[float]]] = {}
    found = 0
    for i in rng.permutation(len(orders)):
        arms = np.array([anywhere(rng) for _ in range(max(counts) + HELD_OUT)])
        values = values_of(orders[i], arms)
        if values[-HELD_OUT:, 0].std() < 1.0:
            continue
        shares = arms / arms.sum(axis=1, keepdims=True)
        for k, what in enumerate(("reach", "torque")):
            for name, z in (("square roots", np.sqrt(shares)), ("lengths", shares)):
                rows.setdefault((what, name), []).append([explained(z, values[:, k], known) for known in counts])
        if (found := found + 1) == args.orders:
            break
    print("| explained | " + " | ".join(f"{known} arms" for known in counts) + " |\n| --- |" + " ---: |" * len(counts))
    for (what, name), shares_of in rows.items():
        print(f"| {what}, by {name} | " + " | ".join(f"{x:.2f}" for x in np.mean(shares_of, axis=0)) + " |")
    if not args.shared:
        return
    shared = np.array([anywhere(rng) for _ in range(args.shared)])
    reach = {order: values_of(order, shared)[:, 0] for order in orders}
    apart: dict[str, list[float]] = {"mirror twins": [], "one letter apart": [], "any two": []}
    pairs = twins(SPACE, SPEC, ("reach", "torque"))
    for a, b in itertools.combinations(orders, 2):
        differ = float(np.sqrt(np.mean((reach[a] - reach[b]) ** 2)))
        apart["any two"].append(differ)
        if pairs.get(a) == b:
            apart["mirror twins"].append(differ)
        if sum(x != y for x, y in zip(a, b, strict=True)) == 1:
            apart["one letter apart"].append(differ)
    print(
        "\n| orders | pairs | reach of equal lengths, root mean square difference | worst pair |\n| --- |"
        + " ---: |" * 3
    )
    for name, all_of in apart.items():
        print(f"| {name} | {len(all_of):,} | {np.mean(all_of):.2f} | {max(all_of):.2f} |")


if __name__ == "__main__":
    main()
