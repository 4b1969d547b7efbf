"""What a check comes to: a margin, how sure it is, and the verdict that follows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

REPRODUCED, NOT_REPRODUCED, INCONCLUSIVE = "reproduced", "not reproduced", "inconclusive"

Number: TypeAlias = float | int | str | None
Numbers: TypeAlias = dict[str, object]


@dataclass(frozen=True)
class Part:
    """One statement of a claim, as a number that is positive if it holds.

    Attributes:
        name: the statement in a few words.
        margin: by how much it holds, a share without unit; None if the study cannot say.
        interval: of 95 %, or None.
        numbers: that it comes from.
        unsure: prefixes hardly searched on which the answer rests.
    """

    name: str
    margin: float | None = None
    interval: tuple[float, float] | None = None
    numbers: dict[str, Number] = field(default_factory=dict)
    unsure: tuple[str, ...] = ()

    @property
    def verdict(self) -> str:
        """Reproduced or not if all of the interval says so and no answer rests on what was hardly searched."""
        if self.interval is None or self.unsure:
            return INCONCLUSIVE
        low, high = self.interval
        return REPRODUCED if low > 0 else NOT_REPRODUCED if high < 0 else INCONCLUSIVE

    def to_dict(self) -> Numbers:
        """Return plain values."""
        values: Numbers = {"verdict": self.verdict, "margin": self.margin, "interval": _list(self.interval)}
        values |= self.numbers
        return values | ({"hardly_searched": list(self.unsure)} if self.unsure else {})


@dataclass(frozen=True)
class Outcome:
    """What the parts of a claim come to together.

    Attributes:
        parts: all have to hold.
    """

    parts: tuple[Part, ...]

    @property
    def verdict(self) -> str:
        """Not reproduced if a part is not; else inconclusive if a part is, or there is none."""
        found = {part.verdict for part in self.parts}
        for verdict in (NOT_REPRODUCED, INCONCLUSIVE):
            if verdict in found:
                return verdict
        return REPRODUCED if found else INCONCLUSIVE

    @property
    def deciding(self) -> Part | None:
        """The part of the least margin among those that the verdict follows from."""
        parts = [part for part in self.parts if part.verdict == self.verdict]
        with_margin = [part for part in parts if part.margin is not None]
        if with_margin:
            return min(with_margin, key=lambda part: part.margin or 0.0)
        return parts[0] if parts else None

    def to_dict(self) -> Numbers:
        """Return verdict, margin and interval as plain values."""
        part = self.deciding
        margin, interval = (part.margin, part.interval) if part is not None else (None, None)
        return {"verdict": self.verdict, "margin": margin, "interval": _list(interval)}

    def numbers(self) -> Numbers:
        """Return each part by its name."""
        return {part.name: part.to_dict() for part in self.parts}


@dataclass(frozen=True)
class Checked:
    """A claim that was checked.

    Attributes:
        claim: its name, such as ``C1``.
        text: what the paper claims, in a line.
        outcome: what the studies show.
        fair: what holds of the structures themselves, by an atlas; None without.
    """

    claim: str
    text: str
    outcome: Outcome
    fair: Outcome | None = None

    def to_dict(self) -> Numbers:
        """Return plain values, as ``mobo claims --json`` prints them."""
        numbers = self.outcome.numbers()
        if self.fair is not None:
            numbers["fair"] = self.fair.numbers()
        fair = self.fair.to_dict() if self.fair is not None else None
        return {"claim": self.claim, **self.outcome.to_dict(), "numbers": numbers, "fair": fair, "text": self.text}


def _list(interval: Sequence[float] | None) -> list[float] | None:
    return None if interval is None else [float(end) for end in interval]
