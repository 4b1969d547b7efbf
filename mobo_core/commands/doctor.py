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

_WHEELS = ("pin", "coal", "xacro", "numba", "optuna", "mcap", "rosbags")
_ENOUGH_DISK_GB = 2.0
_ROUND_TRIP_S = 30.0


def add(verbs: Verbs) -> None:
    """Add the verb's parser."""
    parser = verbs.add_parser(
        "doctor",
        help="check this machine",
        description="Check Python, libraries, compiler, compiled kernel, ROS 2 messages and disk: a line each. "
        "Exit code 1 if something is missing.",
        epilog="examples:\n  mobo doctor\n  mobo doctor --warm",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--warm", action="store_true", help="only compile the kernel and the sampler, if need be")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Check and print."""
    if args.warm:
        from mobo_core.evaluation.kernel.load import kernel
        from mobo_core.search.samplers.parzen import fast_tpe

        for n in (6, 7):
            kernel(n)
        fast_tpe()
        return 0
    checks: tuple[tuple[str, Callable[[], tuple[bool, str]]], ...] = (
        ("python", _python),
        ("libraries", _libraries),
        ("compiler", _compiler),
        ("kernel", _kernel),
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


def _python() -> tuple[bool, str]:
    fine = (3, 11) <= sys.version_info[:2] <= (3, 12) and platform.machine() == "x86_64"
    text = f"{platform.python_version()} on {platform.machine()} {platform.system()}"
    return fine, text if fine else f"{text}; expected 3.11 or 3.12 on x86_64 Linux"


def _libraries() -> tuple[bool, str]:
    found, missing = [], []
    for name in _WHEELS:
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            missing.append(name)
    return not missing, f"missing: {', '.join(missing)}; make setup installs them" if missing else ", ".join(found)


def _compiler() -> tuple[bool, str]:
    tools = ("gcc", "g++", "cmake", "make")
    missing = [tool for tool in tools if shutil.which(tool) is None]
    return not missing, f"missing: {', '.join(missing)}" if missing else ", ".join(tools)


def _kernel() -> tuple[bool, str]:
    from mobo_core.evaluation.kernel import CACHE
    from mobo_core.evaluation.kernel.load import is_compiled, kernel

    before = is_compiled()
    began = time.perf_counter()
    kernel()
    how = "loaded" if before else "compiled"
    return True, f"{how} in {time.perf_counter() - began:.1f} s, kept in {CACHE.folder()}"


def _ros() -> tuple[bool, str]:
    if os.environ.get("AMENT_PREFIX_PATH") and shutil.which("ros2") and _has("rclpy") and _has("mobo"):
        return True, f"{shutil.which('ros2')}, nodes of mobo found"
    return False, "not sourced; expected: source .venv/bin/activate && source install/setup.bash"


def _has(module: str) -> bool:
    return importlib.util.find_spec(module) is not None


def _dds() -> tuple[bool, str]:
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


def _disk() -> tuple[bool, str]:
    free = shutil.disk_usage(Path.cwd()).free / 1e9
    # About 2.6 kB a trial, see README.
    return free > _ENOUGH_DISK_GB, f"{free:.0f} GB free here; a study of 20,000 trials takes about 0.1"
