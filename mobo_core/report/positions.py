"""Where the joints of good arms sit along the arm, and which proportions of links recur."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mobo_core.report.columns import Cell, Columns
from mobo_core.report.once import once
from mobo_core.report.prefixes import Group, groups, styles
from mobo_core.report.row import Row, rank
from mobo_core.report.table import StudyTable

Array = NDArray[np.float64]

BEST_SHARE = 0.05
_FEWEST, _MOST = 5, 60  # arms of a prefix
_TOGETHER = 0.1  # of the arm's length; joints nearer than this to the one before are of one group
_MOST_CLUSTERS = 4
_ROUNDS = 50
_CLEAR = 0.5  # silhouette, above which clusters are some (Kaufman and Rousseeuw, Finding Groups in Data, 1990)


@dataclass(frozen=True)
class Positions:
    """The joints of the best arms of a prefix.

    Attributes:
        prefix: the first four joints.
        rows: the arms, the highest reach first.
        places: (arms, joints) of each joint from the base, as a share of the arm's length.
        groups: how many joints sit together, from the base, such as ``2-1-3``, and how many arms have it; most first.
    """

    prefix: str
    rows: tuple[Row, ...]
    places: Array
    groups: tuple[tuple[str, int], ...]


def best_of(group: Group) -> list[Row]:
    """Return the twentieth of a group's arms that reaches most, five at least."""
    count = min(max(math.ceil(BEST_SHARE * len(group.rows)), _FEWEST), _MOST)
    return sorted(group.rows, key=rank)[:count]


@once
def positions(table: StudyTable) -> list[Positions]:
    """Return the prefixes that are drawn in a colour of their own, those that have arms, in that order."""
    by_prefix = {group.prefix: group for group in groups(table)}
    found = []
    for style in styles(table):
        rows = [row for row in best_of(by_prefix[style.prefix]) if len(row.lengths) == table.n_joints]
        if rows:
            places = places_of(rows)
            counts = Counter(group_text(line) for line in places)
            found.append(Positions(style.prefix, tuple(rows), places, tuple(counts.most_common())))
    return found


def places_of(rows: Sequence[Row]) -> Array:
    """Return where the joints sit, (arms, joints), as a share of the arm's length."""
    lengths = np.array([row.lengths for row in rows])
    totals = np.maximum(lengths.sum(axis=1, keepdims=True), 1e-12)
    places: Array = np.hstack([np.zeros((len(rows), 1)), np.cumsum(lengths[:, :-1], axis=1)]) / totals
    return places


def group_text(places: Sequence[float] | Array) -> str:
    """Return how many joints sit together, from the base: ``2-1-3``."""
    counts = [0]
    before = -math.inf
    for place in places:
        if counts[-1] and place - before > _TOGETHER:
            counts.append(0)
        counts[-1] += 1
        before = place
    return "-".join(map(str, counts))


@dataclass(frozen=True)
class Cluster:
    """Arms of like proportions.

    Attributes:
        shares: (joints,) of the arm's length that each link takes, on average.
        rows: the arms, the highest reach first.
    """

    shares: tuple[float, ...]
    rows: tuple[Row, ...]


@once
def clusters(table: StudyTable) -> list[Cluster]:
    """Return the clusters of link proportions among the study's best arms, the largest first.

    k-means (Lloyd, IEEE T-IT 28(2), 1982) from the arms farthest from one another, with the number of clusters, at
    most four, whose mean silhouette (Rousseeuw, J. Comput. Appl. Math. 20, 1987) is the highest; one if that is 0.5 or
    less.
    """
    all_arms = Group("", False, tuple(row for row in table.complete if len(row.lengths) == table.n_joints))
    rows = best_of(all_arms)
    if not rows:
        return []
    lengths = np.array([row.lengths for row in rows])
    shares = lengths / np.maximum(lengths.sum(axis=1, keepdims=True), 1e-12)
    distances = np.sqrt(np.square(shares[:, None] - shares[None]).sum(axis=2))
    best, labels = _CLEAR, np.zeros(len(rows), int)
    for k in range(2, min(_MOST_CLUSTERS, len(rows) - 1) + 1):
        found = _k_means(shares, distances, k)
        score = _silhouette(distances, found)
        if score > best:
            best, labels = score, found
    members = [[i for i in range(len(rows)) if labels[i] == label] for label in sorted(set(labels.tolist()))]
    ordered = sorted(members, key=lambda of: (-len(of), of[0]))
    return [Cluster(tuple(shares[of].mean(axis=0).tolist()), tuple(rows[i] for i in of)) for of in ordered]


def _k_means(points: Array, distances: Array, k: int) -> NDArray[np.int64]:
    chosen = [0]
    while len(chosen) < k:
        chosen.append(int(distances[chosen].min(axis=0).argmax()))
    centres = points[chosen]
    labels = np.zeros(len(points), int)
    for _ in range(_ROUNDS):
        labels = np.square(points[:, None] - centres[None]).sum(axis=2).argmin(axis=1)
        moved = np.array([points[labels == j].mean(axis=0) if (labels == j).any() else centres[j] for j in range(k)])
        if np.array_equal(moved, centres):
            break
        centres = moved
    return labels


def _silhouette(distances: Array, labels: NDArray[np.int64]) -> float:
    names = sorted(set(labels.tolist()))
    if len(names) < 2:
        return -1.0
    values = []
    for i, own in enumerate(labels):
        means = {name: distances[i, labels == name].mean() for name in names}
        count = int((labels == own).sum())
        inside = means[own] * count / (count - 1) if count > 1 else 0.0
        outside = min(mean for name, mean in means.items() if name != own)
        values.append((outside - inside) / max(inside, outside, 1e-12) if count > 1 else 0.0)
    return float(np.mean(values))


def position_columns(found: Sequence[Positions]) -> Columns:
    """Return a row an arm: where its joints sit, as shares of its length, and how they are grouped."""
    lines: list[dict[str, Cell]] = []
    for of in found:
        for row, places in zip(of.rows, of.places.tolist(), strict=True):
            line: dict[str, Cell] = {"prefix": of.prefix, "trial": row.trial, "joints": row.joints, "reach": row.reach}
            line |= {f"place_{i + 1}": place for i, place in enumerate(places)}
            lines.append(line | {"groups": group_text(places)})
    return {name: [line[name] for line in lines] for name in (lines[0] if lines else ())}
