"""Whether what joint orders are expected to gain comes: from half of each order's trials, of the other half.

    python docs/experiments/expected_gain.py BAG…

Prints, by how many trials that half is: orders, their mean gain expected and come, what the latter half of the past
brought, and the rank correlation of each of the two with what came.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from mobo_core.atlas.growth import expected_gain, volumes_added
from mobo_core.atlas.reading import read_trials

BINS = (5, 15, 40, 100, 10**9)


def ranks(values: list[float]) -> np.ndarray:
    """Return the place of each value among all."""
    return np.argsort(np.argsort(values))


def main() -> None:
    """Read and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bags", nargs="+", type=Path, metavar="BAG")
    sources, trials = read_trials(parser.parse_args().bags)
    aims = sources[0].settings.aims
    columns = [trials.names.index(name) for name in sources[0].settings.objectives]
    found: dict[int, list[tuple[float, float, float]]] = {low: [] for low in BINS[:-1]}
    for k in range(len(trials.orders)):
        added = volumes_added(trials.values[trials.order == k][:, columns], aims)
        n = len(added) // 2
        for low, high in zip(BINS, BINS[1:], strict=False):
            if low <= n < high:
                row = expected_gain(added[:n]), float(added[n : 2 * n].sum()), float(added[n // 2 : n].sum())
                found[low].append(row)
    print("| trials, from | orders | expected | came | before | ranks: expected | before |\n|" + " --- |" * 7)
    for low, rows in found.items():
        if len(rows) < 5:
            continue
        expected, came, before = (list(column) for column in zip(*rows, strict=True))
        alike = [float(np.corrcoef(ranks(each), ranks(came))[0, 1]) for each in (expected, before)]
        means = [float(np.mean(column)) for column in (expected, came, before)]
        cells = [*(f"{mean:.4f}" for mean in means), *(f"{each:.2f}" for each in alike)]
        print(f"| {low} | {len(rows)} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
