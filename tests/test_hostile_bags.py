"""What is foreign to a bag stays whole, and crafted bags end in one line, in little memory and time."""

from __future__ import annotations

import os
import shutil
import time
import tracemalloc
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import lz4.frame
import numpy as np
import pytest
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.records import Channel, Chunk, Message
from mcap.writer import MCAP0_MAGIC
from studies import mobo, run_study

from mobo_core.bag.collector import read_study
from mobo_core.bag.files import METADATA_FILE, bag_files
from mobo_core.bag.record import study_record
from mobo_core.bag.study_bag import check_writable
from mobo_core.bag.writer import McapFile
from mobo_core.errors import InputError
from mobo_core.messages import Candidate, encode
from mobo_core.search.study import StudySettings
from mobo_core.settings import read_yaml


@pytest.fixture(scope="module")
def bag_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two sessions; the first was killed."""
    folder = tmp_path_factory.mktemp("bags") / "bag"
    run_study(folder, 6, kill_after=3)
    return run_study(folder, 10, resume=True)


@pytest.fixture
def bag(bag_once: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(bag_once, tmp_path / "bag"))


def foreign(folder: Path, name: str) -> bytes:
    """Put another recording into a folder."""
    file = McapFile(folder / name, {"study": "another"})
    file.write("/trials", "Trial", bytes(100))
    file.finish()
    return (folder / name).read_bytes()


@pytest.mark.parametrize("renamed", [False, True])
def test_other_recordings_in_the_folder_are_none_of_the_bags(bag: Path, renamed: bool) -> None:
    """compact, recover and resume read past them and leave them as they were, even one of a number the bag has."""
    if renamed:
        bag = bag.rename(bag.with_name("other"))
    names = ["camera.mcap", "zzz_0.mcap", "zzz_7.mcap", "notes.mcap.txt"]
    before = {name: foreign(bag, name) for name in names}
    assert [path.name for path in bag_files(bag)] == ["bag_0.mcap", "bag_1.mcap"]
    assert mobo("bag", "recover", bag) == 0
    run_study(bag, 12, resume=True)
    assert mobo("bag", "compact", bag) == 0
    assert {name: (bag / name).read_bytes() for name in names} == before
    assert len(bag_files(bag)) == 1 and len(read_study(bag).trials) == 12


def test_two_bags_in_a_folder_are_refused(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Without a metadata.yaml to tell, files of one number do not shadow each other: one line, nothing touched."""
    (bag / METADATA_FILE).unlink()
    moved = bag.rename(bag.with_name("moved"))
    foreign(moved, "zzz_0.mcap")
    before = {path.name: path.read_bytes() for path in moved.iterdir()}
    for words in (["bag", "compact"], ["bag", "recover"], ["verify"]):
        assert mobo(*words, moved) == 2
        said = capsys.readouterr().err
        assert said.count("\n") == 1 and "expected one bag in a folder" in said
    assert {path.name: path.read_bytes() for path in moved.iterdir() if path.name in before} == before


@pytest.mark.parametrize(
    ("kind", "words"),
    [("link", ["bag", "recover"]), ("link", ["resume"]), ("hard link", ["bag", "compact"]), ("pipe", ["bag", "info"])],
)
def test_what_stands_in_the_locks_place_is_not_written_to(
    bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str, words: list[str]
) -> None:
    """A link's target keeps its bytes, a pipe lets nobody wait; one line where a lock is needed."""
    mine, lock = tmp_path / "mine.txt", bag / ".lock"
    mine.write_text("mine")
    lock.unlink(missing_ok=True)
    if kind == "pipe":
        os.mkfifo(lock)
    else:
        (lock.symlink_to if kind == "link" else lock.hardlink_to)(mine)
    if words == ["resume"]:
        with pytest.raises(Exception, match="expected a lock file"):
            run_study(bag, 12, resume=True)
    else:
        assert mobo(*words, bag) == (0 if words == ["bag", "info"] else 2)
        assert capsys.readouterr().err.count("\n") == (words != ["bag", "info"])
    assert mine.read_text() == "mine"


def test_links_where_files_are_written_are_not_followed(bag: Path, tmp_path: Path) -> None:
    """metadata.yaml, what it is written as, and what recover writes: the links go, their targets stay."""
    mine = tmp_path / "mine.txt"
    mine.write_text("mine")
    last = bag / "bag_1.mcap"
    last.write_bytes(last.read_bytes()[:-40])
    (bag / METADATA_FILE).unlink()
    for name in (METADATA_FILE, f".{METADATA_FILE}.{os.getpid()}.part", "bag_1.recovering"):
        (bag / name).symlink_to(mine)
    assert mobo("bag", "recover", bag) == 0
    assert mine.read_text() == "mine" and not read_study(bag).faults
    (bag.parent / ".bag.compacting").symlink_to(tmp_path)
    assert mobo("bag", "compact", bag) == 2
    assert mine.read_text() == "mine"


def test_a_pipe_among_the_files_is_not_read(bag: Path) -> None:
    """Nobody waits for who writes to it."""
    os.mkfifo(bag / "bag_2.mcap")
    assert len(read_study(bag).trials) == 10
    assert mobo("verify", bag / "bag_2.mcap") == 2


def crafted(folder: Path, chunk: Chunk) -> Path:
    """Return a bag of one file that holds such a chunk behind its records."""
    folder.mkdir()
    file = McapFile(folder / f"{folder.name}_0.mcap", study_record("s", StudySettings()))
    builder = RecordBuilder()
    chunk.write(builder)
    file._stream.write(builder.end())
    file._stream.flush()
    file._stream.close()
    return folder


def chunk_of(data: bytes, compression: str, packed: bytes, size: int) -> Chunk:
    return Chunk(compression, packed, 0, 0, zlib.crc32(data), size)


def many_messages() -> Chunk:
    """27 kB that become 2 million messages."""
    builder = RecordBuilder()
    Channel(id=1, topic="/x", message_encoding="cdr", metadata={}, schema_id=0).write(builder)
    channel = builder.end()
    Message(channel_id=1, sequence=0, log_time=0, publish_time=0, data=b"").write(builder)
    data = channel + builder.end() * 2_000_000
    return chunk_of(data, "zstd", zstandard.compress(data), len(data))


def false_size() -> Chunk:
    """A frame that says it holds a kilobyte, and holds 200 MB."""
    data = bytes(200_000_000)
    return chunk_of(data, "lz4", lz4.frame.compress(data), 1000)


@pytest.mark.parametrize("make", [many_messages, false_size])
def test_chunks_that_hold_more_than_a_bag_can_fill_no_memory(tmp_path: Path, make: Callable[[], Chunk]) -> None:
    """The reader stops at what a bag of that size can hold, and says so in one line."""
    bag = crafted(tmp_path / "bag", make())
    assert next(bag.iterdir()).stat().st_size < 2_000_000
    tracemalloc.start()
    try:
        with pytest.raises(InputError, match="^[^\\n]*bag_0.mcap: [^\\n]*expected as much as a bag of its size holds$"):
            read_study(bag)
        assert tracemalloc.get_traced_memory()[1] < 200_000_000
    finally:
        tracemalloc.stop()


def test_a_file_of_thousands_of_topics_is_refused(tmp_path: Path) -> None:
    """Each is described, and looked at."""
    builder = RecordBuilder()
    for number in range(20_000):
        Channel(id=number + 1, topic=f"/x{number}", message_encoding="cdr", metadata={}, schema_id=0).write(builder)
    data = builder.end()
    bag = crafted(tmp_path / "bag", chunk_of(data, "", data, len(data)))
    with pytest.raises(InputError, match="more than 1,000 topics; expected as much as"):
        read_study(bag)


def test_whether_a_bag_can_be_written_is_known_at_once(tmp_path: Path) -> None:
    """Before anything starts, and without leaving anything behind."""
    check_writable(tmp_path / "a" / "b")
    check_writable(tmp_path)
    assert not list(tmp_path.iterdir())
    (tmp_path / "file").touch()
    for folder in (Path("/proc/x"), tmp_path / "file" / "x", tmp_path / ("n" * 300)):
        with pytest.raises(InputError, match="expected a folder that can be made and written to"):
            check_writable(folder)


_GROWING = "a0: &a0 {k: 1}\n" + "".join(f"a{i}: &a{i} {{<<: [{f'*a{i - 1},' * 10}]}}\n" for i in range(1, 10))
_BOMB = "- &a0 [x]\n" + "".join(f"- &a{i} [{f'*a{i - 1},' * 10}]\n" for i in range(1, 10))


@pytest.mark.parametrize(
    "text",
    [_GROWING, _BOMB, "x: [" + "1," * 490_000 + "1]", "x: " + "1:" * 400_000 + "1", "{a: " * 50_000, "&a [*a]",
     "!!timestamp x", "x: " + "1:" * 300 + "1.5", "\x00", "!!int ''"],
)  # fmt: skip
def test_yaml_that_grows_when_it_is_read_is_refused(text: str) -> None:
    """Before it has grown; and whatever its constructors raise is one error."""
    began = time.process_time()
    with pytest.raises(ValueError, match="."):
        read_yaml(text)
    assert time.process_time() - began < 10


@pytest.mark.parametrize("text", ["- " * 5_000, "rosbag2_bagfile_information: 7", "\x00", "a: &a [*a]", MCAP0_MAGIC])
def test_a_metadata_file_that_makes_no_sense_ends_nothing(bag: Path, text: str | bytes) -> None:
    """What the files hold counts; recover writes it anew."""
    (bag / METADATA_FILE).write_bytes(text.encode() if isinstance(text, str) else text)
    assert len(read_study(bag).trials) == 10
    assert mobo("bag", "recover", bag) == 0
    assert "bag_1.mcap" in (bag / METADATA_FILE).read_text()


@pytest.mark.parametrize(
    "fields", [{"lengths": np.zeros(200_000)}, {"lengths": np.full(6, np.nan)}, {"joints": "Q" * 100_000}]
)
def test_messages_that_no_mobo_wrote_are_refused(tmp_path: Path, fields: dict[str, Any]) -> None:
    """Lengths without end, or that are no numbers, and names of many kilobytes: one line, whatever reads the bag."""
    folder = tmp_path / "bag"
    folder.mkdir()
    file = McapFile(folder / "bag_0.mcap", study_record("s", StudySettings()))
    file.write("/candidates", "Candidate", encode(Candidate(study="s", **fields)))
    file.finish()
    with pytest.raises(InputError, match="^[^\\n]*bag: [^\\n]*expected at most"):
        read_study(folder)
