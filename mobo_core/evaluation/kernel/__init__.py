"""The compiled kernel: a sweep over voxels and poses, many poses at once in lanes, all from flat arrays."""

from __future__ import annotations

from pathlib import Path

from mobo_core.jit import numerics
from mobo_core.jit.cache import Cache

CACHE = Cache("kernel", [*Path(__file__).parent.glob("*.py"), numerics.__file__], nogil=True)
compiled = CACHE.compiled
