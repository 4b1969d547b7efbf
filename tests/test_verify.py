"""`mobo verify` accepts a good bag, and names trial and field of whatever was changed in a copy."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from studies import run_study

from mobo_core.bag.collector import read_study
from mobo_core.bag.reader import read_bag
from mobo_core.bag.writer import McapFile
from mobo_core.commands.cli import main
from mobo_core.messages import KINDS, Evaluation, decode, encode

N = 20


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study evaluated by the kernel, a few poses a voxel."""
    folder = tmp_path_factory.mktemp("verify") / "good"
    spec = {"poses_per_voxel": 2, "restarts": 1, "iterations": 20}
    run_study(folder, N, engine="kernel", settings={"spec": spec, "n_startup_trials": 8})
    return folder


def tampered(bag: Path, target: Path, kind: str, change: Callable[[Any], None], which: int = 5) -> Path:
    """Return a copy of the bag in which message number ``which`` of a kind is changed and all else is as it was."""
    target.mkdir()
    (content,) = read_bag(bag)
    file = McapFile(target / f"{target.name}_0.mcap", content.record)
    seen = 0
    for entry in content.entries:
        data = entry.data
        if entry.kind == kind:
            if seen == which:
                message = decode(KINDS[kind], data)
                change(message)
                data = encode(message)
            seen += 1
        file.write(entry.topic, entry.kind, data, entry.time_ns)
    file.finish()
    return target


def test_good_bag_passes(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", str(bag), "--workers", "1"]) == 0
    assert f"good: {N} trials told" in capsys.readouterr().out


def test_sample_checks_some_evaluations_and_all_designs(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", str(bag), "--sample", "3", "--workers", "1"]) == 0
    assert f"{N} designs asked again, 3 evaluations" in capsys.readouterr().out


def _with(values: Any, i: int, value: Any) -> Any:
    changed = values.copy()
    changed[i] = value
    return changed


def _urdf_byte(message: Any) -> None:
    message.urdf = message.urdf.replace("0.015", "0.016", 1)


def _length(message: Any) -> None:
    message.lengths = np.nextafter(message.lengths, 1.0)


def _param(message: Any) -> None:
    message.params_json = message.params_json.replace('"J1": "', '"J1": "P', 1).replace("PP", "R", 1).replace(
        "PR", "P", 1
    )


def _score(message: Any) -> None:
    message.reach = np.nextafter(message.reach, 100.0)


def _voxel(message: Any) -> None:
    message.voxel_torque = _with(message.voxel_torque, 7, np.nextafter(message.voxel_torque[7], 100.0))


def _spread(message: Any) -> None:
    message.voxel_torque_sd = _with(message.voxel_torque_sd, 7, np.float32(1.25))


def _told(message: Any) -> None:
    message.torque = np.nextafter(message.torque, 1e9)


def _spec_seed(message: Any) -> None:
    message.spec.seed = 1


@pytest.mark.parametrize(
    ("kind", "change", "field"),
    [
        ("Candidate", _urdf_byte, "urdf"),
        ("Candidate", _length, "lengths"),
        ("Candidate", _param, "params_json"),
        ("Candidate", _spec_seed, "spec"),
        ("Evaluation", _score, "reach"),
        ("Evaluation", _voxel, "voxel_torque"),
        ("Evaluation", _spread, "voxel_torque_sd"),
        ("Trial", _told, "torque"),
    ],
)
def test_one_changed_value_is_found_and_named(
    bag: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    kind: str,
    change: Callable[[Any], None],
    field: str,
) -> None:
    copy = tampered(bag, tmp_path / "copy", kind, change)
    study = read_study(copy)
    messages = {"Candidate": study.candidates, "Evaluation": study.evaluations}
    trial = int(messages[kind][5].trial) if kind in messages else 5
    assert main(["verify", str(copy), "--workers", "1"]) == 1
    assert f"trial {trial}, {field}" in capsys.readouterr().err


def test_told_as_failed_against_a_good_answer_is_found(
    bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(message: Any) -> None:
        message.state, message.reach, message.torque = 1, np.nan, np.nan

    copy = tampered(bag, tmp_path / "copy", "Trial", fail, which=N - 1)
    assert main(["verify", str(copy), "--workers", "1"]) == 1
    assert f"trial {N - 1}, state" in capsys.readouterr().err


def test_bad_answer_before_the_good_one_is_no_fault(bag: Path, tmp_path: Path) -> None:
    """The first valid answer counts, whatever came before it under the same name."""
    target = tmp_path / "copy"
    target.mkdir()
    (content,) = read_bag(bag)
    file = McapFile(target / "copy_0.mcap", content.record)
    for entry in content.entries:
        if entry.kind == "Evaluation":
            bad = decode(Evaluation, entry.data)
            bad.reach = np.nan
            file.write(entry.topic, entry.kind, encode(bad), entry.time_ns)
        file.write(entry.topic, entry.kind, entry.data, entry.time_ns)
    file.finish()
    assert main(["verify", str(target), "--workers", "1"]) == 0


def test_told_twice_or_never_is_found(bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def renumber(message: Any) -> None:
        message.trial = 3

    copy = tampered(bag, tmp_path / "copy", "Trial", renumber)
    assert main(["verify", str(copy), "--workers", "1"]) == 1
    said = capsys.readouterr().err
    assert "trial 3, trial: told more than once" in said
    assert "trial 5, trial: was never told" in said


@pytest.mark.parametrize("part", [0.3, 0.6, 0.9])
def test_one_flipped_byte_of_the_file_is_found(bag: Path, tmp_path: Path, part: float) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(bag, copy)
    file = next(copy.glob("*.mcap"))
    data = bytearray(file.read_bytes())
    data[int(part * len(data))] ^= 0x10
    file.write_bytes(data)
    assert main(["verify", str(copy), "--workers", "1"]) == 1


def test_cut_bag_fails_until_recovered(bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(bag, copy)
    file = next(copy.glob("*.mcap"))
    file.write_bytes(file.read_bytes()[: int(0.6 * file.stat().st_size)])
    assert main(["verify", str(copy), "--workers", "1"]) == 1
    assert "cut off" in capsys.readouterr().err
    assert main(["bag", "recover", str(copy)]) == 0
    assert main(["verify", str(copy), "--workers", "1"]) == 0


@pytest.mark.parametrize("make", ["nothing", "text", "empty", "other"])
def test_what_is_no_bag_is_refused_with_2(tmp_path: Path, capsys: pytest.CaptureFixture[str], make: str) -> None:
    path = tmp_path / "x"
    if make == "text":
        path.write_text("not a bag\n" * 100)
    elif make == "empty":
        path.mkdir()
    elif make == "other":
        path.mkdir()
        McapFile(path / "x_0.mcap", {}).finish()
    assert main(["verify", str(path)]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and str(path) in said and "expected" in said


@pytest.mark.parametrize(("option", "least"), [("--workers", 1), ("--sample", 0)])
def test_numbers_out_of_range_are_refused(option: str, least: int, capsys: pytest.CaptureFixture[str]) -> None:
    """The message says where the range begins."""
    assert main(["verify", "bags/none", option, str(least - 1)]) == 2
    assert capsys.readouterr().err == f"mobo verify: {option}: {least - 1}; expected a whole number from {least} up\n"
