"""Tree-structured Parzen estimator for two objectives, at the speed that thousands of trials ask for."""

from __future__ import annotations

from pathlib import Path

from mobo_core.jit import functions, normal
from mobo_core.jit.cache import Cache

CACHE = Cache("tpe", [*Path(__file__).parent.glob("*.py"), functions.__file__, normal.__file__])
compiled = CACHE.compiled
