"""The tables of a comparison."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rich.table import Table
from rich.text import Text

from mobo_core.report.columns import Cell, Columns
from mobo_core.report.compare.comparison import Comparison

_LONGEST = 60  # characters of a setting


def study_columns(comparison: Comparison) -> Columns:
    """Return a row a study: settings that name it, hypervolume with its interval, best arm."""
    least = comparison.least_trials
    lines: list[dict[str, Cell]] = []
    for one in comparison.studies:
        best, low_high = one.best, one.volume_interval
        lines.append({
            "study": one.label, "joints": one.settings.space.n_joints, "sampler": one.settings.sampler,
            "seed": one.settings.seed, "trials": len(one.table.rows), "failed": len(one.table.failed),
            "hypervolume": one.volume, "low": low_high[0], "high": low_high[1],
            f"hypervolume_at_{least}": one.volume_at(least), "on_front": len(one.front),
            "best_reach": best.reach if best is not None else None,
            "best_joints": best.joints if best is not None else None,
            "best_torque": best.torque if best is not None else None,
        })  # fmt: skip
    for group in comparison.groups:
        mean, interval = group.volume
        if interval is not None:
            line: dict[str, Cell] = dict.fromkeys(lines[0])
            lines.append(line | {"study": f"mean: {group.label}", "hypervolume": mean, "low": interval[0],
                                 "high": interval[1]})  # fmt: skip
    return {name: [line[name] for line in lines] for name in lines[0]}


def difference_columns(comparison: Comparison) -> Columns:
    """Return a row a setting that is not the same in all studies, a column a study."""
    found = comparison.differing
    columns: Columns = {"setting": list(found)}
    for i, one in enumerate(comparison.studies):
        columns[one.label] = [_short(values[i]) for values in found.values()]
    return columns


def _short(value: object) -> str:
    text = "-" if value is None else str(value)
    return text if len(text) <= _LONGEST else text[: _LONGEST - 1] + "…"


def structure_columns(comparison: Comparison) -> Columns:
    """Return a row a prefix: best reach, half of its 95 % interval, torque and trials in each study."""
    columns: Columns = {"prefix": list(comparison.prefixes)}
    for one in comparison.studies:
        of = [one.prefixes.get(prefix) for prefix in comparison.prefixes]
        columns[f"{one.label} reach"] = [best.row.reach if best else None for best in of]
        columns[f"{one.label} ±"] = [best.half if best and math.isfinite(best.half) else None for best in of]
        columns[f"{one.label} torque"] = [best.row.torque if best else None for best in of]
        columns[f"{one.label} trials"] = [best.trials if best else 0 for best in of]
        columns[f"{one.label} hardly searched"] = ["" if best and best.known else "yes" for best in of]
    return columns


def console_tables(comparison: Comparison) -> Sequence[Table]:
    """Return the tables for a terminal."""
    return [
        _table("Studies", _studies(comparison)),
        _table("Settings that differ", difference_columns(comparison)),
        _table("Best reach of each order of the first four joints / torque N m (?: hardly searched)",
               _structures(comparison)),
    ]  # fmt: skip


def _studies(comparison: Comparison) -> Columns:
    columns = study_columns(comparison)
    low, high = columns.pop("low"), columns.pop("high")
    shown: Columns = {}
    for name, values in columns.items():
        shown[name.replace("_", " ")] = [_number(value, 4 if "hypervolume" in name else 2) for value in values]
        if name == "hypervolume":
            shown["95 %"] = [f"{_number(a, 4)} … {_number(b, 4)}" for a, b in zip(low, high, strict=True)]
    return shown


def _number(value: Cell, digits: int) -> str:
    return "" if value is None else f"{value:.{digits}f}" if isinstance(value, float) else str(value)


def _structures(comparison: Comparison) -> Columns:
    columns: Columns = {"prefix": list(comparison.prefixes)}
    for one in comparison.studies:
        cells: list[Cell] = []
        for prefix in comparison.prefixes:
            of = one.prefixes.get(prefix)
            mark = "" if of is None or of.known else " ?"
            cells.append("-" if of is None else f"{of.row.reach:.1f} ± {of.half:.1f} / {of.row.torque:.0f}{mark}")
        columns[one.label] = cells
    return columns


def _table(title: str, columns: Columns) -> Table:
    out = Table(title=Text(title), title_justify="left", title_style="bold", box=None, pad_edge=False,
                padding=(0, 2, 0, 0), header_style="bold")  # fmt: skip
    for name in columns:
        out.add_column(Text(name), overflow="fold")
    for values in zip(*columns.values(), strict=True):
        out.add_row(*(Text(str(value)) for value in values))
    return out
