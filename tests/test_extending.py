"""The recipes of docs/extending.md: each is taken from the page, built, and used."""

from __future__ import annotations

import re
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any

import pytest
from studies import mobo, run_study

from mobo_core.design import JOINTS
from mobo_core.evaluation.objectives import OBJECTIVES
from mobo_core.registry import Registry
from mobo_core.report.figures.registry import FIGURES
from mobo_core.search import contract
from mobo_core.search.samplers.registry import SAMPLERS

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8")
SAMPLE = ROOT / "bags" / "sample" / "paper_6"
QUICK: dict[str, Any] = {"spec": {"poses_per_voxel": 2}, "n_startup_trials": 4, "sampler": "random"}
RECIPES: dict[str, tuple[Registry[Any], str]] = {
    "Joint type": (JOINTS, "K"),
    "Objective": (OBJECTIVES, "dexterous"),
    "Sampler": (SAMPLERS, "optuna_tpe"),
    "Figure": (FIGURES, "seconds"),
}


def recipe(heading: str) -> tuple[str, dict[str, str]]:
    """Return a section of the page, and the files that it shows."""
    sections = dict(part.split("\n", 1) for part in PAGE.split("\n## ")[1:])
    text = sections[heading]
    return text, dict(re.findall(r"^```\w+ (\S+)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL))


@pytest.fixture(autouse=True)
def distribution(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Build the distribution of the recipe that the test names, and put the wheel's content on the path."""
    heading = request.node.get_closest_marker("recipe").args[0]
    source, site = tmp_path / "source", tmp_path / "site"
    for name, content in recipe(heading)[1].items():
        (source / name).parent.mkdir(parents=True, exist_ok=True)
        (source / name).write_text(content, encoding="utf-8")
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(tmp_path / "wheel")]
    subprocess.run(build, cwd=source, check=True, capture_output=True)
    (wheel,) = (tmp_path / "wheel").glob("*.whl")
    zipfile.ZipFile(wheel).extractall(site)
    monkeypatch.syspath_prepend(str(site))
    registry, name = RECIPES[heading]
    monkeypatch.setattr(registry, "_complete", False)
    monkeypatch.setattr(registry, "_entries", {entry.name: entry for entry in registry.built_in})
    assert name in registry and name not in [entry.name for entry in registry.built_in]


@pytest.mark.slow
@pytest.mark.recipe("Joint type")
def test_joint_type(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A study with it runs on the kernel, verifies and is reported."""
    settings = QUICK | {"space": {"joint_types": "KPY"}}
    bag = run_study(tmp_path / "bag", 6, settings=settings, engine="kernel")
    assert mobo("verify", bag, "--workers", 1) == 0
    assert mobo("report", bag, "-o", tmp_path / "report") == 0
    assert mobo("evaluate", "--joints", "KPYPKP", "--lengths", "0.1,0.1,0.1,0.1,0.1,0.1") == 0


@pytest.mark.recipe("Objective")
def test_objective() -> None:
    """An evaluation measures it: at least half of the poses of so many voxels."""
    from mobo_core.design import Design, DesignSpace, to_urdf
    from mobo_core.evaluation import EvaluationSpec
    from mobo_core.evaluation.evaluate import evaluate

    urdf = to_urdf(Design("YPPYPY", (0.05, 0.25, 0.2, 0.05, 0.0, 0.05)), DesignSpace())
    result = evaluate(urdf, EvaluationSpec(), objectives=("reach", "torque", "dexterous"))
    assert result.extra == {"dexterous": float((result.voxel_reach >= 0.5).sum())}
    assert 0 < result.extra["dexterous"] < 75


@pytest.mark.slow
@pytest.mark.recipe("Sampler")
def test_sampler(tmp_path: Path) -> None:
    """It keeps the contract; a study with it runs and verifies."""
    for settings in contract.cases("optuna_tpe"):
        for check in contract.CHECKS:
            check(settings)
    bag = run_study(tmp_path / "bag", 8, settings=QUICK | {"sampler": "optuna_tpe"}, engine="kernel")
    assert mobo("verify", bag, "--workers", 1) == 0


@pytest.mark.slow
@pytest.mark.recipe("Figure")
def test_figure(tmp_path: Path) -> None:
    """It is in the report's folder and on its page."""
    assert mobo("report", SAMPLE, "-o", tmp_path / "report") == 0
    assert (tmp_path / "report" / "seconds.png").is_file()
    assert "<h2>How long evaluations took</h2>" in (tmp_path / "report" / "index.html").read_text(encoding="utf-8")


@pytest.mark.recipe("Figure")
@pytest.mark.parametrize("heading", RECIPES)
def test_a_recipe_is_under_a_page(heading: str) -> None:
    """Its module has some twenty lines, its text fits on a page of 60."""
    text, files = recipe(heading)
    assert {name.rsplit(".")[-1] for name in files} >= {"toml", "py"}
    assert sum(len(content.split("\n")) for name, content in files.items() if name.endswith(".py")) <= 25
    assert len(text.split("\n")) <= 60
