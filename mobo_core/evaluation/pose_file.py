"""Tool poses from a file: YAML or CSV, positions with roll, pitch and yaw, or with a quaternion."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

from mobo_core.errors import InputError
from mobo_core.settings import read_yaml

# Most poses of a spec, which every message to an evaluator holds.
MAX_TARGETS = 1000
Pose = tuple[float, float, float, float, float, float]

_MAX_BYTES = 1_000_000
_RPY = ("x", "y", "z", "roll", "pitch", "yaw")
_QUATERNION = ("x", "y", "z", "qx", "qy", "qz", "qw")
_EXPECTED = "x y z roll pitch yaw (m, rad), or x y z qx qy qz qw"
# A quaternion whose length is farther from 1 is a mistake, not rounding.
_OFF_UNIT = 0.01


def read_poses(path: str | Path) -> tuple[Pose, ...]:
    """Read tool poses, base frame: (x, y, z, roll, pitch, yaw) of each, in m and rad.

    A CSV file (suffix ``.csv``) has 6 or 7 numbers a line, or a first line with names. A YAML file is a list of such
    lists, or of mappings of the names.

    Raises:
        InputError: no such file, none of poses, or more than the spec takes.
    """
    path = Path(path)
    try:
        if path.stat().st_size > _MAX_BYTES:
            raise InputError("file too large", where=str(path), expected=f"at most {_MAX_BYTES} bytes")
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not UTF-8 text"
        raise InputError(reason, where=str(path), expected="a YAML or CSV file of poses") from None
    rows = _csv_rows(text, path) if path.suffix.lower() == ".csv" else _yaml_rows(text, path)
    if not 1 <= len(rows) <= MAX_TARGETS:
        raise InputError(f"{len(rows)} poses", where=str(path), expected=f"1 to {MAX_TARGETS} poses")
    return tuple(_pose(row, f"{path}: {where}") for where, row in rows)


def _csv_rows(text: str, path: Path) -> list[tuple[str, object]]:
    try:
        lines = [(f"line {i}", row) for i, row in enumerate(csv.reader(text.splitlines()), 1) if any(row)]
    except csv.Error as error:
        raise InputError(f"not CSV ({error})", where=str(path), expected="CSV") from None
    lines = [(where, row) for where, row in lines if not row[0].lstrip().startswith("#")]
    if not lines or _is_number(lines[0][1][0]):
        return list(lines)
    names = [name.strip().lower() for name in lines[0][1]]
    for where, row in lines:
        if len(row) != len(names):
            raise InputError(f"{len(row)} cells", where=f"{path}: {where}", expected=f"{len(names)}, as the first line")
    return [(where, dict(zip(names, row, strict=True))) for where, row in lines[1:]]


def _yaml_rows(text: str, path: Path) -> list[tuple[str, object]]:
    try:
        found = read_yaml(text)
    except ValueError as error:
        raise InputError(f"not YAML ({' '.join(str(error).split()):.80})", where=str(path), expected="YAML") from None
    if isinstance(found, dict) and list(found) == ["poses"]:
        found = found["poses"]
    if not isinstance(found, list):
        raise InputError(f"got {type(found).__name__}", where=str(path), expected=f"a list of poses: {_EXPECTED}")
    return [(f"pose {i}", row) for i, row in enumerate(found, 1)]


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _pose(row: object, where: str) -> Pose:
    """Return the pose that a row is: a list of numbers, or a mapping of their names."""
    if isinstance(row, dict):
        names = next((names for names in (_RPY, _QUATERNION) if set(names) <= set(row)), None)
        if names is None:
            raise InputError(f"names {', '.join(map(str, row)):.80}", where=where, expected=_EXPECTED)
        row = [row[name] for name in names]
    if not isinstance(row, list) or len(row) not in (6, 7):
        what = f"{len(row)} numbers" if isinstance(row, list) else repr(row)[:40]
        raise InputError(what, where=where, expected=_EXPECTED)
    numbers = [_number(value, where) for value in row]
    x, y, z, *turn = numbers
    roll, pitch, yaw = turn if len(turn) == 3 else _rpy(turn, where)
    return x, y, z, roll, pitch, yaw


def _number(value: object, where: str) -> float:
    try:
        number = math.nan if isinstance(value, bool) else float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    return number if math.isfinite(number) else _refuse(value, where)


def _refuse(value: object, where: str) -> NoReturn:
    raise InputError(repr(value)[:40], where=where, expected="a finite number")


def _rpy(quaternion: Sequence[float], where: str) -> tuple[float, float, float]:
    """Return roll, pitch and yaw (rad) about fixed axes of a unit quaternion x, y, z, w."""
    norm = math.hypot(*quaternion)
    if abs(norm - 1.0) > _OFF_UNIT:
        raise InputError(f"a quaternion of length {norm:.4g}", where=where, expected="length 1")
    x, y, z, w = (value / norm for value in quaternion)
    # Entries of the rotation's matrix; where pitch is a right angle, roll and yaw turn alike, and roll is 0.
    sine = 2.0 * (w * y - x * z)
    if abs(sine) > 1.0 - 1e-12:
        return 0.0, math.copysign(0.5 * math.pi, sine), math.atan2(2.0 * (w * z - x * y), 1.0 - 2.0 * (x * x + z * z))
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return roll, math.asin(sine), yaw
