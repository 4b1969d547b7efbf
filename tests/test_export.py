"""mobo export: URDFs byte for byte as they were evaluated, tables as the bag has them."""

from __future__ import annotations

import csv
import hashlib
import importlib.util
import json
import os
import sys
from pathlib import Path

import pinocchio as pin
import pytest
from studies import messages, mobo, run_study

from mobo_core.design import Design, DesignSpace, to_urdf
from mobo_core.errors import InputError
from mobo_core.outputs import write_whole

ARM = ("--joints", "YPPYPY", "--lengths", "0.05,0.25,0.2,0.05,0,0.05")
REJECTED = {4}


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return run_study(tmp_path_factory.mktemp("bags") / "thirty", 30, rejected=REJECTED)


def refused(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    """Run a command that must end with exit code 2 and one line, and return that line."""
    capsys.readouterr()
    assert mobo(*arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == "" and captured.err.count("\n") == 1
    return captured.err


def test_urdf_of_an_arm_is_xacro_of_its_design(tmp_path: Path) -> None:
    path = tmp_path / "new" / "arm.urdf"
    assert mobo("export", "urdf", *ARM, "-o", path) == 0
    expected = to_urdf(Design("YPPYPY", (0.05, 0.25, 0.2, 0.05, 0, 0.05)), DesignSpace())
    assert path.read_bytes() == expected.encode()
    assert pin.buildModelFromUrdf(str(path)).nq == 6
    assert [file.name for file in path.parent.iterdir()] == ["arm.urdf"]


def test_urdfs_of_a_bag_are_the_candidates_byte_for_byte(bag: Path, tmp_path: Path) -> None:
    assert mobo("export", "urdf", bag, "--top", 12, "-o", tmp_path / "arms") == 0
    candidates = {message.trial: message for message in messages(bag, "/candidates")}
    files = sorted((tmp_path / "arms").glob("*.urdf"))
    assert len(files) == 12
    said = json.loads((tmp_path / "arms" / "manifest.json").read_text(encoding="utf-8"))
    told = {message.trial: message for message in messages(bag, "/trials")}
    assert [arm["file"] for arm in said["arms"]] == [path.name for path in files]
    assert said["spec"]["poses_per_voxel"] > 0
    for path, arm in zip(files, said["arms"], strict=True):
        assert arm["sha256"] == hashlib.sha256(path.read_bytes()).hexdigest()
        assert (arm["reach"], arm["torque"]) == (told[arm["trial"]].reach, told[arm["trial"]].torque)
        assert arm["lengths"] == candidates[arm["trial"]].lengths.tolist()
    for place, path in enumerate(files, start=1):
        rank, joints, trial = path.stem.split("_")
        candidate = candidates[int(trial.removeprefix("trial"))]
        assert (rank, joints, path.suffix) == (f"{place:02d}", candidate.joints, ".urdf")
        assert path.read_bytes() == candidate.urdf.encode()


def test_top_is_the_front_by_reach_and_then_the_others_by_reach(bag: Path, tmp_path: Path) -> None:
    told = [message for message in messages(bag, "/trials") if message.state == 0]
    front = [
        a
        for a in told
        if a.reach >= 7.5 and not any(b.reach >= a.reach and b.torque <= a.torque and b.trial != a.trial for b in told)
    ]
    first = sorted(front, key=lambda message: -message.reach)
    rest = sorted((message for message in told if message not in front), key=lambda message: -message.reach)
    assert mobo("export", "urdf", bag, "--top", 1000, "-o", tmp_path / "arms") == 0
    names = sorted(path.name for path in (tmp_path / "arms").glob("*.urdf"))
    trials = [int(name.removesuffix(".urdf").rsplit("trial", 1)[1]) for name in names]
    assert trials == [message.trial for message in first + rest]
    assert not REJECTED & set(trials)


def test_one_arm_of_a_bag_by_default_and_again(bag: Path, tmp_path: Path) -> None:
    for _ in range(2):
        assert mobo("export", "urdf", bag, "-o", tmp_path / "arms") == 0
        assert len(list((tmp_path / "arms").glob("*.urdf"))) == 1


def test_urdfs_of_another_export_are_not_mixed_in(
    bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "mine.urdf").write_text("mine")
    line = refused(capsys, "export", "urdf", bag, "--top", 2, "-o", tmp_path)
    assert "holds mine.urdf; expected a folder without other URDF files" in line
    assert [path.name for path in tmp_path.iterdir()] == ["mine.urdf"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--joints", "YPXYPY", "--lengths", "0.1,0.1,0.1,0.1,0.1,0.1"], "unknown joint 'X'"),
        (["--joints", "YPP", "--lengths", "0.1,0.1,0.1"], "lengths add up to 0.3 m; expected 0.6 m"),
        (["--joints", "YPP"], "no arm given"),
        (["--top", "3"], "--top without a bag"),
        (["BAG", "--joints", "YPP"], "both a bag"),
        (["BAG", "--top", "0"], "--top: 0; expected 1 or more"),
        (["nowhere"], "no such bag"),
    ],
)
def test_bad_arguments_of_export_urdf(
    bag: Path, arguments: list[str], words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = [str(bag) if argument == "BAG" else argument for argument in arguments]
    assert words in refused(capsys, "export", "urdf", *given, "-o", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_study_without_complete_trials_has_no_best_arm(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bag = run_study(tmp_path / "bag", 1, rejected={0})
    assert "no complete trial" in refused(capsys, "export", "urdf", bag, "-o", tmp_path / "out")


def test_csv_holds_what_rosbags_reads(bag: Path, tmp_path: Path) -> None:
    path = tmp_path / "new" / "all.csv"
    assert mobo("export", "table", bag, "-o", path) == 0
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    told = messages(bag, "/trials")
    assert [int(row["trial"]) for row in rows] == [message.trial for message in told]
    for row, message in zip(rows, told, strict=True):
        if message.trial in REJECTED:
            assert (row["state"], row["reach"], row["reason"]) == ("FAIL", "", message.reason)
        else:
            assert (float(row["reach"]), float(row["torque"])) == (message.reach, message.torque)


@pytest.mark.skipif(importlib.util.find_spec("pyarrow") is None, reason="pyarrow is not installed")
def test_parquet_holds_what_csv_holds(bag: Path, tmp_path: Path) -> None:
    import pyarrow.parquet

    path = tmp_path / "all.parquet"
    assert mobo("export", "table", bag, "-o", path) == 0
    rows = pyarrow.parquet.read_table(path).to_pylist()
    for row, message in zip(rows, messages(bag, "/trials"), strict=True):
        assert row["trial"] == message.trial
        assert row["reach"] == (None if message.trial in REJECTED else message.reach)
        assert isinstance(row["on_front"], bool)


def test_parquet_without_pyarrow_says_what_to_install(
    bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    line = refused(capsys, "export", "table", bag, "-o", tmp_path / "all.parquet")
    assert "Parquet needs pyarrow; expected pip install pyarrow, or a file name ending in .csv" in line


def test_tables_of_other_kinds_are_refused(bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    line = refused(capsys, "export", "table", bag, "-o", tmp_path / "all.xlsx")
    assert "suffix '.xlsx'; expected a file name ending in .csv or .parquet" in line


def test_output_below_a_file_is_refused(bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("mine")
    for path in (tmp_path / "file" / "t.csv", tmp_path / "file" / "deeper" / "t.csv"):
        assert str(tmp_path / "file") in refused(capsys, "export", "table", bag, "-o", path)
    (tmp_path / "folder.csv").mkdir()
    assert "is a folder" in refused(capsys, "export", "table", bag, "-o", tmp_path / "folder.csv")
    assert (tmp_path / "file").read_text() == "mine"


def test_a_file_is_replaced_whole_or_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "file"
    path.write_text("old")

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(InputError, match="cannot be written .No space left on device"):
        write_whole(path, "new")
    monkeypatch.undo()
    assert path.read_text() == "old" and len(list(tmp_path.iterdir())) == 1


def test_a_link_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "real").write_text("old")
    (tmp_path / "link").symlink_to(tmp_path / "real")
    write_whole(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink() and (tmp_path / "real").read_text() == "new"
