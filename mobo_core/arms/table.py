"""Arms of a table: a CSV or Parquet file, a row an arm, as ``mobo export table`` and ``mobo atlas`` write it."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator
from pathlib import Path

from mobo_core.atlas.file import pyarrow
from mobo_core.design import Design, DesignSpace
from mobo_core.errors import InputError

_MOST_BYTES, _MOST_ARMS = 100_000_000, 100_000
_ORDERS = ("sampled_joints", "joints")


def table_arms(path: Path | str, space: DesignSpace) -> tuple[tuple[str, Design], ...]:
    """Return the arms of a table and where each is from, such as ``arms.csv, row 3``; the first row is row 1.

    The columns ``sampled_joints``, or else ``joints``, and ``length_1`` to ``length_n`` in m make an arm, on the base
    of the space; others say nothing here.

    Raises:
        InputError: the file cannot be read, is too large, lacks a column, or holds an arm that is none of the space.
    """
    path = Path(path)
    found = []
    for number, row in enumerate(_rows(path, space.n_joints), start=1):
        where = f"{path}, row {number}"
        if number > _MOST_ARMS:
            raise InputError(f"more than {_MOST_ARMS:,} rows", where=str(path), expected="fewer arms")
        joints, *lengths = row
        try:
            design = space.arm(str(joints), [float(str(length)) for length in lengths])
            space.params(design)
        except InputError as error:
            raise error.at(where) from None
        except (TypeError, ValueError):
            raise InputError(f"lengths {lengths!r:.80}", where=where, expected="numbers in m") from None
        found.append((f"{path.name}, row {number}", design))
    return tuple(found)


def _rows(path: Path, n_joints: int) -> Iterator[tuple[object, ...]]:
    """Yield order and lengths of each row."""
    lengths = [f"length_{i + 1}" for i in range(n_joints)]
    try:
        if not path.is_file() or path.stat().st_size > _MOST_BYTES:
            raise InputError("no file, or one of more than 100 MB", where=str(path), expected="a table of arms")
        if path.suffix.lower() == ".parquet":
            _, parquet = pyarrow(str(path))
            held = parquet.read_schema(path).names
            table = parquet.read_table(path, columns=(names := _columns(held, lengths, path)))
            yield from zip(*(table.column(name).to_pylist() for name in names), strict=True)
            return
        with path.open(encoding="utf-8", newline="") as file:
            reader = csv.DictReader(file)
            names = _columns(reader.fieldnames or (), lengths, path)
            for row in reader:
                yield tuple(row[name] for name in names)
    except (OSError, ValueError, csv.Error) as error:  # pyarrow's errors are of these kinds
        expected = "a CSV or Parquet file, as mobo export table writes it"
        raise InputError(f"{error!s:.80}", where=str(path), expected=expected) from None


def _columns(held: Iterable[str], lengths: list[str], path: Path) -> list[str]:
    held = set(held)
    order = next((name for name in _ORDERS if name in held), None)
    missing = [name for name in lengths if name not in held] + ([] if order else ["joints"])
    if order is None or missing:
        raise InputError(
            f"no column {missing[-1]}", where=str(path), expected=f"joints and length_1 to length_{len(lengths)}"
        )
    return [order, *lengths]
