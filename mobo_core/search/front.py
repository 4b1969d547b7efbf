"""The Pareto front of a study's objectives, and its hypervolume."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobo_core.evaluation.objectives import OBJECTIVES
from mobo_core.evaluation.spec import EvaluationSpec

Values = Sequence[float]


class Aim(NamedTuple):
    """What a study wants of one objective.

    Attributes:
        maximize: whether more is better.
        bound: of the box that hypervolumes are shares of, which runs from 0 to it. The reference point lies at 0 of
            what is maximised and at the bound of what is minimised.
    """

    maximize: bool
    bound: float

    def loss(self, value: float) -> float:
        """Return the value, or what to minimise instead."""
        return -value if self.maximize else value

    def gain(self, value: float) -> float:
        """Return by how much a value is better than the reference point."""
        return value if self.maximize else self.bound - value


Aims = tuple[Aim, ...]


def aims_of(objectives: Iterable[str], spec: EvaluationSpec) -> Aims:
    """Return what a study of these objectives wants, by name; for reach and torque the box is n voxels, 10 n N m."""
    chosen = [OBJECTIVES[name] for name in objectives]
    return tuple(Aim(objective.direction == "maximize", objective.bound(spec)) for objective in chosen)


def pareto_front(values: Sequence[Values], aims: Aims) -> list[int]:
    """Return the indices of the arms that no other one dominates, from the worst in the first objective to the best.

    An arm dominates another if it is at least as good in every objective and better in one. Of equal arms the first
    one stays.

    Args:
        values: of each arm, one an objective.
        aims: of the objectives, two or more.
    """
    losses = [tuple(aim.loss(value) for aim, value in zip(aims, arm, strict=True)) for arm in values]
    order = sorted(range(len(losses)), key=lambda i: (losses[i], i))
    if len(aims) == 2:
        front, least = [], float("inf")
        for i in order:
            if losses[i][1] < least:
                front.append(i)
                least = losses[i][1]
    else:
        import moocore  # here, since two objectives do without

        first = [i for k, i in enumerate(order) if k == 0 or losses[i] != losses[order[k - 1]]]
        good = moocore.is_nondominated(np.array([losses[i] for i in first])) if first else []
        front = [i for i, stays in zip(first, good, strict=True) if stays]
    return front[::-1]


def hypervolume(values: Sequence[Values], aims: Aims) -> float:
    """Return the share of the box (see :class:`Aim`) that the arms dominate; values as in :func:`pareto_front`."""
    front = [values[i] for i in pareto_front(values, aims)]
    whole = 1.0
    for aim in aims:
        whole *= aim.bound
    if len(aims) == 2:
        first, second = aims
        area, covered = 0.0, 0.0
        for x, y in ((first.gain(a), second.gain(b)) for a, b in front):
            if y > 0.0 and x > covered:
                # From arm to arm the first objective gets better and the second worse: each adds the strip that the
                # ones before do not cover.
                area += (x - covered) * y
                covered = x
        return area / whole
    import moocore

    gains = [[aim.gain(value) for aim, value in zip(aims, arm, strict=True)] for arm in front]
    inside = -np.array([gain for gain in gains if min(gain) > 0.0]).reshape(-1, len(aims))
    return float(moocore.hypervolume(inside, ref=np.zeros(len(aims)))) / whole if len(inside) else 0.0


class RunningFront:
    """The Pareto front of arms that come one at a time; the same as that of all of them at once.

    Args:
        aims: of the objectives.
    """

    def __init__(self, aims: Aims) -> None:
        self._aims = aims
        self._values: list[Values] = []
        self._losses: NDArray[np.float64] = np.empty((0, len(aims)))
        self._hypervolume = 0.0
        self._stale = False

    def __len__(self) -> int:
        """Return the number of arms on the front."""
        return len(self._values)

    @property
    def hypervolume(self) -> float:
        """What :func:`hypervolume` returns for all arms so far."""
        if self._stale:
            self._hypervolume, self._stale = hypervolume(self._values, self._aims), False
        return self._hypervolume

    def add(self, values: Values) -> None:
        """Take the next arm."""
        loss = np.array([aim.loss(value) for aim, value in zip(self._aims, values, strict=True)])
        if (self._losses <= loss).all(axis=1).any():
            return
        stays = np.flatnonzero(~(loss <= self._losses).all(axis=1))
        self._values = [*(self._values[i] for i in stays), values]
        self._losses = np.vstack([self._losses[stays], loss])
        self._stale = True
