"""Tables as CSV and Parquet files, every number as exact as in the bag."""

from __future__ import annotations

import csv
import importlib
import importlib.util
import io
from pathlib import Path
from types import ModuleType

from mobo_core.errors import InputError, visible
from mobo_core.outputs import write_whole
from mobo_core.report.columns import Columns


def to_csv(columns: Columns) -> str:
    """Return columns as CSV; floats with as many digits as reading them back exactly takes, True as 1.

    A text that a spreadsheet would take for a formula is quoted as spreadsheets expect: ``'=1+1``.
    """
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(columns)
    for values in zip(*columns.values(), strict=True):
        writer.writerow(map(_cell, values))
    return out.getvalue()


def _cell(value: object) -> object:
    if isinstance(value, str):
        shown = "\n".join(map(visible, value.split("\n")))
        return f"'{shown}" if shown.startswith(("=", "+", "-", "@")) else shown
    return int(value) if isinstance(value, bool) else value


def check_table_path(path: Path) -> None:
    """Raise InputError unless the name of a table ends in .csv or .parquet; Parquet needs pyarrow."""
    suffix = path.suffix.lower()
    if suffix not in (".csv", ".parquet"):
        raise InputError(f"suffix {suffix!r}", where=str(path), expected="a file name ending in .csv or .parquet")
    if suffix == ".parquet":
        _pyarrow(str(path))


def write_table(path: Path, columns: Columns) -> None:
    """Write a table as its suffix says.

    Raises:
        InputError: see :func:`check_table_path`; or a place that cannot be written to.
    """
    check_table_path(path)
    parquet = path.suffix.lower() == ".parquet"
    write_whole(path, _parquet(columns, str(path)) if parquet else to_csv(columns))


def has_parquet() -> bool:
    """Return whether Parquet can be written: pyarrow is installed."""
    return importlib.util.find_spec("pyarrow") is not None


def to_parquet(columns: Columns) -> bytes:
    """Return columns as a Parquet file.

    Raises:
        InputError: pyarrow is not installed.
    """
    return _parquet(columns, "Parquet")


def _pyarrow(where: str) -> tuple[ModuleType, ModuleType]:
    try:
        return importlib.import_module("pyarrow"), importlib.import_module("pyarrow.parquet")
    except ImportError:
        raise InputError(
            "Parquet needs pyarrow", where=where, expected="pip install pyarrow, or a file name ending in .csv"
        ) from None


def _parquet(columns: Columns, where: str) -> bytes:
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
    by_kind = {bool: arrow.bool_(), int: arrow.int64(), float: arrow.float64()}
    fields = []
    for name, values in columns.items():
        kinds = {type(value) for value in values} - {type(None)}
        kind = float if float in kinds else kinds.pop() if len(kinds) == 1 else str
        fields.append((name, types.get(name, by_kind.get(kind, arrow.string()))))
    out = io.BytesIO()
    parquet.write_table(arrow.table(columns, schema=arrow.schema(fields)), out, compression="zstd", compression_level=9)
    return out.getvalue()
