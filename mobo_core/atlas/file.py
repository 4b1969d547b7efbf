"""Atlases as Parquet files. Nothing in a file is believed: sizes, names and numbers are looked at first.

Reading one needs pyarrow and numpy, and nothing of mobo's that takes time to import.
"""

from __future__ import annotations

import importlib
import json
import math
import re
from dataclasses import asdict
from importlib.resources import as_file, files
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobo_core.atlas.atlas import About, Atlas
from mobo_core.errors import InputError
from mobo_core.outputs import write_whole

FORMAT = 1
DEFAULT_JOINTS = 6  # of the atlas that is asked where nothing says otherwise
_RECORD = b"mobo_atlas"
_MOST_BYTES, _MOST_ROWS, _MOST_COLUMNS, _MOST_TEXT = 500_000_000, 2_000_000, 64, 200
_MOST_JOINTS = 12
_MOST_RECORD = 1_000_000
_NAME = re.compile(r"[a-z][a-z0-9_]{0,59}")
_ORDER = re.compile(r"[A-Z]{1,12}")
_TEXTS = ("joints", "twin", "study")
_COUNTS = ("trials_of_order", "trial")
_BASE = ("base_height", "base_tilt")


def write_atlas(path: Path, atlas: Atlas) -> None:
    """Write an atlas.

    Raises:
        InputError: pyarrow is not installed; or a place that cannot be written to.
    """
    arrow, parquet = pyarrow(str(path))
    columns: dict[str, Any] = {"joints": atlas.joints, "twin": atlas.twin}
    columns |= {f"length_{i + 1}": column for i, column in enumerate(atlas.lengths.T)}
    columns |= dict(zip(_BASE, atlas.base.T, strict=True))
    columns |= dict(atlas.values)
    columns |= {"trials_of_order": atlas.trials_of_order, "expected_gain": atlas.expected_gain}
    columns |= {"study": atlas.study, "trial": atlas.trial}
    kinds = {name: arrow.string() for name in _TEXTS} | {name: arrow.int64() for name in _COUNTS}
    schema = arrow.schema(
        [(name, kinds.get(name, arrow.float64())) for name in columns],
        metadata={_RECORD: json.dumps({"format": FORMAT, **asdict(atlas.about)}, sort_keys=True)},
    )
    out = arrow.BufferOutputStream()
    table = arrow.table({name: arrow.array(list(values)) for name, values in columns.items()}, schema=schema)
    parquet.write_table(table, out, compression="zstd", compression_level=19)
    write_whole(path, out.getvalue().to_pybytes())


def check_output(path: Path) -> None:
    """Raise InputError unless an atlas can be written to a file of this name: it ends in .parquet, pyarrow is there."""
    if path.suffix.lower() != ".parquet":
        raise InputError(f"suffix {path.suffix!r}", where=str(path), expected="a file name ending in .parquet")
    pyarrow(str(path))


def packaged(n_joints: int = DEFAULT_JOINTS) -> Path | None:
    """Return the atlas that mobo brings of arms of so many joints; None if it brings none."""
    found = files("mobo_core.atlas") / "data" / f"atlas_{n_joints}.parquet"
    with as_file(found) as path:
        return path if path.is_file() else None


def read_atlas(path: Path) -> Atlas:
    """Read an atlas.

    Raises:
        InputError: not a Parquet file, or not one of an atlas.
    """
    arrow, parquet = pyarrow(str(path))
    expected = "a file that `mobo atlas` wrote"
    try:
        size = path.stat().st_size
        if not path.is_file() or size > _MOST_BYTES:
            what = f"{size:,} bytes" if path.is_file() else "is no file"
            raise InputError(what, where=str(path), expected=expected)
        with parquet.ParquetFile(path, thrift_string_size_limit=10 * _MOST_RECORD) as file:
            _check_size(file.metadata, str(path))
            about = _about((file.schema_arrow.metadata or {}).get(_RECORD), str(path))
            _check_columns(arrow, file.schema_arrow, about, str(path))
            table = file.read(use_threads=False)
    except OSError as error:
        reason = error.strerror or "not Parquet"
        raise InputError(reason, where=str(path), expected=expected) from None
    except (arrow.ArrowException, ValueError, KeyError, TypeError, OverflowError) as error:
        raise InputError(f"not readable ({str(error)[:60]})", where=str(path), expected=expected) from None
    return _atlas(table, about, str(path))


def pyarrow(where: str) -> tuple[ModuleType, ModuleType]:
    """Return pyarrow and pyarrow.parquet.

    Raises:
        InputError: pyarrow is not installed.
    """
    try:
        return importlib.import_module("pyarrow"), importlib.import_module("pyarrow.parquet")
    except ImportError:
        raise InputError("Parquet needs pyarrow", where=where, expected="pip install pyarrow") from None


def _check_size(metadata: Any, where: str) -> None:
    size = sum(metadata.row_group(i).total_byte_size for i in range(metadata.num_row_groups))
    if metadata.num_rows > _MOST_ROWS or metadata.num_columns > _MOST_COLUMNS or not 0 <= size <= _MOST_BYTES:
        what = f"{metadata.num_rows:,} rows, {metadata.num_columns} columns, {size:,} bytes unpacked"
        raise InputError(what, where=where, expected=f"at most {_MOST_ROWS:,}, {_MOST_COLUMNS}, {_MOST_BYTES:,}")


def _about(record: bytes | None, where: str) -> About:
    """Return what the file says of itself, every field checked."""
    if record is None:
        raise InputError("no atlas", where=where, expected="a file that `mobo atlas` wrote")
    try:
        if len(record) > _MOST_RECORD:
            raise ValueError(f"{len(record):,} bytes")
        values = json.loads(record)
        if values.pop("format") != FORMAT:
            raise ValueError("format")
        about = About(**values)
        objectives = tuple(about.objectives)
        counts = (about.n_voxels, about.trials, about.orders)
        good = (
            isinstance(about.space, dict) and isinstance(about.spec, dict) and isinstance(about.versions, dict)
            and 2 <= len(objectives) <= 3
            and all(isinstance(name, str) and _NAME.fullmatch(name) for name in objectives)
            and all(isinstance(count, int) and 0 <= count < 2**53 for count in counts)
            and isinstance(about.hypervolume, float | int) and math.isfinite(about.hypervolume)
            and isinstance(about.engine, str) and len(about.engine) < _MOST_TEXT
            and all(isinstance(study, dict) for study in about.studies)
        )  # fmt: skip
        if not good:
            raise ValueError("a value that cannot be")
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
        what = f"metadata not readable ({type(error).__name__}: {str(error)[:60]})"
        raise InputError(what, where=where, expected=f"an atlas of format {FORMAT}") from None
    return About(**{**values, "objectives": objectives})


def _check_columns(arrow: ModuleType, schema: Any, about: About, where: str) -> None:
    types = {name: schema.field(i).type for i, name in enumerate(schema.names)}
    if len(types) < len(schema.names):
        raise InputError("a column twice", where=where, expected="each once")
    needed = {name: arrow.string() for name in _TEXTS} | {name: arrow.int64() for name in _COUNTS}
    floats = ("length_1", *_BASE, "reach", "torque", *about.objectives, "expected_gain")
    needed |= {name: arrow.float64() for name in floats}
    for name, kind in needed.items():
        if types.get(name) != kind:
            raise InputError(f"column {name!r} is {types.get(name, 'missing')}", where=where, expected=f"{kind}")
    for name, kind in types.items():
        if name not in needed and (kind != arrow.float64() or not _NAME.fullmatch(name)):
            raise InputError(f"column {name!r:.60} of {str(kind):.20}", where=where, expected="an objective's values")


def _numbers(column: Any, kind: type) -> NDArray[Any]:
    """Return a column without missing values; pyarrow's own way would import pandas."""
    parts: list[NDArray[Any]] = [
        np.frombuffer(part.buffers()[1], kind, len(part), part.offset * 8) for part in column.chunks if len(part)
    ]
    return np.concatenate(parts) if parts else np.empty(0, kind)


def _atlas(table: Any, about: About, where: str) -> Atlas:
    if any(column.null_count for column in table.columns):
        raise InputError("a value is missing", where=where, expected="a value in every row")
    texts = {name: tuple(table[name].to_pylist()) for name in _TEXTS}
    numbers = {
        name: _numbers(table[name], np.int64 if name in _COUNTS else np.float64)
        for name in table.column_names
        if name not in _TEXTS
    }
    n = 0
    while f"length_{n + 1}" in numbers:
        n += 1
    lengths = [numbers[f"length_{i + 1}"] for i in range(n)]
    for name, column in numbers.items():
        if not np.isfinite(column).all():
            raise InputError(f"{name} holds a number that is not finite", where=where, expected="finite numbers")
        if (name in (*_COUNTS, "expected_gain", "reach") or name.startswith("length_")) and (column < 0).any():
            raise InputError(f"{name} holds a negative number", where=where, expected="0 or more")
    for joints, twin in set(zip(texts["joints"], texts["twin"], strict=True)):
        if not _ORDER.fullmatch(joints) or len(joints) != n or (twin and not _ORDER.fullmatch(twin)):
            raise InputError(f"joints {joints!r:.30}, twin {twin!r:.30}", where=where, expected=f"orders of {n} joints")
    if n > _MOST_JOINTS or any(len(study) > _MOST_TEXT for study in set(texts["study"])):
        raise InputError(f"{n} joints, or a study of a very long name", where=where, expected=f"{_MOST_JOINTS} at most")
    values = {
        name: column
        for name, column in numbers.items()
        if name not in (*_COUNTS, *_BASE, "expected_gain") and not name.startswith("length_")
    }
    return Atlas(
        about=about,
        joints=texts["joints"],
        twin=texts["twin"],
        lengths=np.column_stack(lengths),
        base=np.column_stack([numbers[name] for name in _BASE]),
        values=values,
        trials_of_order=numbers["trials_of_order"],
        expected_gain=numbers["expected_gain"],
        study=texts["study"],
        trial=numbers["trial"],
    )
