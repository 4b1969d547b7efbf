"""A search of structures: each joint order with an archive and a model of its own, and a policy that shares trials."""

from __future__ import annotations

from pathlib import Path

from mobo_core.jit import functions, numerics
from mobo_core.jit.cache import Cache

CACHE = Cache("structured", [*Path(__file__).parent.glob("*.py"), functions.__file__, numerics.__file__])
compiled = CACHE.compiled
