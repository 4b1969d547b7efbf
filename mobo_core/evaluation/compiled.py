"""The kernel, compiled once per machine and kept in the user's cache folder."""

from __future__ import annotations

import atexit
import fcntl
import functools
import hashlib
import os
import shutil
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

SOURCES = ("numerics.py", "geometry.py", "kernel.py")


def cache_folder() -> Path:
    """Return the folder of the compiled kernel.

    Its name depends on all of the kernel's sources (Numba itself looks at one file at a time, and would
    keep a function whose callee changed), on Numba's version and on the processor it compiles for.
    """
    import numba
    from llvmlite import binding

    cpu = os.environ.get("NUMBA_CPU_NAME") or binding.get_host_cpu_name()
    features = os.environ.get("NUMBA_CPU_FEATURES") or ""
    text = hashlib.sha256(f"{numba.__version__} {sys.version_info[:2]} {cpu} {features}".encode())
    for name in SOURCES:
        text.update((Path(__file__).parent / name).read_bytes())
    base = Path(os.environ.get("MOBO_CACHE") or os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return base / "mobo" / f"kernel-{text.hexdigest()[:16]}"


def is_compiled() -> bool:
    """Return whether this machine holds a compiled kernel that fits."""
    return (cache_folder() / "complete").exists()


def use_cache_folder() -> None:
    """Have Numba keep what it compiles in :func:`cache_folder`, or in a folder of this process if it cannot.

    Called by the modules of compiled functions before the first of them: Numba settles where a function is
    kept as it decorates it, and would choose ``__pycache__`` otherwise.
    """
    import numba

    folder = cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        kept = os.access(folder, os.W_OK)
    except OSError:
        kept = False
    if not kept:
        folder = Path(tempfile.mkdtemp(prefix="mobo-kernel-"))
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
    numba.config.CACHE_DIR = str(folder)  # type: ignore[attr-defined]


def _to_stderr(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


@functools.cache
def kernel(say: Callable[[str], None] = _to_stderr) -> ModuleType:
    """Return the module :mod:`mobo_core.evaluation.kernel`, compiled.

    The first process on a machine compiles under a file lock; others wait for it. Both say so.
    """
    folder = cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = (folder / "lock").open("a")
    except OSError as error:
        say(f"mobo: cannot keep the compiled kernel ({error.strerror}: {folder}); compiling for this process")
        return _load()
    with lock:
        if not (folder / "complete").exists():
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                say("mobo: waiting for another process that compiles the evaluation kernel …")
                fcntl.flock(lock, fcntl.LOCK_EX)
            if not (folder / "complete").exists():
                say("mobo: compiling the evaluation kernel, once per machine …")
                module = _load()
                (folder / "complete").touch()
                return module
    return _load()


def _load() -> ModuleType:
    from mobo_core.evaluation import warm_up

    return warm_up.run()
