"""Arms grouped by their first four joints, as the paper groups them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mobo_core.report.row import Row, rank
from mobo_core.report.table import StudyTable

PREFIX_LENGTH = 4

# The prefixes that Kawaharazuka et al. (Advanced Robotics 2025, sections 3.1 and 3.2) name, in its order, and
# its colours (its own definitions of green and orange); a marker each, since colour alone is not for all eyes.
_MAGENTA, _RED, _BLUE, _CYAN = "#ff00ff", "#ff0000", "#0000ff", "#00ffff"
_GREEN, _ORANGE, _LIME = "#008000", "#ff8000", "#00ff00"
PAPER_COLOURS: dict[int, dict[str, tuple[str, str]]] = {
    6: {
        "PRRY": (_MAGENTA, "o"),
        "RPYP": (_RED, "^"),
        "YPRY": (_BLUE, "s"),
        "RPPY": (_CYAN, "D"),
        "YPPY": (_GREEN, "v"),
        "YPPP": (_ORANGE, "P"),
    },
    7: {
        "PRRY": (_MAGENTA, "o"),
        "YPRR": (_CYAN, "D"),
        "YPRY": (_BLUE, "s"),
        "YPPP": (_ORANGE, "P"),
        "YPPY": (_GREEN, "v"),
        "YPYP": (_RED, "^"),
        "YPRP": (_LIME, "X"),
    },
}
# For the most frequent of the others: quiet, told apart by lightness too.
_QUIET = (("#8f7d70", "<"), ("#a99bb8", ">"), ("#b3bf8f", "p"), ("#d6c39f", "h"))


@dataclass(frozen=True)
class Group:
    """The arms of one prefix.

    Attributes:
        prefix: their first four joints as built.
        in_paper: whether the paper names it.
        rows: its complete trials, by number; there may be none if the paper names it.
    """

    prefix: str
    in_paper: bool
    rows: tuple[Row, ...]

    @property
    def best(self) -> Row | None:
        """The arm of the highest reach; of equals the one of least torque."""
        return min(self.rows, key=rank, default=None)

    @property
    def n_on_front(self) -> int:
        """How many of its arms are on the Pareto front, above the reach floor."""
        return sum(row.on_front and row.above_floor for row in self.rows)


@dataclass(frozen=True)
class Style:
    """How a prefix is drawn."""

    prefix: str
    colour: str
    marker: str


def prefix_of(row: Row) -> str:
    """Return the first four joints of an arm as built."""
    return row.joints[:PREFIX_LENGTH]


def groups(table: StudyTable) -> list[Group]:
    """Return the paper's prefixes in its order, then the others by falling best reach."""
    members: dict[str, list[Row]] = {}
    for row in table.complete:
        members.setdefault(prefix_of(row), []).append(row)
    named = PAPER_COLOURS.get(table.n_joints, {})
    first = [Group(prefix, True, tuple(members.pop(prefix, ()))) for prefix in named]
    others = [Group(prefix, False, tuple(rows)) for prefix, rows in members.items() if prefix]
    return first + sorted(others, key=lambda group: (rank(min(group.rows, key=rank)), group.prefix))


def found(of: Sequence[Group], *, others: int | None = None) -> list[Group]:
    """Return the groups that have arms: the paper's, and the best ``others`` of the rest (all if None)."""
    rest = [group for group in of if not group.in_paper]
    return [group for group in of if group.in_paper and group.rows] + rest[:others]


def styles(table: StudyTable) -> list[Style]:
    """Return the styles of the prefixes that are drawn in their own: the paper's and a few more.

    The latter are the ones with most arms on the front above the reach floor, then the most frequent.
    """
    named = PAPER_COLOURS.get(table.n_joints, {})
    of = groups(table)
    chosen = [Style(group.prefix, *named[group.prefix]) for group in of if group.in_paper]
    others = sorted(
        (group for group in of if not group.in_paper),
        key=lambda group: (-group.n_on_front, -len(group.rows), group.prefix),
    )
    return chosen + [Style(group.prefix, *quiet) for group, quiet in zip(others, _QUIET, strict=False)]
