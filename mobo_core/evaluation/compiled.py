"""The kernel, compiled once per machine and kept in the user's cache folder."""

from __future__ import annotations

import atexit
import fcntl
import functools
import hashlib
import importlib.util
import inspect
import os
import shutil
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import TypeVar

from mobo_core.errors import UnableError

# Of all compiled functions, below mobo_core; the sampler's are kept in the same folder.
SOURCES = (
    *(f"evaluation/{name}.py" for name in ("numerics", "geometry", "kernel", "starts", "lanes", "sweep")),
    *(f"search/tpe/{name}.py" for name in ("arithmetic", "ranking", "history", "density")),
)

Loaded = TypeVar("Loaded")

# The kernel is written out joint by joint; beyond this, compiling it takes minutes.
MAX_JOINTS = 12

_HEADER = """\
# Made by mobo_core.evaluation.compiled; not to be edited.
import math

import numpy as np
from numba import njit

from mobo_core.evaluation.sweep import *

"""


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
        text.update((Path(__file__).parents[1] / name).read_bytes())
    base = Path(os.environ.get("MOBO_CACHE") or os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return base / "mobo" / f"kernel-{text.hexdigest()[:16]}"


def is_compiled(n: int = 6) -> bool:
    """Return whether this machine holds a compiled kernel for ``n`` joints that fits."""
    return (cache_folder() / f"complete_{n}").exists()


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
def kernel(n: int = 6, say: Callable[[str], None] = _to_stderr) -> ModuleType:
    """Return the compiled kernel for ``n`` joints: a module with the function ``evaluate_voxels``.

    Raises:
        UnableError: more than MAX_JOINTS joints.
    """
    if n > MAX_JOINTS:
        expected = f"at most {MAX_JOINTS}, or the reference engine"
        raise UnableError(f"{n} joints on the way to the tip", where="kernel", expected=expected)
    return compiled_once(f"the evaluation kernel for {n} joints", str(n), functools.partial(_load, n), say)


def compiled_once(what: str, name: str, load: Callable[[], Loaded], say: Callable[[str], None] = _to_stderr) -> Loaded:
    """Call ``load``, which compiles if the cache folder has nothing for it, and return what it returns.

    The first process on a machine compiles under a file lock; others wait for it. Both say so.
    """
    use_cache_folder()
    folder, complete = cache_folder(), cache_folder() / f"complete_{name}"
    try:
        lock = (folder / "lock").open("a")
    except OSError as error:
        say(f"mobo: cannot keep {what} compiled ({error.strerror}: {folder}); compiling for this process")
        return load()
    with lock:
        if not complete.exists():
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                say(f"mobo: waiting for another process that compiles {what} …")
                fcntl.flock(lock, fcntl.LOCK_EX)
            if not complete.exists():
                say(f"mobo: compiling {what}, once per machine …")
                loaded = load()
                complete.touch()
                return loaded
    return load()


def _load(n: int) -> ModuleType:
    """Import the generated module for ``n`` joints, writing it if it is not there, and call it once."""
    import numba

    from mobo_core.evaluation import lanes, sweep, warm_up

    name = f"mobo_kernel_{n}"
    path = Path(numba.config.CACHE_DIR) / f"{name}.py"  # type: ignore[attr-defined]
    if not path.exists():
        decorator = '@njit(cache=True, nogil=True, error_model="numpy")\n'
        functions = (
            lanes.lane_step_source(n),
            lanes.lane_forward_source(n),
            inspect.getsource(sweep.table_tips),
            inspect.getsource(sweep.evaluate_voxels),
        )
        part = path.with_suffix(f".{os.getpid()}")
        part.write_text(_HEADER + "\n\n".join(decorator + function for function in functions), encoding="utf-8")
        os.replace(part, path)
    found = importlib.util.spec_from_file_location(name, path)
    assert found is not None and found.loader is not None
    module = importlib.util.module_from_spec(found)
    sys.modules[name] = module  # Numba looks functions up by their module
    found.loader.exec_module(module)
    warm_up.run(module, n)
    return module
