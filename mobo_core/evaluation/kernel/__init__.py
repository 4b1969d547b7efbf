"""The compiled kernel: a sweep over voxels and poses, many poses at once in lanes, all from flat arrays."""

from __future__ import annotations

from mobo_core.evaluation.kernel_sources import kernel_sources
from mobo_core.jit.cache import Cache

CACHE = Cache("kernel", kernel_sources(), nogil=True)
compiled = CACHE.compiled
