"""``mobo doctor``: whether this machine has what mobo needs, a line each."""

from __future__ import annotations

import argparse
import importlib.util
import os
import platform
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from mobo_core.commands.parsing import Verbs
from mobo_core.jit.cache import Cache

_WHEELS = ("pin", "coal", "xacro", "numba", "optuna", "mcap", "rosbags")
_ENOUGH_DISK_GB = 2.0
_ROUND_TRIP_S = 30.0

Finding = tuple[bool, str]


def add(verbs: Verbs) -> None:
    """Add the verb's parser."""
    parser = verbs.add_parser(
        "doctor",
        help="check this machine",
        description="Check Python, libraries, compiler, compiled kernel and sampler, ROS 2 messages and disk: "
        "a line each. Exit code 1 if something is missing.",
        epilog="examples:\n  mobo doctor\n  mobo doctor --warm",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--warm", action="store_true", help="only compile the kernel and the samplers, if need be")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Check and print."""
    if args.warm:
        from mobo_core.evaluation.kernel.load import kernel
        from mobo_core.search.samplers.by_order import structured_sampler
        from mobo_core.search.samplers.parzen import fast_tpe

        for n in (6, 7):
            kernel(n)
        structured_sampler()
        fast_tpe()
        return 0
    checks: tuple[tuple[str, Callable[[], Finding]], ...] = (
        ("python", _python),
        ("libraries", _libraries),
        ("compiler", _compiler),
        ("kernel", _kernel),
        ("sampler", _sampler),
        ("ros 2", _ros),
        ("dds", _dds),
        ("disk", _disk),
    )
    good = True
    for name, check in checks:
        fine, text = check()
        good = good and fine
        print(f"{'ok  ' if fine else 'FAIL'}  {name:10} {text}", flush=True)
    return 0 if good else 1


def _python() -> Finding:
    fine = (3, 11) <= sys.version_info[:2] <= (3, 12) and platform.machine() == "x86_64"
    text = f"{platform.python_version()} on {platform.machine()} {platform.system()}"
    return fine, text if fine else f"{text}; expected 3.11 or 3.12 on x86_64 Linux"


def _libraries() -> Finding:
    found, missing = [], []
    for name in _WHEELS:
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            missing.append(name)
    return not missing, f"missing: {', '.join(missing)}; make setup installs them" if missing else ", ".join(found)


def _compiler() -> Finding:
    tools = ("gcc", "g++", "cmake", "make")
    missing = [tool for tool in tools if shutil.which(tool) is None]
    return not missing, f"missing: {', '.join(missing)}" if missing else ", ".join(tools)


def _kernel() -> Finding:
    from mobo_core.evaluation.kernel import CACHE
    from mobo_core.evaluation.kernel.load import kernel

    return loaded(CACHE, "6", kernel)


def _sampler() -> Finding:
    from mobo_core.search.samplers.by_order import structured_sampler
    from mobo_core.search.samplers.structured import CACHE

    return loaded(CACHE, "sampler", structured_sampler)


def loaded(cache: Cache, part: str, load: Callable[[], object]) -> Finding:
    """Load compiled functions; say how long it took and where they are kept."""
    before = cache.is_complete(part)
    began = time.perf_counter()
    load()
    text = f"{'loaded' if before else 'compiled'} in {time.perf_counter() - began:.1f} s"
    if cache.kept is None:
        return False, f"{text}, for this process alone: {cache.folder()} cannot be written; MOBO_CACHE names another"
    return True, f"{text}, kept in {cache.kept}"


def _ros() -> Finding:
    if os.environ.get("AMENT_PREFIX_PATH") and shutil.which("ros2") and _has("rclpy") and _has("mobo"):
        return True, f"{shutil.which('ros2')}, nodes of mobo found"
    return False, "not sourced; expected: source .venv/bin/activate && source install/setup.bash"


def _has(module: str) -> bool:
    return importlib.util.find_spec(module) is not None


def _dds() -> Finding:
    if not (_has("rclpy") and _has("mobo")):
        return False, "not tried, see ros 2"
    # In a process of its own: nothing in here imports ROS.
    command = [sys.executable, "-m", "mobo.round_trip"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=_ROUND_TRIP_S, check=False)
    except subprocess.TimeoutExpired:
        return False, f"no answer within {_ROUND_TRIP_S:g} s"
    lines = (done.stdout if done.returncode == 0 else done.stderr).strip().splitlines()
    return done.returncode == 0, lines[-1] if lines else f"round trip ended with {done.returncode}"


def _disk() -> Finding:
    free = shutil.disk_usage(Path.cwd()).free / 1e9
    # About 2.6 kB a trial, see README.
    return free > _ENOUGH_DISK_GB, f"{free:.0f} GB free here; a study of 20,000 trials takes about 0.1"
