"""Studies side by side."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mobo_core.report.claims.noise import student
from mobo_core.report.compare.summary import Interval, Summary
from mobo_core.report.prefixes import PAPER_COLOURS

_OTHERS = 8  # prefixes beside the paper's


@dataclass(frozen=True)
class Group:
    """Studies that differ in their seeds alone.

    Attributes:
        label: of the first of them, and how many they are.
        members: one at least.
    """

    label: str
    members: tuple[Summary, ...]

    @property
    def volume(self) -> tuple[float, Interval | None]:
        """Mean hypervolume, and its 95 % interval over the seeds (Student's t); None of one study alone."""
        values = np.array([one.volume for one in self.members])
        mean = float(values.mean())
        if len(values) < 2:
            return mean, None
        half = student(len(values) - 1) * float(values.std(ddof=1)) / math.sqrt(len(values))
        return mean, (mean - half, mean + half)


@dataclass(frozen=True)
class Comparison:
    """Several studies.

    Attributes:
        studies: in the order given.
    """

    studies: tuple[Summary, ...]

    @property
    def differing(self) -> dict[str, list[object]]:
        """The settings that are not the same in all: name -> each study's, None if it has none."""
        flat = [_flat(one.settings.to_dict()) for one in self.studies]
        names = list(dict.fromkeys(name for values in flat for name in values))
        found = {name: [values.get(name) for values in flat] for name in names}
        return {name: values for name, values in found.items() if any(value != values[0] for value in values[1:])}

    @property
    def groups(self) -> list[Group]:
        """The studies that differ in their seeds alone, together."""
        by_rest: dict[str, list[Summary]] = {}
        for one in self.studies:
            values = _flat(one.settings.to_dict())
            values.pop("seed", None)
            key = repr(sorted((name, repr(value)) for name, value in values.items())) + f"|{len(one.table.rows)}"
            by_rest.setdefault(key, []).append(one)
        return [Group(_name(of), tuple(of)) for of in by_rest.values()]

    @property
    def warnings(self) -> list[str]:
        """What keeps values from being compared, or makes them say less, a line each."""
        lines = []
        for name in (name for name in self.differing if name.startswith("spec.")):
            values = ", ".join(f"{one.label}: {v}" for one, v in zip(self.studies, self.differing[name], strict=True))
            lines.append(f"values must not be compared: {name} differs ({values})")
        if "objectives" in self.differing:
            lines.append("the studies have not the same objectives; all are shown by reach and torque")
        if len({len(one.table.rows) for one in self.studies}) > 1:
            counts = ", ".join(f"{one.label}: {len(one.table.rows):,}" for one in self.studies)
            lines.append(f"the studies have not the same number of trials ({counts}); see the hypervolume at the least")
        if any(one.simulated for one in self.studies):
            invented = ", ".join(one.label for one in self.studies if one.simulated)
            lines.append(f"values are invented (engine simulated): {invented}")
        if len(self.groups) > 1 and all(len(group.members) == 1 for group in self.groups):
            lines.append("one study of each: intervals are of the poses alone, not of what another seed would find")
        return lines

    @property
    def comparable(self) -> bool:
        """Whether all studies ask the same."""
        return not any(name.startswith("spec.") for name in self.differing)

    @property
    def least_trials(self) -> int:
        """The trials of the shortest study."""
        return min(len(one.table.rows) for one in self.studies)

    @property
    def prefixes(self) -> list[str]:
        """The paper's prefixes that were met, then those that reach most in any study."""
        joints = dict.fromkeys(one.settings.space.n_joints for one in self.studies)
        named = dict.fromkeys(prefix for n in joints for prefix in PAPER_COLOURS.get(n, {}))
        best: dict[str, float] = {}
        for one in self.studies:
            for prefix, of in one.prefixes.items():
                best[prefix] = max(best.get(prefix, 0.0), of.row.reach)
        others = sorted((p for p in best if p not in named), key=lambda p: (-best[p], p))[:_OTHERS]
        return [p for p in named if p in best] + others

    def to_dict(self) -> dict[str, object]:
        """Return plain values, as ``mobo compare --json`` prints them."""
        return {
            "studies": [_study(one, self.least_trials) for one in self.studies],
            "groups": [
                {"studies": [one.label for one in group.members], "hypervolume": group.volume[0],
                 "interval": list(group.volume[1]) if group.volume[1] else None}
                for group in self.groups
            ],
            "differ": self.differing,
            "comparable": self.comparable,
            "warnings": self.warnings,
            "structures": [
                {"prefix": prefix, "studies": [_best(one, prefix) for one in self.studies]} for prefix in self.prefixes
            ],
        }  # fmt: skip


def _name(of: Sequence[Summary]) -> str:
    more = len(of) - 1
    return f"{of[0].label} and {more} more seed{'s' if more > 1 else ''}" if more else of[0].label


def _study(one: Summary, least_trials: int) -> dict[str, object]:
    best = one.best
    return {
        "label": one.label, "name": one.name, "joints": one.settings.space.n_joints, "sampler": one.settings.sampler,
        "seed": one.settings.seed, "trials": len(one.table.rows), "failed": len(one.table.failed),
        "hypervolume": one.volume, "interval": list(one.volume_interval),
        "hypervolume_at_least_trials": one.volume_at(least_trials), "least_trials": least_trials,
        "on_front": len(one.front), "best_reach": best.reach if best is not None else None,
        "best_joints": best.joints if best is not None else None,
        "best_torque": best.torque if best is not None else None,
        "front": [list(point) for point in one.front],
    }  # fmt: skip


def _best(one: Summary, prefix: str) -> dict[str, object] | None:
    of = one.prefixes.get(prefix)
    if of is None:
        return None
    half = of.half if math.isfinite(of.half) else None
    interval = None if half is None else [of.row.reach - half, of.row.reach + half]
    return {"joints": of.row.joints, "trial": of.row.trial, "reach": of.row.reach, "interval": interval,
            "torque": of.row.torque, "trials": of.trials, "hardly_searched": not of.known}  # fmt: skip


def _flat(values: dict[str, object], prefix: str = "") -> dict[str, object]:
    out: dict[str, object] = {}
    for name, value in values.items():
        out |= _flat(value, f"{prefix}{name}.") if isinstance(value, dict) else {prefix + name: value}
    return out


def labels_of(names: Sequence[str]) -> list[str]:
    """Return the names, those that recur with a number, so that all differ."""
    found: list[str] = []
    for name in names:
        label, number = name, 1
        while label in found:
            number += 1
            label = f"{name} ({number})"
        found.append(label)
    return found
