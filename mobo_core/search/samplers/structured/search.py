"""The search: which arm to try next, from all arms tried."""

from __future__ import annotations

import sys
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mobo_core.design import DesignSpace
from mobo_core.jit.numerics import stream
from mobo_core.search.samplers.structured.archive import Archive, Front
from mobo_core.search.samplers.structured.draw import Stream, draw
from mobo_core.search.samplers.structured.model import NEAR, WIDE, nearest, predict
from mobo_core.search.samplers.structured.policy import Policy
from mobo_core.search.samplers.structured.region import Region, spread
from mobo_core.search.samplers.structured.volume import most_adding

Floats = NDArray[np.float64]

# The streams of random numbers that are this search's; those below belong to poses and starts.
STREAM = 16
CANDIDATES = 96
_ANYWHERE, _FROM_OTHERS = 16, 24  # of the candidates
APART = 0.01  # gain by which a twin's best arm is better by far
OWN, TWINS, PENDING = 110, 40, 32  # arms that a model is made of
_NEAR_FROM = {1: sys.maxsize, 2: 60}  # by rules, told arms from which its model is of those near its front
_MODELLED = 3  # told arms from which an order has a model
HOPES = (0.3, 1.0, 2.0)  # standard deviations by which a candidate may be better than expected
_ALL_HOPE = 1e3
EXTREME = 0.2  # share of an order's own trials that are for the best in one objective, and of parents that are it
EXPLORING = 0.1  # share of the trials that go where the model knows least, for what it does not know


class Search:
    """Asks for arms and is told what they are worth.

    Orders are numbers; a point is as in :mod:`~mobo_core.search.samplers.structured.region`.

    Args:
        space: of the arms.
        count: of orders.
        twin: for each order the number of its mirror twin, -1 if it has none.
        maximized: for each objective, whether it is maximised.
        startup: trials before models are used.
        seed: of all.
        rules: 1, whose model is WIDE, or 2, of which it is NEAR once an order has arms enough.
    """

    def __init__(
        self,
        space: DesignSpace,
        count: int,
        twin: Sequence[int],
        maximized: Sequence[bool],
        startup: int,
        seed: int,
        rules: int,
    ) -> None:
        self._region = Region(space)
        self._twin, self._startup, self._seed = twin, startup, seed
        self._near_from = _NEAR_FROM[rules]
        self._d = len(self._region.low)
        self._m = len(maximized)
        best = [k for k, up in enumerate(maximized) if up]
        self._extremes = best or list(range(self._m))
        self.archives = [Archive(self._m, best, self._d, self._d - 1) for _ in range(count)]
        self.policy = Policy(count, self._m)
        self._all = Front(self._m, self._d, 256)
        # By how much the best of each order is behind its twin's.
        self._behind = np.zeros(count)

    def asked(self, trial: int, order: int, point: Floats) -> None:
        """Note an arm that a trial tries."""
        self.policy.ask(order)
        self.archives[order].pending[trial] = self._region.features(point[None])[0]

    def told(self, trial: int, order: int, point: Floats, gain: Floats | None) -> None:
        """Note what a trial came to, as gains; None if it failed."""
        archive = self.archives[order]
        archive.tell(trial, point, archive.pending[trial], gain)
        if gain is not None:
            self._all.add(gain, point)
        self.policy.tell(order, gain, archive, self._all.volume)
        if (twin := self._twin[order]) >= 0:
            self._behind[order] = self.archives[twin].best - archive.best
            self._behind[twin] = -self._behind[order]

    def next(self, trial: int) -> tuple[int, Floats]:
        """Return the order and the point to try in a trial."""
        state = np.uint64(stream(self._seed, STREAM, trial, 0, 0))
        r = Stream(state)
        if trial >= self._startup and (owed := self._owed()):
            return owed
        if trial >= self._startup and self.policy.serves_all(r.uniform()):
            order, front = self.policy.for_all(r.uniform()), self._all
        else:
            order = self.policy.for_each()
            front = self.archives[order].front
        archive = self.archives[order]
        candidates = self._candidates(state, r, order)
        if archive.told < _MODELLED or not len(archive.front):
            # From others or anywhere, in turn.
            return order, candidates[0 if r.uniform() < 0.5 else _ANYWHERE]
        if r.uniform() < EXPLORING:
            some = candidates[: _ANYWHERE + _FROM_OTHERS]
            return order, some[self._best(r, order, front, some, explores=True)]
        return order, candidates[self._best(r, order, front, candidates, explores=False)]

    def _owed(self) -> tuple[int, Floats] | None:
        """Return an order whose twin has a better arm by far, and that arm, if the order has not tried it."""
        for order in np.flatnonzero(self._behind > APART).tolist():
            other = self.archives[self._twin[order]].front
            best = max(self._extremes, key=lambda k: float(other.gains[other.best(k), k]))
            point = other.arms[other.best(best)]
            if not self.archives[order].tried(self._region.features(point[None])[0]):
                return order, point
        return None

    def _candidates(self, state: np.uint64, r: Stream, order: int) -> Floats:
        """Return points: anywhere; good ones of other orders; and changed ones of its own front."""
        archive, region = self.archives[order], self._region
        points = np.empty((CANDIDATES, self._d))
        own = archive.front.arms
        for c in range(_FROM_OTHERS):
            points[_ANYWHERE + c] = self._lent(r, order)
        for c in range(_ANYWHERE + _FROM_OTHERS, CANDIDATES):
            points[c] = own[self._parent(r, archive.front)] if len(own) else points[_ANYWHERE + c % _FROM_OTHERS]
        tried = archive.points if archive.told else points[_ANYWHERE : _ANYWHERE + 1]
        own = own if len(own) else tried
        draw(state, _ANYWHERE, _FROM_OTHERS, own, tried, *region.bounds, points)
        return points

    def _parent(self, r: Stream, front: Front) -> int:
        if r.uniform() < EXTREME:
            return front.best(self._extremes[r.below(len(self._extremes))])
        return r.below(len(front))

    def _lent(self, r: Stream, order: int) -> Floats:
        """Return a good point of another order: its twin, one on the front of all, or any."""
        twin = self._twin[order]
        if twin >= 0 and r.uniform() < 0.3 and len(self.archives[twin].front):
            front = self.archives[twin].front
        elif r.uniform() < 0.5 and len(self._all):
            front = self._all
        else:
            front = self.archives[r.below(len(self.archives))].front
        if not len(front):
            point = np.empty(self._d)
            spread(r.fork(), *self._region.bounds, point)
            return point
        lent: Floats = front.arms[self._parent(r, front)]
        return lent

    def _best(self, r: Stream, order: int, front: Front, points: Floats, *, explores: bool) -> int:
        """Return the number of the point that may add most to a front, or of which the model knows least."""
        archive, features = self.archives[order], self._region.features
        parent = self._parent(r, archive.front)
        centre = features(archive.front.arms[parent : parent + 1])[0]
        near = nearest(archive.features, len(archive.features), centre, OWN)
        z, gains = archive.features[near], archive.gains[near]
        twin = self._twin[order]
        theirs = 0
        if twin >= 0 and self.archives[twin].told:
            other = self.archives[twin]
            near = nearest(other.features, len(other.features), centre, TWINS)
            theirs = len(near)
            z, gains = np.vstack([z, other.features[near]]), np.vstack([gains, other.gains[near]])
        told = len(z)
        if archive.pending:
            z = np.vstack([z, np.array(list(archive.pending.values())[-PENDING:])])
        is_twin = np.zeros(len(z), np.bool_)
        is_twin[told - theirs : told] = True
        mean, deviation = np.empty((len(points), self._m)), np.empty((len(points), self._m))
        kernel = NEAR if archive.told >= self._near_from else WIDE
        predict(z, gains, is_twin, told, features(points), *kernel, mean, deviation)
        extreme = self._extremes[r.below(len(self._extremes))]
        if explores:
            return int(most_adding(front.gains, mean, deviation, _ALL_HOPE, extreme))
        for_extreme = front is archive.front and r.uniform() < EXTREME
        return int(
            most_adding(front.gains, mean, deviation, HOPES[r.below(len(HOPES))], extreme if for_extreme else -1)
        )
