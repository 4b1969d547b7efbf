"""What a claim is, and what its check is given."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from mobo_core.report.claims.evidence import Arm, Evidence, Members
from mobo_core.report.claims.verdict import Part
from mobo_core.report.prefixes import PAPER_COLOURS
from mobo_core.search.study import first_difference


@dataclass(frozen=True)
class Pair:
    """What there is of six and of seven joints.

    Attributes:
        six, seven: evidence, or None.
    """

    six: Evidence | None = None
    seven: Evidence | None = None

    def of(self, n_joints: int) -> Evidence:
        """Return the evidence of 6 or 7 joints, which must be there."""
        found = self.six if n_joints == 6 else self.seven
        if found is None:
            raise ValueError(f"no evidence of {n_joints} joints")
        return found

    @property
    def apart(self) -> list[str]:
        """In what the two differ besides joints, so that values must not be compared, a line each."""
        if self.six is None or self.seven is None:
            return []
        return _differences(self.six, self.seven, ("at 6 joints", "at 7"))

    def unlike(self, studies: Pair) -> list[str]:
        """Return in what this, of an atlas, differs from studies, a line each."""
        pairs = [(self.six, studies.six), (self.seven, studies.seven)]
        return [
            line
            for own, other in pairs
            if own is not None and other is not None
            for line in _differences(own, other, (f"in the atlas of {own.n_joints} joints", "in the study"))
        ]

    def has(self, needs: Sequence[int]) -> bool:
        """Return whether there are arms of these numbers of joints."""
        found = {6: self.six, 7: self.seven}
        return all((evidence := found[n]) is not None and evidence.arms for n in needs)


def _differences(one: Evidence, two: Evidence, places: tuple[str, str]) -> list[str]:
    lines = []
    for name in ("spec", "space"):
        own, other = (getattr(of, name).to_dict() for of in (one, two))
        for values in (own, other):
            # Of the number of joints, and of how lengths are drawn, which changes no arm.
            for key in ("n_joints", "lengths"):
                values.pop(key, None)
        if (found := first_difference(own, other)) is not None:
            lines.append(f"{name}: {found[0]} is {found[1]} {places[0]}, {found[2]} {places[1]}")
    return lines


@dataclass(frozen=True)
class Claim:
    """A claim of the paper.

    Attributes:
        name: such as ``C1``.
        text: what is claimed, in a line.
        needs: numbers of joints of the studies it speaks of.
        check: returns its parts.
        evaluates: whether arms are evaluated for it.
    """

    name: str
    text: str
    needs: tuple[int, ...]
    check: Callable[[Pair], list[Part]]
    evaluates: bool = False


def paper_prefixes(evidence: Evidence) -> list[str]:
    """Return the prefixes that the paper names for this number of joints, in its order."""
    return list(PAPER_COLOURS[evidence.n_joints])


def missing(name: str, evidence: Evidence, *prefixes: str) -> Part | None:
    """Return the part of a statement on prefixes of which one was never met; None if all were."""
    absent = tuple(prefix for prefix in prefixes if prefix not in evidence.prefixes)
    return Part(name, unsure=absent) if absent else None


def named_best(evidence: Evidence, prefixes: Sequence[str]) -> list[tuple[Members, Arm]]:
    """Return those of some prefixes that were met, each with its best arm."""
    return [(of, of.best) for prefix in prefixes if (of := evidence.prefixes.get(prefix)) is not None]
