"""Which lengths the links of an arm may have, given what they add up to.

A link may have any length of a few intervals, such as 0 or [0.05, 0.3] m; so may each sum of links. What a link may
have is what leaves the links after it a sum that they can make.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

Interval = tuple[float, float]

# m, by which sums of floats may miss a bound.
ROUNDING = 1e-9


def added(lengths: Iterable[float]) -> float:
    """Return the sum of lengths, one added after the other: Python 3.12's own ``sum`` rounds otherwise than 3.11's."""
    total = 0.0
    for length in lengths:
        total += length
    return total


@dataclass(frozen=True)
class Links:
    """The lengths that links may have, in m, link by link.

    Attributes:
        least: of a link that is not zero.
        longest: of a link.
        zero: for each link, whether it may be zero.
        fixed: for each link, its length if it has but one.
        bounded: whether ``longest`` binds the last link that is not fixed, which takes what remains.
    """

    least: float
    longest: float
    zero: tuple[bool, ...]
    fixed: tuple[float | None, ...]
    bounded: bool

    @cached_property
    def last(self) -> int:
        """Index of the link that takes what remains; -1 if all are fixed."""
        return max((i for i, length in enumerate(self.fixed) if length is None), default=-1)

    @cached_property
    def allowed(self) -> tuple[tuple[Interval, ...], ...]:
        """What each link may have, whatever the others have."""
        return tuple(self._of_link(i) for i in range(len(self.fixed)))

    @cached_property
    def _sums(self) -> tuple[tuple[Interval, ...], ...]:
        """What the links from each on can add up to; the last entry is of none."""
        sums: list[tuple[Interval, ...]] = [((0.0, 0.0),)]
        for own in reversed(self.allowed):
            sums.append(_merged((a + c, b + d) for a, b in own for c, d in sums[-1]))
        return tuple(reversed(sums))

    @property
    def totals(self) -> tuple[Interval, ...]:
        """What all links can add up to."""
        return self._sums[0]

    def choices(self, link: int, rest: float) -> tuple[Interval, ...]:
        """Return what a link may have if it and those after it add up to ``rest``: one interval or more, ascending."""
        found = []
        for low, high in self.allowed[link]:
            for a, b in self._sums[link + 1]:
                start, end = max(low, rest - b), min(high, rest - a)
                if start <= end:
                    found.append((start, end))
                elif start - end < ROUNDING:
                    at = min(max(end, low), high)
                    found.append((at, at))
        return _merged(found) or self.allowed[link]

    def remainder(self, rest: float) -> float:
        """Return the length of the link that takes what remains, if it and those after it add up to ``rest``."""
        return nearest(self.allowed[self.last], rest - self._sums[self.last + 1][0][0])

    def settled(self, wanted: Sequence[float], total: float) -> tuple[float, ...]:
        """Return lengths that add up to ``total``, link by link the nearest to ``wanted`` that the rest leaves."""
        lengths: list[float] = []
        for i, fixed in enumerate(self.fixed):
            rest = total - added(lengths)
            if fixed is not None:
                lengths.append(fixed)
            elif i == self.last:
                lengths.append(self.remainder(rest))
            else:
                lengths.append(nearest(self.choices(i, rest), wanted[i]))
        return tuple(lengths)

    def _of_link(self, i: int) -> tuple[Interval, ...]:
        fixed = self.fixed[i]
        if fixed is not None:
            return ((fixed, fixed),)
        longest = math.inf if i == self.last and not self.bounded else self.longest
        return _merged([(0.0, 0.0)] * self.zero[i] + [(self.least, longest)])


def nearest(intervals: Sequence[Interval], length: float) -> float:
    """Return the length in one of the intervals that is nearest."""
    inside = (min(max(length, low), high) for low, high in intervals)
    return min(inside, key=lambda each: abs(each - length))


def text_of(intervals: Sequence[Interval]) -> str:
    """Return intervals for people: ``0 or 0.05 to 0.3``."""
    return " or ".join(
        f"{low:.9g}" if low == high else f"{low:.9g} {f'to {high:.9g}' if high < math.inf else 'or more'}"
        for low, high in intervals
    )


def _merged(intervals: Iterable[Interval]) -> tuple[Interval, ...]:
    merged: list[Interval] = []
    for low, high in sorted(intervals):
        if merged and low <= merged[-1][1]:
            merged[-1] = (merged[-1][0], max(merged[-1][1], high))
        else:
            merged.append((low, high))
    return tuple(merged)
