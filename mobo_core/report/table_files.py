"""Tables as CSV and Parquet files, every number as exact as in the bag."""

from __future__ import annotations

import csv
import importlib
import io
import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from mobo_core.errors import InputError
from mobo_core.outputs import write_whole
from mobo_core.report.table import Row

# Column -> what it holds. A length column stands for one column a joint.
COLUMNS = {
    "trial": "number of the trial, from 0",
    "state": "COMPLETE or FAIL",
    "joints": "joint order as built",
    "sampled_joints": "joint order as drawn",
    "reach": "sum over the voxels of the share of poses reached",
    "torque": "N m, sum over the voxels of the mean norm of the gravity torque",
    "on_front": "on the Pareto front of the study",
    "above_floor": "reach of a tenth of the voxels or more",
    "known_as": "known arms of this joint order",
    "length": "m, length_1 to length_n",
    "attempt": "which sending of the trial was answered",
    "evaluator": "who answered",
    "seconds": "s, wall time of the evaluation",
    "reason": "why it failed",
}
FRONT_COLUMNS = ("trial", "joints", "sampled_joints", "reach", "torque", "above_floor", "known_as", "length")


def table_columns(rows: Iterable[Row], n_joints: int, names: Iterable[str] = COLUMNS) -> dict[str, list[Any]]:
    """Return the columns of a table; what a failed trial has no value for is None."""
    rows = list(rows)
    columns: dict[str, list[Any]] = {}
    for name in names:
        if name == "length":
            for i in range(n_joints):
                columns[f"length_{i + 1}"] = [row.lengths[i] if i < len(row.lengths) else None for row in rows]
        else:
            columns[name] = [_value(row, name) for row in rows]
    return columns


def _value(row: Row, name: str) -> Any:
    value = getattr(row, name)
    if isinstance(value, tuple):
        return "; ".join(value)
    return None if isinstance(value, float) and not math.isfinite(value) else value


def to_csv(columns: dict[str, list[Any]]) -> str:
    """Return columns as CSV; floats with as many digits as reading them back exactly takes, True as 1."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(columns)
    for values in zip(*columns.values(), strict=True):
        writer.writerow([int(value) if isinstance(value, bool) else value for value in values])
    return out.getvalue()


def check_table_path(path: Path) -> None:
    """Raise InputError unless the name of a table ends in .csv or .parquet; Parquet needs pyarrow."""
    suffix = path.suffix.lower()
    if suffix not in (".csv", ".parquet"):
        raise InputError(f"suffix {suffix!r}", where=str(path), expected="a file name ending in .csv or .parquet")
    if suffix == ".parquet":
        _pyarrow(str(path))


def write_table(path: Path, columns: dict[str, list[Any]]) -> None:
    """Write a table as its suffix says.

    Raises:
        InputError: see :func:`check_table_path`; or a place that cannot be written to.
    """
    check_table_path(path)
    parquet = path.suffix.lower() == ".parquet"
    write_whole(path, _parquet(columns, str(path)) if parquet else to_csv(columns))


def _pyarrow(where: str) -> tuple[Any, Any]:
    try:
        return importlib.import_module("pyarrow"), importlib.import_module("pyarrow.parquet")
    except ImportError:
        raise InputError(
            "Parquet needs pyarrow", where=where, expected="pip install pyarrow, or a file name ending in .csv"
        ) from None


def _parquet(columns: dict[str, list[Any]], where: str) -> bytes:
    arrow, parquet = _pyarrow(where)
    types = {
        "trial": arrow.int64(),
        "attempt": arrow.int64(),
        "on_front": arrow.bool_(),
        "above_floor": arrow.bool_(),
        "reach": arrow.float64(),
        "torque": arrow.float64(),
        "seconds": arrow.float64(),
    }
    fields = [
        (name, types.get(name, arrow.float64() if name.startswith("length_") else arrow.string())) for name in columns
    ]
    out = io.BytesIO()
    parquet.write_table(arrow.table(columns, schema=arrow.schema(fields)), out)
    return out.getvalue()
