"""Loads the compiled kernel: a generated module for each number of joints."""

from __future__ import annotations

import functools
import importlib.util
import inspect
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

from mobo_core.errors import UnableError
from mobo_core.evaluation.kernel import CACHE, complete, lanes, sweep, warm_up
from mobo_core.outputs import replace_whole

# The kernel is written out joint by joint; beyond this, compiling it takes minutes.
MAX_JOINTS = 12

_HEADER = """\
# Made by mobo_core.evaluation.kernel.load; not to be edited.
import math

import numpy as np

from mobo_core.evaluation.kernel import compiled
from mobo_core.evaluation.kernel.complete import *
from mobo_core.evaluation.kernel.sweep import *

"""


# What the generated modules hold besides the lanes, in this order.
_PARTS = (
    sweep.lane_state, sweep.any_ends, sweep.table_tips, sweep.evaluate_voxels, complete.table_places,
    complete.evaluate_voxels_complete,
)  # fmt: skip


def is_compiled(n: int = 6) -> bool:
    """Return whether this machine holds a compiled kernel for ``n`` joints that fits."""
    return CACHE.is_complete(str(n))


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
    return CACHE.once(f"the evaluation kernel for {n} joints", str(n), functools.partial(_load, n), say)


def _load(n: int) -> ModuleType:
    """Make the generated module for ``n`` joints and call it once."""
    module = _kept(n, CACHE.kept) if CACHE.kept is not None else _of_this_process(n)
    warm_up.run(module, n)
    return module


def _source(n: int) -> str:
    functions = (
        lanes.lane_step_source(n),
        lanes.lane_forward_source(n),
        *("@compiled\n" + inspect.getsource(part) for part in _PARTS),
    )
    return _HEADER + f"STATE = {lanes.state_size(n)}\n\n\n" + "\n\n".join(functions)


def _kept(n: int, folder: Path) -> ModuleType:
    """Import the module from a file, without which Numba keeps nothing; write it if it is not there."""
    name = f"mobo_kernel_{n}"
    path = folder / f"{name}.py"
    if not path.exists():
        replace_whole(path, _source(n).encode())
    found = importlib.util.spec_from_file_location(name, path)
    assert found is not None and found.loader is not None
    module = importlib.util.module_from_spec(found)
    sys.modules[name] = module  # Numba looks functions up by their module
    found.loader.exec_module(module)
    return module


def _of_this_process(n: int) -> ModuleType:
    module = ModuleType(f"mobo_kernel_{n}")
    sys.modules[module.__name__] = module
    exec(compile(_source(n), f"<{module.__name__}>", "exec"), module.__dict__)
    return module
