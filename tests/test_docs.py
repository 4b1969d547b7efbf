"""What the pages for people name is there."""

from __future__ import annotations

import pkgutil
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PAGES = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "examples/README.md")),
    *sorted((ROOT / "docs").rglob("*.md")),
]
FILES = [
    path.relative_to(ROOT).as_posix()
    for folder in ("mobo_core", "ros_pkgs", "tests", "docs", "xacro", "bags", "examples")
    for path in (ROOT / folder).rglob("*")
    if "__pycache__" not in path.parts
]
TESTS = {
    name
    for path in (ROOT / "tests").rglob("test_*.py")
    for name in re.findall(r"def (test_\w+)", path.read_text(encoding="utf-8"))
}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_names_only_what_is_there(page: Path) -> None:
    """Source files, folders of mobo_core, modules, tests in backticks; pages and pictures it links to."""
    text = page.read_text(encoding="utf-8")
    gone = []
    for code in re.findall(r"`([^`\n]+)`", text):
        gone += [name for name in re.findall(r"\b(test_\w+)\b(?!\.py|/)", code) if name not in TESTS]
        for path in re.findall(r"(?:[\w.-]+/)*[\w.-]+\.(?:py|msg|xacro|json)\b|\bmobo_core(?:/\w+)+/?", code):
            name = path.rstrip("/")
            if not any(f"/{file}".endswith(f"/{name}") for file in FILES):
                gone.append(path)
        for dotted in re.findall(r"\bmobo_core(?:\.\w+)+", code):
            try:
                pkgutil.resolve_name(dotted)
            except (ImportError, AttributeError):
                gone.append(dotted)
    links = [link for link in re.findall(r"\]\(([^)#\s]+)", text) if "://" not in link]
    gone += [link for link in links if not (page.parent / link).exists()]
    assert not gone
