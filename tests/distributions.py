"""Distributions for tests: made in a folder, found by mobo's registries for as long as a test runs."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest

from mobo_core.registry import Registry


def install(
    folder: Path, monkeypatch: pytest.MonkeyPatch, registry: Registry[Any], module: str, source: str, **entries: str
) -> None:
    """Put a distribution of one module on the path, whose entry points for ``registry`` are ``entries``."""
    info = folder / f"{module}-1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {module}\nVersion: 1\n")
    points = "".join(f"{name} = {module}:{attribute}\n" for name, attribute in entries.items())
    (info / "entry_points.txt").write_text(f"[{registry.group}]\n{points}")
    (folder / f"{module}.py").write_text(source)
    monkeypatch.syspath_prepend(str(folder))
    monkeypatch.delitem(sys.modules, module, raising=False)
    # As in a new process, and as before once the test is over.
    monkeypatch.setattr(registry, "_complete", False)
    monkeypatch.setattr(registry, "_entries", {entry.name: entry for entry in registry.built_in})


