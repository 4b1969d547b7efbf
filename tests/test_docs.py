"""What the pages in docs/ and the README name is there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
FILES = [
    path.relative_to(ROOT).as_posix()
    for folder in ("mobo_core", "ros_pkgs", "tests", "docs", "xacro", "bags")
    for path in (ROOT / folder).rglob("*")
    if "__pycache__" not in path.parts
]
TESTS = {
    name
    for path in (ROOT / "tests").rglob("test_*.py")
    for name in re.findall(r"def (test_\w+)", path.read_text(encoding="utf-8"))
}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
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
        for module in re.findall(r"\bmobo_core(?:\.\w+)+", code):
            path = module.replace(".", "/")
            if not any(name in FILES for name in (path, f"{path}.py", f"{path.rpartition('/')[0]}.py")):
                gone.append(module)
    links = [link for link in re.findall(r"\]\(([^)#\s]+)", text) if "://" not in link]
    gone += [link for link in links if not (page.parent / link).exists()]
    assert not gone
