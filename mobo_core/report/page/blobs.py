"""Arrays inside a page: packed one after the other, compressed, as text."""

from __future__ import annotations

import base64
import gzip
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_ALIGN = 8  # bytes; a typed array of JavaScript begins at a multiple of its numbers' size


@dataclass(frozen=True)
class Blob:
    """Packed arrays.

    Attributes:
        places: name -> type of the numbers as NumPy spells it, first byte, count.
        text: gzip, base64.
    """

    places: dict[str, tuple[str, int, int]]
    text: str


def pack(arrays: Mapping[str, NDArray[np.generic]]) -> Blob:
    """Pack arrays, flattened by rows; the same arrays give the same text."""
    places: dict[str, tuple[str, int, int]] = {}
    data = bytearray()
    for name, array in arrays.items():
        little = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<"))
        places[name] = (f"{array.dtype.kind}{array.dtype.itemsize}", len(data), int(array.size))
        data += little.tobytes()
        data += bytes(-len(data) % _ALIGN)
    return Blob(places, compressed(bytes(data)))


def compressed(data: bytes) -> str:
    """Return bytes as the page holds them."""
    return base64.b64encode(gzip.compress(data, 6, mtime=0)).decode("ascii")
