"""Long tests of faults, run by `make test-faults` alone: what they need of the machine, and what it lacks.

File names here differ from those in tests/, whose helpers (nodes, studies, …) can be imported.
"""

from __future__ import annotations

import functools
import os
import shutil
import subprocess

import pytest


def _runs(*command: str) -> bool:
    try:
        return subprocess.run(command, capture_output=True, timeout=20, check=False).returncode == 0
    except (OSError, subprocess.TimeoutExpired):
        return False


# What `@pytest.mark.needs("root", "iptables")` may name, and whether it is here.
_CHECKS = {
    "root": lambda: os.geteuid() == 0,
    "ip": lambda: shutil.which("ip") is not None,
    "iptables": lambda: shutil.which("iptables") is not None,
    "network namespaces": lambda: _runs("unshare", "--net", "true"),
    "tmpfs": lambda: _runs("unshare", "--mount", "mount", "-t", "tmpfs", "none", "/mnt"),
}


@functools.cache
def has(name: str) -> bool:
    """Return whether this machine has what a test may need."""
    return _CHECKS[name]()


def pytest_report_header() -> str:
    lacking = [name for name in _CHECKS if not has(name)]
    return f"faults: this machine lacks {', '.join(lacking)}" if lacking else "faults: this machine lacks nothing"


def pytest_runtest_setup(item: pytest.Item) -> None:
    wanted = [name for marker in item.iter_markers("needs") for name in marker.args]
    if lacking := [name for name in wanted if not has(name)]:
        pytest.skip(f"lacks {', '.join(lacking)}")
