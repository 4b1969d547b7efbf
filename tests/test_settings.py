"""Settings written as YAML by people, and by others."""

from __future__ import annotations

from pathlib import Path

import pytest

from mobo_core.errors import InputError
from mobo_core.evaluation import EvaluationSpec
from mobo_core.search.study import StudySettings

LAUGHS = "a0: &a0 [ha, ha, ha]\n" + "".join(f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]\n" for i in range(1, 12))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        pytest.param(LAUGHS + "gravity: *a11\n", "not YAML ('more than 20,000 values')", id="bomb of aliases"),
        pytest.param(LAUGHS, "not YAML ('more than 20,000 values')", id="bomb in an unknown field"),
        pytest.param("[" * 50_000, "not YAML", id="deep"),
        pytest.param("seed: " + "9" * 50_000, "not YAML", id="many digits"),
        pytest.param(
            "seed: 0x" + "f" * 50_000, "not YAML ('a word of 50,002 characters')", id="many hexadecimal digits"
        ),
        pytest.param("seed: !!int x", "not YAML", id="no integer"),
        pytest.param("voxel_size: !!float x", "not YAML", id="no number"),
        pytest.param("seed: 2024-13-45", "not YAML", id="no date"),
        pytest.param("seed: 2024-12-24", "seed = datetime.date(2024, 12, 24)", id="a date"),
        pytest.param("seed: !!python/object/apply:os.getpid []", "not YAML", id="an object"),
        pytest.param("? [a]\n: 1", "not YAML", id="a list for a name"),
    ],
)
def test_bad_yaml(tmp_path: Path, text: str, words: str) -> None:
    """Whatever a YAML file holds, the answer is a short one-line error with its path."""
    path = tmp_path / "spec.yaml"
    path.write_text(text)
    with pytest.raises(InputError) as error:
        EvaluationSpec.from_yaml(path)
    said = str(error.value)
    assert said.startswith(f"{path}: {words}") or words in said
    assert said == " ".join(said.split())
    assert len(said) < 500


def test_unknown_fields_within() -> None:
    """An unknown field of settings within settings is answered with the names that are known there."""
    with pytest.raises(InputError, match=r"unknown field 'space\.arms'; expected one of n_joints, joint_types"):
        StudySettings.of({"space": {"arms": 6}})
    with pytest.raises(InputError, match="unknown field 'joints'; expected one of space, spec, objectives, sampler"):
        StudySettings.of({"joints": 6})
