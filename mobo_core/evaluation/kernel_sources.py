"""The sources that the kernel's numbers come from. To import this loads neither them nor Numba."""

from __future__ import annotations

from pathlib import Path

from mobo_core.jit import cache


def kernel_sources() -> list[Path]:
    """Return the files that the compiled kernel is made of."""
    return [*(Path(__file__).parent / "kernel").glob("*.py"), Path(cache.__file__).with_name("numerics.py")]


def kernel_hash() -> str:
    """Return a hash of the kernel's sources and of what it is told: equal ones compute the same bits everywhere."""
    told = [Path(__file__).with_name(name) for name in ("effort.py", "tables.py")]
    return cache.Cache("kernel", [*kernel_sources(), *told]).source_hash()
