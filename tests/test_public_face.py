"""The public face: names, and a study in this process."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from nodes import QUICK_SPEC, values
from studies import run_study as run_by_hand

import mobo_core as mobo
from mobo_core.errors import InputError
from mobo_core.messages import EvaluatorStatus

QUICK = {"spec": yaml.safe_load(QUICK_SPEC), "n_startup_trials": 6}


def test_every_public_name_is_there_and_light() -> None:
    """All names load, whatever rooms were imported before; importing the package alone loads no heavy library."""
    program = (
        "import sys, mobo_core\n"
        "print(sorted({'numba', 'pinocchio', 'optuna', 'matplotlib', 'pydantic'} & sys.modules.keys()))\n"
        "import mobo_core.report.table, mobo_core.verify.verify\n"
        "print(all(callable(getattr(mobo_core, name)) for name in mobo_core.__all__ if name[0] != '_'))\n"
        "print(set(mobo_core.__all__) <= set(dir(mobo_core)))\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.split("\n")[:3] == ["[]", "True", "True"]
    with pytest.raises(AttributeError, match="no attribute 'optimise'"):
        mobo.optimise  # noqa: B018


@pytest.mark.slow
def test_a_study_in_this_process(tmp_path: Path) -> None:
    """It has the trials that any study of its settings has, to the bit; stopped half-way and resumed, too."""
    settings, n = mobo.StudySettings.of(QUICK), 14
    expected = values(run_by_hand(tmp_path / "by_hand", n, settings=QUICK, engine="kernel"))
    seen: list[int] = []
    study = mobo.run_study(settings, n, bag=tmp_path / "whole", workers=2, progress=lambda told, _: seen.append(told))
    assert values(tmp_path / "whole") == expected
    assert repr(study) == f"StudyRecord('study': 14 trials told; {tmp_path / 'whole'})"
    assert seen == sorted(seen) and seen[-1] == n
    states = [status.state for status in study.evaluators]
    assert states == [EvaluatorStatus.JOINED, EvaluatorStatus.LEFT]
    assert study.evaluators[0].kernel_hash and "peak_torque" in study.evaluators[0].objectives

    def interrupt(told: int, _: int) -> None:
        if told >= 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        mobo.run_study(settings, n, bag=tmp_path / "half", progress=interrupt)
    with pytest.raises(InputError, match="exists already"):
        mobo.run_study(settings, n, bag=tmp_path / "half")
    half = mobo.read_study(tmp_path / "half")
    assert 5 <= len(half.trials) < n and not half.faults
    mobo.run_study(None, n, bag=tmp_path / "half", resume=True)  # its settings are the bag's
    assert values(tmp_path / "half") == expected
    assert not mobo.verify(tmp_path / "half").faults


def test_a_design_is_evaluated_as_its_urdf() -> None:
    """A design, with the masses and limits of a space, gives what its description gives."""
    from mobo_core.design import to_urdf

    design, space = mobo.Design("YPPYPY", (0.05, 0.25, 0.2, 0.05, 0.0, 0.05)), mobo.DesignSpace(motor_mass=0.4)
    spec = mobo.EvaluationSpec.of(QUICK["spec"])
    by_design, by_urdf = mobo.evaluate(design, spec, space=space), mobo.evaluate(to_urdf(design, space), spec)
    assert (by_design.reach, by_design.torque) == (by_urdf.reach, by_urdf.torque)
    assert by_design.reach > 0


@pytest.mark.parametrize("wrong", [{"n_trials": 0}, {"workers": 0}, {"threads": -1}])
def test_numbers_that_are_none(wrong: dict[str, int], tmp_path: Path) -> None:
    """They are refused before anything is made."""
    with pytest.raises(InputError, match="expected 1 or more"):
        mobo.run_study(bag=tmp_path / "bag", **wrong)  # type: ignore[arg-type]
    assert not (tmp_path / "bag").exists()
