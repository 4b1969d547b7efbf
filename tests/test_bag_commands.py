"""mobo bag info and recover, on whole, cut-off, damaged and busy bags."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest
import yaml
from studies import messages, mobo, mobo_json, run_study

from mobo_core.bag.collector import read_study
from mobo_core.bag.lock import BagLock


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two sessions, the second by another evaluator; one failed trial."""
    folder = tmp_path_factory.mktemp("bags") / "whole"
    run_study(folder, 12, evaluators=["anna"], rejected={5})
    return run_study(folder, 20, evaluators=["bob"], resume=True)


@pytest.fixture(scope="module")
def killed_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return run_study(tmp_path_factory.mktemp("bags") / "killed", 20, kill_after=9)


@pytest.fixture
def killed(killed_once: Path, tmp_path: Path) -> Path:
    """A bag whose optimizer was killed after nine trials were told; each test has its own copy."""
    return Path(shutil.copytree(killed_once, tmp_path / "killed"))


def contents(bag: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in bag.iterdir()}


def test_info_counts_what_rosbags_counts(whole: Path, capsys: pytest.CaptureFixture[str]) -> None:
    info = mobo_json(capsys, "bag", "info", whole, "--json")
    for topic, count in info["topics"].items():
        assert len(messages(whole, topic)) == count, topic
    trials = messages(whole, "/trials")
    assert info["trials"] == {
        "told": len(trials),
        "complete": sum(trial.state == 0 for trial in trials),
        "failed": 1,
        "open": 0,
        "told_twice": [],
    }
    assert info["answers"] == {"recorded": len(messages(whole, "/evaluations")), "used": 20}
    assert info["sessions"] == 2 and info["writer"] == ""
    assert [file["state"] for file in info["files"]] == ["finished", "finished"]
    assert info["bytes"] == sum(path.stat().st_size for path in whole.glob("*.mcap"))
    assert info["bytes_per_trial"] == round(info["bytes"] / 20)
    assert info["settings"]["sampler"] == "random" and info["versions"]["optuna"]


def test_info_shares_the_trials_among_evaluators(whole: Path, capsys: pytest.CaptureFixture[str]) -> None:
    info = mobo_json(capsys, "bag", "info", whole, "--json")
    trials = messages(whole, "/trials")
    for who in info["evaluators"]:
        accepted = sum(trial.evaluator == who["name"] for trial in trials)
        assert (who["accepted"], who["share"]) == (accepted, accepted / 20)
        assert (who["workers"], who["engine"], who["host"]) == (2, "simulated", "test")
    assert [who["name"] for who in info["evaluators"]] == ["anna", "bob"]


def test_info_for_people_names_the_same(whole: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert mobo("bag", "info", whole) == 0
    out = capsys.readouterr().out
    for words in (
        "study     study\n",
        "6 joints of RPY, 0.6 m, fractions",
        "75 voxels of 0.2 m, 30 poses each, paper IK, seed 0",
        "random, seed 0, 10 start-up trials, 8 in flight",
        "20 told: 19 complete, 1 failed; 0 open",
        "in 2 sessions",
        "whole_1.mcap",
        "finished",
        "60% of the trials",
        "40% of the trials",
    ):
        assert words in out


def test_info_of_a_cut_off_bag_says_so(killed: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = contents(killed)
    info = mobo_json(capsys, "bag", "info", killed, "--json")
    assert info["files"][0]["state"] == "cut off"
    assert info["trials"]["told"] == 9 and info["trials"]["open"] > 0
    assert contents(killed) == before


def test_info_of_a_busy_bag_names_who_writes(killed: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lock = BagLock(killed, "optimizer_7")
    try:
        info = mobo_json(capsys, "bag", "info", killed, "--json")
        assert info["writer"].startswith("optimizer_7 on ") and info["writer"].endswith(f"pid {os.getpid()}")
        assert mobo("bag", "info", killed) == 0
        assert "being written to by optimizer_7" in capsys.readouterr().out
    finally:
        lock.release()


def test_info_of_a_bag_without_trials(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bag = run_study(tmp_path / "bag", 3, kill_after=0)
    assert mobo("bag", "info", bag) == 0
    assert "0 told: 0 complete, 0 failed; 3 open" in capsys.readouterr().out


def test_recover_makes_a_cut_off_bag_whole(killed: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = read_study(killed)
    n = len(before.contents[0].entries)
    assert mobo("bag", "recover", killed) == 0
    assert capsys.readouterr().out == (
        f"{killed}/killed_0.mcap: cut off; mended, {n} whole messages\n{killed}/metadata.yaml: written anew\n"
    )
    after = read_study(killed)
    assert not after.faults and after.contents[0].finished
    assert after.contents[0].entries == before.contents[0].entries
    assert len(messages(killed, "/trials")) == 9
    metadata = yaml.safe_load((killed / "metadata.yaml").read_text())
    assert metadata["rosbag2_bagfile_information"]["message_count"] == n


def test_recover_of_a_whole_bag_changes_no_file(killed: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert mobo("bag", "recover", killed) == 0
    before = contents(killed)
    capsys.readouterr()
    assert mobo("bag", "recover", killed) == 0
    assert "1 file, all whole" in capsys.readouterr().out
    assert contents(killed) | {".lock": b""} == before | {".lock": b""}


def test_recover_keeps_the_damaged_file(whole: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bag = Path(shutil.copytree(whole, tmp_path / "whole"))
    data = bytearray((bag / "whole_0.mcap").read_bytes())
    data[len(data) // 2 : len(data) // 2 + 64] = b"\xff" * 64
    (bag / "whole_0.mcap").write_bytes(data)
    assert mobo("bag", "recover", bag) == 0
    out = capsys.readouterr().out
    assert "damaged" in out and "the damaged file is kept beside it" in out
    assert (bag / "whole_0.mcap.damaged").read_bytes() == data
    assert not read_study(bag).faults


def test_recover_of_a_single_file(killed: Path) -> None:
    assert mobo("bag", "recover", killed / "killed_0.mcap") == 0
    assert not read_study(killed / "killed_0.mcap").faults


def test_recover_leaves_a_bag_alone_that_an_optimizer_writes_to(
    killed: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lock = BagLock(killed, "optimizer_7")
    try:
        before = contents(killed)
        assert mobo("bag", "recover", killed) == 2
        captured = capsys.readouterr()
        assert "in use by optimizer_7" in captured.err and captured.err.count("\n") == 1
        assert contents(killed) == before
    finally:
        lock.release()


def test_a_recovered_study_goes_on_as_if_nothing_had_been(whole: Path, killed: Path) -> None:
    assert mobo("bag", "recover", killed) == 0
    run_study(killed, 20, resume=True)
    undisturbed = messages(whole, "/candidates")
    assert [c.urdf for c in messages(killed, "/candidates")[:8]] == [c.urdf for c in undisturbed[:8]]
    assert sorted(trial.trial for trial in messages(killed, "/trials")) == list(range(20))


@pytest.mark.parametrize("verb", ["info", "recover"])
@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("nowhere", "no such bag"),
        ("empty", "not a bag; expected files NAME_0.mcap"),
        ("text.mcap", "not an MCAP file"),
    ],
)
def test_what_is_no_bag_is_refused(
    verb: str, name: str, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "text.mcap").write_text("not a bag at all, just some text")
    assert mobo("bag", verb, tmp_path / name) == 2
    captured = capsys.readouterr()
    assert words in captured.err and captured.err.count("\n") == 1
    assert not any((tmp_path / "empty").iterdir())


def test_file_that_was_cut_off_before_its_first_byte_counts_as_empty(tmp_path: Path) -> None:
    bag = run_study(tmp_path / "bag", 8, kill_after=4)
    (bag / "bag_1.mcap").touch()
    assert mobo("bag", "recover", bag) == 0
    assert len(messages(bag, "/trials")) == 4
    run_study(bag, 8, resume=True)
    assert [trial.trial for trial in messages(bag, "/trials")] == list(range(8))
