"""mobo bag compact: the same messages in one small file, or the old bag as it was."""

from __future__ import annotations

import multiprocessing
import os
import resource
import shutil
import signal
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml
from studies import messages, mobo, run_study

from mobo_core.bag import compact, study_bag, writer
from mobo_core.bag.collector import read_study
from mobo_core.bag.lock import BagLock
from mobo_core.bag.reader import Entry, entries, read_bag


@pytest.fixture(scope="module")
def bag_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two sessions; the first was killed."""
    folder = tmp_path_factory.mktemp("bags") / "bag"
    run_study(folder, 60, kill_after=25)
    return run_study(folder, 60, resume=True)


@pytest.fixture
def bag(bag_once: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(bag_once, tmp_path / "bag"))


def all_of(bag: Path) -> list[Entry]:
    return list(entries(read_bag(bag)))


def contents(bag: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in bag.iterdir() if path.name != ".lock"}


def test_every_message_is_as_it_was_in_one_smaller_file(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Topics, bytes, times, order and definitions; for rosbags too; metadata.yaml and the study's record are whole."""
    (bag / "notes.txt").write_text("mine")
    before, record = all_of(bag), read_study(bag).record
    size = sum(path.stat().st_size for path in bag.glob("*.mcap"))
    read = {topic: messages(bag, topic) for topic in ("/candidates", "/trials")}
    assert mobo("bag", "compact", bag) == 0
    assert capsys.readouterr().out.startswith(f"{bag}: 2 files of ")
    assert sorted(path.name for path in bag.iterdir()) == ["bag_0.mcap", "metadata.yaml", "notes.txt"]
    assert all_of(bag) == before
    assert read_study(bag).record == record
    assert (bag / "bag_0.mcap").stat().st_size < 0.75 * size
    assert [[str(m) for m in messages(bag, topic)] for topic in read] == [[str(m) for m in ms] for ms in read.values()]
    information = yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert information["message_count"] == len(before)
    assert information["relative_file_paths"] == ["bag_0.mcap"]
    assert not list(bag.parent.glob(".*"))


@pytest.mark.slow
def test_a_compacted_bag_resumes_and_verifies(bag: Path) -> None:
    """It goes on as the bag it was made from would have, and can be compacted again."""
    other = Path(shutil.copytree(bag, bag.with_name("other")))
    assert mobo("bag", "compact", bag) == 0
    for folder in (bag, other):
        run_study(folder, 80, resume=True)
    told = [[(t.trial, t.reach, t.torque) for t in messages(folder, "/trials")] for folder in (bag, other)]
    assert told[0] == told[1]
    assert sorted(path.name for path in bag.glob("*.mcap")) == ["bag_0.mcap", "bag_1.mcap"]
    assert mobo("bag", "compact", bag) == 0
    assert len(messages(bag, "/trials")) == 80


def test_a_bag_in_use_or_not_whole_is_refused(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Exit code 2, one line, nothing touched."""
    before = contents(bag)
    lock = BagLock(bag, "optimizer_7")
    try:
        assert mobo("bag", "compact", bag) == 2
    finally:
        lock.release()
    said = capsys.readouterr().err
    assert "in use by optimizer_7" in said and said.count("\n") == 1
    assert contents(bag) == before
    last = bag / "bag_1.mcap"
    last.write_bytes(last.read_bytes()[:-40])
    before = contents(bag)
    assert mobo("bag", "compact", bag) == 2
    said = capsys.readouterr().err
    assert "cut off; expected a whole bag; mobo bag recover" in said and said.count("\n") == 1
    assert contents(bag) == before and not list(bag.parent.glob(".*"))
    assert mobo("bag", "compact", bag / "bag_0.mcap") == 2


def _in_child(what: Callable[[], None]) -> int:
    child = multiprocessing.get_context("fork").Process(target=what)
    child.start()
    child.join(60)
    assert child.exitcode is not None
    return child.exitcode


def test_no_room_leaves_the_old_bag(bag: Path) -> None:
    """A write that fails half way ends it with 1; the old bag is as it was, and nothing is beside it."""
    before = contents(bag)

    def compact_in_little_room() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))
        os._exit(mobo("bag", "compact", bag))

    assert _in_child(compact_in_little_room) == 1
    assert contents(bag) == before and not list(bag.parent.glob(".*"))


@pytest.mark.parametrize("step", ["copy", "finish", "_exchange", "_clear"])
def test_killed_at_any_step_it_leaves_the_whole_old_or_the_whole_new_bag(
    bag: Path, step: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """SIGKILL before a step: all messages are there, once; the next compaction removes what was left."""
    (bag / "notes.txt").write_text("mine")
    before = all_of(bag)
    owner = writer.McapFile if step in ("copy", "finish") else compact
    do, calls = getattr(owner, step), []

    def killed(*arguments: object) -> object:
        calls.append(arguments)
        if len(calls) == (30 if step == "copy" else 2 if step == "_clear" else 1):
            os.kill(os.getpid(), signal.SIGKILL)
        return do(*arguments)

    monkeypatch.setattr(owner, step, killed)
    assert _in_child(lambda: os._exit(mobo("bag", "compact", bag))) == -signal.SIGKILL
    monkeypatch.undo()
    assert all_of(bag) == before
    assert len(list(bag.glob("*.mcap"))) == (1 if step == "_clear" else 2)
    assert mobo("bag", "compact", bag) == 0
    assert all_of(bag) == before
    assert (bag / "notes.txt").read_text() == "mine" and not list(bag.parent.glob(".*"))


@pytest.mark.slow
def test_a_long_bag_rolls_over_and_stays_one_record(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """After so many chunks a new file begins; readers find one record, in order, and resume goes on."""
    whole = run_study(tmp_path / "whole", 40)
    monkeypatch.setattr(study_bag, "_MAX_CHUNKS", 25)
    bag = run_study(tmp_path / "bag", 30)
    assert len(list(bag.glob("*.mcap"))) > 3
    run_study(bag, 40, resume=True)
    assert [t.trial for t in messages(bag, "/trials")] == list(range(40))
    assert [(t.reach, t.torque) for t in messages(bag, "/trials")] == [
        (t.reach, t.torque) for t in messages(whole, "/trials")
    ]
    information = yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert information["message_count"] == len(all_of(bag))
    assert mobo("bag", "compact", bag) == 0
    assert len(messages(bag, "/trials")) == 40
