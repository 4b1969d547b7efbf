"""`mobo example`, the tables of docs/settings.md, and the advice before a study."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from mobo_core.commands.cli import main
from mobo_core.commands.fields import fields_of, table
from mobo_core.design import SPACES, DesignSpace, load_space
from mobo_core.evaluation import PRESETS, EvaluationSpec, load_spec
from mobo_core.evaluation.advice import joints_advice, space_advice
from mobo_core.settings import Settings

DOCS = Path(__file__).parents[1] / "docs" / "settings.md"
MODELS = (DesignSpace, EvaluationSpec)


@pytest.mark.parametrize(
    ("kind", "name"), [*(("space", name) for name in SPACES), *(("spec", name) for name in PRESETS)]
)
def test_an_example_reads_back_as_its_preset(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str, name: str
) -> None:
    """Printed to a file, each preset is the same settings again, and every field stands below its comment."""
    assert main(["example", kind, name]) == 0
    text = capsys.readouterr().out
    path = tmp_path / "example.yaml"
    path.write_text(text)
    expected: Settings = load_space(name) if kind == "space" else load_spec(name)
    assert (load_space(str(path)) if kind == "space" else load_spec(str(path))) == expected
    fields = list(type(expected).model_fields)
    assert list(yaml.safe_load(text)) == fields
    lines = text.splitlines()
    assert max(map(len, lines)) <= 120
    for field in fields:
        at = next(i for i, line in enumerate(lines) if line.startswith(f"{field}:"))
        assert lines[at - 1].startswith("# ")


def test_paper_unless_named(capsys: pytest.CaptureFixture[str]) -> None:
    """Without a name it is the paper's; an unknown one is refused with those that there are."""
    assert main(["example", "space"]) == 0
    assert DesignSpace.of(yaml.safe_load(capsys.readouterr().out)) == DesignSpace()
    assert main(["example", "spec", "desk"]) == 2
    assert "no preset 'desk'; expected paper or paper_fine or mobo" in capsys.readouterr().err


@pytest.mark.parametrize("model", MODELS)
def test_every_field_is_explained(model: type[Settings]) -> None:
    """Each has a meaning and the values it takes."""
    for field in fields_of(model):
        assert len(field.meaning) >= 1 and field.values, field.name


@pytest.mark.parametrize("model", MODELS)
def test_docs_have_all_fields(model: type[Settings], capsys: pytest.CaptureFixture[str]) -> None:
    """The tables in docs/settings.md are those that `mobo example … --table` prints."""
    assert table(model) in DOCS.read_text(encoding="utf-8")
    assert main(["example", "space" if model is DesignSpace else "spec", "--table"]) == 0
    assert capsys.readouterr().out == table(model)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({}, ""),
        ({"n_joints": 5}, "5 joints can hardly meet orientation and position, which take 6"),
        ({"total_length": 0.2}, "of 75 voxel centres lie farther from the base than the arm's 0.2 m"),
        ({"joint_types": "Y"}, "joint_types Y builds YPYPYP alone"),
        ({"joint_types": "YR"}, "joints P are built too, though YR are drawn: after a yaw comes a pitch"),
        ({"joint_types": "P"}, "joint_types P builds PPPPPP alone"),
        ({"joint_types": "PY"}, ""),
    ],
)
def test_advice_on_a_space(values: dict[str, object], words: str) -> None:
    """A line says what arms of the space can hardly do, or are built as; the paper's space needs none."""
    line = space_advice(DesignSpace.of(values), EvaluationSpec())
    assert "\n" not in line
    assert (words in line) if words else line == ""


def test_advice_on_an_arm(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """`mobo evaluate` says what an order is built as, and that few joints reach little, beside its output."""
    assert joints_advice(6, EvaluationSpec()) == []
    (tmp_path / "spec.yaml").write_text("poses_per_voxel: 1\nrestarts: 0\niterations: 5\n")
    arm = ["evaluate", "--lengths", "0.1,0.1,0.1,0.1,0.1,0.1", "--spec", str(tmp_path / "spec.yaml"), "--json"]
    assert main([*arm, "--joints", "YYPPRP"]) == 0
    captured = capsys.readouterr()
    assert "note: YYPPRP is built as YPPPRP: after a yaw comes a pitch" in captured.err
    assert captured.out.startswith("{")
    assert main([*arm, "--joints", "YPPPRP"]) == 0
    assert "note" not in capsys.readouterr().err
    assert main([*arm, "--joints", "YP", "--lengths", "0.3,0.3", "--engine", "reference"]) == 0
    assert "note: 2 joints can hardly meet orientation and position" in capsys.readouterr().err
    (tmp_path / "spec.yaml").write_text("poses_per_voxel: 1\nrestarts: 0\nworkspace_max: [4.5, 0.5, 0.5]\n")
    assert main([*arm, "--joints", "YPPPRP"]) == 0
    assert "of 375 voxel centres lie farther from the base than the arm reaches" in capsys.readouterr().err
