"""Products of 3 x 3 matrices, written out: a BLAS may round differently from machine to machine."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobo_core.jit.cache import interpreted
from mobo_core.jit.numerics import sin_cos

Vector = Sequence[float] | NDArray[np.float64]
Matrix = Sequence[Sequence[float]] | NDArray[np.float64]


def axis_frame(axis: Vector) -> list[list[float]]:
    """Return a rotation whose z column is ``axis``; a signed permutation if the axis is one of x, y, z."""
    k = min(range(3), key=lambda i: abs(axis[i]))
    x = [(1.0 if i == k else 0.0) - axis[k] * axis[i] for i in range(3)]
    norm = math.sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])
    x = [v / norm for v in x]
    y = [axis[(i + 1) % 3] * x[(i + 2) % 3] - axis[(i + 2) % 3] * x[(i + 1) % 3] for i in range(3)]
    return [[x[i], y[i], axis[i]] for i in range(3)]


def rpy_matrix(rpy: Vector) -> list[list[float]]:
    """Return the rotation by roll, pitch and yaw (rad) about fixed axes, as URDF has them."""
    (sr, cr), (sp, cp), (sy, cy) = (interpreted(sin_cos)(float(angle)) for angle in rpy)
    return [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]


def _numbers(a: Any) -> Any:
    """Return an array as lists: Python's own floats are added ten times as fast as NumPy's, with the same bits."""
    return a.tolist() if isinstance(a, np.ndarray) else a


def matmul(a: Matrix, b: Matrix) -> list[list[float]]:
    """Return the product a b."""
    a, (b0, b1, b2) = _numbers(a), _numbers(b)
    # Python's sum() rounds otherwise from 3.12 on. The first 0.0 makes 0.0 of -0.0, as it does.
    return [[0.0 + x * b0[j] + y * b1[j] + z * b2[j] for j in range(3)] for x, y, z in a]


def matvec(a: Matrix, v: Vector) -> list[float]:
    """Return the product of a matrix and a vector."""
    v0, v1, v2 = _numbers(v)
    return [x * v0 + y * v1 + z * v2 for x, y, z in _numbers(a)]


def transposed(a: Matrix) -> list[list[float]]:
    """Return the transposed matrix."""
    return [list(column) for column in zip(*_numbers(a), strict=True)]


def norm(p: Vector) -> float:
    """Return the length of a vector."""
    return math.sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2])
