"""What an atlas says beyond the paper: orders that it does not name and that beat those it does; torque a voxel.

    python docs/experiments/findings.py orders
    python docs/experiments/findings.py torques

`orders` holds those that the paper does not name, the highest hypervolume first, against the best arm of each prefix
that it names: by how many voxels an arm that takes no more torque reaches more. Arms are chosen by the atlas's values,
and evaluated on poses that no search saw. `torques` asks for the mean torque of the voxels that an arm reaches rather
than their sum, which grows with what is reached: which prefixes hold the front then.
"""

from __future__ import annotations

import argparse
from collections import Counter
from functools import cache
from pathlib import Path

import numpy as np

from mobo_core.arms.resample import Interval, Resamples, Score
from mobo_core.atlas.atlas import Atlas, partial
from mobo_core.atlas.file import packaged, read_atlas
from mobo_core.design.description import to_urdf
from mobo_core.evaluation.evaluate import evaluate
from mobo_core.report.prefixes import PAPER_COLOURS, PREFIX_LENGTH
from mobo_core.search.front import Aim, hypervolume, pareto_front

FLOOR = 0.4  # of the voxels; below it an arm of either view's front is of little use


class Measured:
    """The arms of an atlas on unseen poses."""

    def __init__(self, atlas: Atlas) -> None:
        self.atlas = atlas
        self.reach, self.torque = atlas.values["reach"], atlas.values["torque"]
        self._resamples = Resamples(atlas.spec.model_copy(update={"seed": atlas.spec.seed + 1, "poses_per_voxel": 100}))
        self.score = cache(self._score)

    def _score(self, row: int) -> Score:
        return self._resamples.score(to_urdf(self.atlas.design(row), self.atlas.space))

    def prefix(self, row: int) -> str:
        """Return the first joints of an arm's order."""
        return self.atlas.joints[row][:PREFIX_LENGTH]


def text_of(interval: Interval) -> str:
    """Return a difference, in bold if it is one, and its 95 % interval."""
    bold = "**" * interval.sure
    return f"{bold}{interval.value:+.1f}{bold} [{interval.low:+.1f}, {interval.high:+.1f}]"


def unnamed(measured: Measured, top: int) -> None:
    """Print what orders that the paper does not name reach more than the best of those that it names."""
    atlas, named = measured.atlas, PAPER_COLOURS[measured.atlas.space.n_joints]
    best: dict[str, int] = {}
    for row in range(len(atlas)):  # orders by falling best reach, and in them arms
        best.setdefault(measured.prefix(row), row)
    against = {prefix: best[prefix] for prefix in named if prefix in best}
    print("| order | highest reach / torque | " + " | ".join(against) + " |\n| --- | ---: |" + " --- |" * len(against))
    values = {prefix: measured.score(row) for prefix, row in against.items()}
    cells = [f"{score.reach:.1f} / {score.torque:.0f}" for score in values.values()]
    print("| (of the paper's prefixes) | | " + " | ".join(cells) + " |")
    others = [rows for rows in atlas.orders.values() if measured.prefix(int(rows[0])) not in named]
    wanted = np.array(atlas.wanted)
    others.sort(key=lambda rows: -hypervolume(wanted[rows].tolist(), atlas.aims))
    for rows in others[:top]:
        cells = []
        for prefix, row in against.items():
            within = rows[measured.torque[rows] <= measured.torque[row]]
            if not len(within):
                cells.append("–")
                continue
            chosen = measured.score(int(within[np.argmax(measured.reach[within])]))
            cells.append(text_of(chosen.over(values[prefix])[0]))
        highest = measured.score(int(rows[0]))
        name = atlas.joints[int(rows[0])]
        print(f"| {name} | {highest.reach:.1f} / {highest.torque:.0f} | " + " | ".join(cells) + " |", flush=True)


def torque_a_voxel(measured: Measured) -> None:
    """Print which orders hold the front by the sum of torques, and by the mean of the voxels reached."""
    atlas = measured.atlas
    reached = np.empty(len(atlas))
    for row in range(len(atlas)):
        result = evaluate(atlas.design(row), atlas.spec, space=atlas.space)
        reached[row] = np.count_nonzero(result.voxel_reach)
        if row % 100 == 0:
            print(f"{row:,} of {len(atlas):,} arms", end="\r", flush=True)
    mean = measured.torque / np.maximum(reached, 1)
    of_use = np.flatnonzero(measured.reach >= FLOOR * atlas.spec.n_voxels)
    print("| prefix | on the front by the sum | by the mean | best reach | its torque | voxels reached | N m a voxel |")
    print("| --- |" + " ---: |" * 6)
    fronts = []
    for torque in (measured.torque, mean):
        values = list(zip(measured.reach[of_use], torque[of_use], strict=True))
        front = of_use[pareto_front(values, (Aim(True, 1.0), Aim(False, 1.0)))]
        fronts.append(Counter(measured.prefix(int(row)) for row in front))
    shown = dict.fromkeys((*PAPER_COLOURS[atlas.space.n_joints], *fronts[0], *fronts[1]))
    for prefix in shown:
        for row in [row for row in range(len(atlas)) if measured.prefix(row) == prefix][:1]:  # its best one
            cells = [f"{front[prefix]}" for front in fronts]
            cells += [f"{measured.reach[row]:.1f}", f"{measured.torque[row]:.0f}"]
            print(f"| {prefix} | " + " | ".join((*cells, f"{reached[row]:.0f}", f"{mean[row]:.2f}")) + " |")


def main() -> None:
    """Run as a script."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("orders", "torques"))
    parser.add_argument("--atlas", type=Path, help="[the one that mobo brings]")
    parser.add_argument("--top", type=int, default=12, help="of `orders` so many [12]")
    args = parser.parse_args()
    file = args.atlas or packaged()
    if file is None:
        parser.error("mobo brings no atlas; name one")
    measured = Measured(read_atlas(file))
    print(partial(measured.atlas))
    if args.what == "orders":
        unnamed(measured, args.top)
    else:
        torque_a_voxel(measured)


if __name__ == "__main__":
    main()
