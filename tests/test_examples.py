"""Every example runs, and prints what it is about."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"
SAID = {
    "evaluate_an_arm": "best voxel: centre",
    "run_a_study": "60 trials told",
    "payload": "1.00 kg  reach",
    "three_objectives": "'peak_torque': ",
    "check_a_bag": "StudyRecord('paper_6': 60 trials told, 1 failed;",
}

pytestmark = [pytest.mark.slow, pytest.mark.skipif(not EXAMPLES.is_dir(), reason="no checkout")]


def test_all_examples_are_known() -> None:
    """The page of the examples, this test and the folder name the same ones."""
    scripts = {path.stem for path in EXAMPLES.glob("*.py")}
    page = (EXAMPLES / "README.md").read_text()
    assert scripts == set(SAID) and all(f"examples/{name}.py" in page for name in scripts)


@pytest.mark.parametrize("name", SAID)
def test_a_script(name: str, tmp_path: Path) -> None:
    """It ends well, and what it prints has what the page promises."""
    where = [str(tmp_path)] if name in ("run_a_study", "three_objectives") else []
    command = [sys.executable, str(EXAMPLES / f"{name}.py"), *where]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False, cwd=EXAMPLES.parent)
    assert done.returncode == 0, done.stderr
    assert SAID[name] in done.stdout


def test_the_notebook(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its cells run one after the other, and the last one is an arm's worth."""
    monkeypatch.chdir(EXAMPLES)
    cells = json.loads((EXAMPLES / "study.ipynb").read_text())["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    names: dict[str, object] = {}
    for text in code[:-1]:
        exec(compile(text, "study.ipynb", "exec"), names)
    *before, last = code[-1].splitlines()
    exec(compile("\n".join(before), "study.ipynb", "exec"), names)
    assert "of 600 voxels" in repr(eval(last, names))
