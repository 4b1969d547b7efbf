"""What each structure is worth: prefixes of four joints, and whole joint orders."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from mobo_core.evaluation.objectives import SAME_PLACE
from mobo_core.report.columns import Cell, Columns
from mobo_core.report.once import once
from mobo_core.report.prefixes import prefix_of
from mobo_core.report.row import Row, rank
from mobo_core.report.table import StudyTable
from mobo_core.search.front import hypervolume, pareto_front
from mobo_core.search.mirror import exact_twins
from mobo_core.search.study import StudySettings

# Shares of the study's best reach at which the least torque is given.
REACHES = (0.5, 0.7, 0.9)


@dataclass(frozen=True)
class Structure:
    """The arms of one prefix or one whole order.

    Attributes:
        name: the first four joints, or all.
        rows: its arms, by number.
        front: those that no other one of them dominates, by falling reach.
        best: that of the highest reach.
        on_front: how many are on the study's front, above the reach floor.
        hypervolume: of them alone.
        contribution: by how much the study's hypervolume would be less without them.
        twin: of a whole order, its exact mirror twin among those of the study; else "".
    """

    name: str
    rows: tuple[Row, ...]
    front: tuple[Row, ...]
    best: Row
    on_front: int
    hypervolume: float
    contribution: float
    twin: str

    def least_torque(self, reach: float) -> float | None:
        """Return the least torque in N m of the arms that reach so much, or None."""
        return min((row.torque for row in self.rows if row.reach >= reach), default=None)

    @property
    def zero_lengths(self) -> int:
        """How many joints of the best arm are at the place of the next one, to 1 mm."""
        return sum(length < SAME_PLACE for length in self.best.lengths[:-1])

    @property
    def axes(self) -> int:
        """How many places the joints of the best arm have."""
        return len(self.best.lengths) - self.zero_lengths


@once
def prefixes(table: StudyTable) -> list[Structure]:
    """Return the prefixes of four joints, the highest reach first."""
    return _structures(table, prefix_of, {})


@once
def orders(table: StudyTable, settings: StudySettings) -> list[Structure]:
    """Return the whole joint orders, the highest reach first."""
    twins = exact_twins({row.joints for row in table.complete}, settings.space, settings.spec)
    return _structures(table, lambda row: row.joints, twins)


def _structures(table: StudyTable, name_of: Callable[[Row], str], twins: Mapping[str, str]) -> list[Structure]:
    members: dict[str, list[Row]] = {}
    for row in table.complete:
        if row.joints:
            members.setdefault(name_of(row), []).append(row)
    fronts = {name: [rows[i] for i in pareto_front(_values(rows), table.aims)] for name, rows in members.items()}
    # What counts for any hypervolume is on the front of its own structure.
    whole = hypervolume(_values(row for front in fronts.values() for row in front), table.aims)
    found = []
    for name, rows in members.items():
        leads = any(row.on_front for row in fronts[name])
        rest = [row for other, front in fronts.items() if other != name for row in front] if leads else []
        found.append(
            Structure(
                name=name,
                rows=tuple(rows),
                front=tuple(sorted(fronts[name], key=rank)),
                best=min(rows, key=rank),
                on_front=sum(row.on_front and row.above_floor for row in rows),
                hypervolume=hypervolume(_values(fronts[name]), table.aims),
                contribution=whole - hypervolume(_values(rest), table.aims) if leads else 0.0,
                twin=twins.get(name, ""),
            )
        )
    return sorted(found, key=lambda structure: (rank(structure.best), structure.name))


def _values(rows: Iterable[Row]) -> list[tuple[float, ...]]:
    return [row.values for row in rows]


def structure_columns(structures: Sequence[Structure], table: StudyTable) -> Columns:
    """Return a row a structure; reach in voxels, torque in N m."""
    total = max(len(table.useful_front), 1)
    most = max((row.reach for row in table.complete), default=0.0)
    lines: list[dict[str, Cell]] = []
    for structure in structures:
        line: dict[str, Cell] = {
            "joints": structure.name,
            "arms": len(structure.rows),
            "best_trial": structure.best.trial,
            "best_reach": structure.best.reach,
            "torque_of_best": structure.best.torque,
        }
        for share in REACHES:
            line[f"least_torque_at_{share * most:.3g}"] = structure.least_torque(share * most)
        line |= {
            "share_of_front": structure.on_front / total,
            "hypervolume": structure.hypervolume,
            "hypervolume_contribution": structure.contribution,
            "zero_lengths": structure.zero_lengths,
            "distinct_axes": structure.axes,
            "mirror_twin": structure.twin,
        }
        lines.append(line)
    return {name: [line[name] for line in lines] for name in (lines[0] if lines else ())}
