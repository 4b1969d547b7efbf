"""A study's trials as columns of plain values."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import TypeAlias

from mobo_core.report.row import Row

Cell: TypeAlias = str | int | float | bool | None
Columns: TypeAlias = dict[str, list[Cell]]

# Column -> what it holds. ``length`` stands for one column a joint, ``extra`` for any number.
COLUMNS = {
    "trial": "number of the trial, from 0",
    "state": "COMPLETE or FAIL",
    "joints": "joint order as built",
    "sampled_joints": "joint order as drawn",
    "reach": "sum over the voxels of the share of poses reached",
    "torque": "N m, sum over the voxels of the mean norm of the gravity torque",
    "extra": "the study's other objectives, a column each by name",
    "on_front": "on the Pareto front of the study",
    "above_floor": "reach of a tenth of the voxels or more",
    "known_as": "known arms of this joint order",
    "length": "m, length_1 to length_n",
    "attempt": "which sending of the trial was answered",
    "evaluator": "who answered",
    "seconds": "s, wall time of the evaluation",
    "reason": "why it failed",
}
FRONT_COLUMNS = ("trial", "joints", "sampled_joints", "reach", "torque", "extra", "above_floor", "known_as", "length")


def table_columns(rows: Iterable[Row], n_joints: int, names: Iterable[str] = COLUMNS) -> Columns:
    """Return the columns of a table; what a failed trial has no value for is None."""
    rows = list(rows)
    columns: Columns = {}
    for name in names:
        if name == "length":
            for i in range(n_joints):
                columns[f"length_{i + 1}"] = [row.lengths[i] if i < len(row.lengths) else None for row in rows]
        elif name == "extra":
            extras = [dict(row.extra) for row in rows]
            for objective in dict.fromkeys(objective for extra in extras for objective in extra):
                columns[objective] = [extra.get(objective) for extra in extras]
        else:
            columns[name] = [_value(row, name) for row in rows]
    return columns


def without_hosts(rows: Iterable[Row]) -> list[Row]:
    """Return trials whose evaluators, whose names tell hosts, are numbered as they come."""
    rows = list(rows)
    met = dict.fromkeys(row.evaluator for row in rows if row.evaluator)
    names = {name: f"evaluator {number}" for number, name in enumerate(met, 1)}
    return [replace(row, evaluator=names.get(row.evaluator, "")) for row in rows]


def _value(row: Row, name: str) -> Cell:
    value = getattr(row, name)
    if isinstance(value, tuple):
        return "; ".join(value)
    return None if isinstance(value, float) and not math.isfinite(value) else value
