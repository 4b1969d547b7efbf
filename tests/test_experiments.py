"""The scripts behind the tables of docs/: that they start, and that their README names them."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[1] / "docs" / "experiments"
SCRIPTS = sorted(path for path in FOLDER.glob("*.py") if "ArgumentParser" in path.read_text(encoding="utf-8"))


@pytest.mark.slow
def test_every_script_says_how_it_is_called() -> None:
    """``--help`` prints its usage, with nothing that it imports missing or moved."""
    started = [
        (path, subprocess.Popen([sys.executable, path, "--help"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT))
        for path in SCRIPTS
    ]
    assert len(started) >= 6
    for path, process in started:
        out, _ = process.communicate()
        assert process.returncode == 0 and out.startswith(f"usage: {path.name}".encode()), out.decode()


def test_the_readme_names_every_script_and_documents_that_are_there() -> None:
    """No script is left out; no link leads nowhere."""
    text = (FOLDER / "README.md").read_text(encoding="utf-8")
    assert all(f"`{path.name}`" in text for path in FOLDER.glob("*.py"))
    documents = {word.split(")")[0] for word in text.split("](")[1:]}
    assert documents and all((FOLDER / document).is_file() for document in documents)
