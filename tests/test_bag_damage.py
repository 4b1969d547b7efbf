"""Cut and changed bags: every whole message before the damage, then one clear line; never anything else."""

from __future__ import annotations

import itertools
import tempfile
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.records import Chunk
from mcap.stream_reader import StreamReader
from rosbags.highlevel import AnyReader
from studies import mobo, run_study

from mobo_core.bag.reader import Entry, FileContent, read_bag, read_file
from mobo_core.errors import InputError

SETTINGS = {"sampler": "random", "spec": {"poses_per_voxel": 2, "restarts": 1, "iterations": 20}}


class Whole(NamedTuple):
    """A file, its messages, and the bytes their chunks begin and end at."""

    data: bytes
    entries: list[Entry]
    starts: list[int]
    ends: list[int]

    def __repr__(self) -> str:
        return f"a file of {len(self.entries)} messages"

    def before(self, byte: int) -> list[Entry]:
        return [entry for entry, end in zip(self.entries, self.ends, strict=True) if end <= byte]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Whole:
    bag = run_study(tmp_path_factory.mktemp("damage") / "bag", 8, settings=SETTINGS)
    path = bag / "bag_0.mcap"
    entries, starts, ends, before = read_file(path).entries, [], [], 0
    with path.open("rb") as file:
        for record in StreamReader(file, emit_chunks=True).records:
            if isinstance(record, Chunk):
                starts.append(before)
                ends.append(file.tell())
            before = file.tell()
    assert len(ends) == len(entries) > 24
    return Whole(path.read_bytes(), entries, starts, ends)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("bag")


def read(folder: Path, data: bytes) -> FileContent | str:
    """Return the content of a file of these bytes, or the line that says why it is none."""
    path = folder / "bag_0.mcap"
    path.write_bytes(data)
    try:
        content = read_file(path)
    except InputError as error:
        assert "\n" not in str(error)
        return str(error)
    assert content.finished == (not content.fault) and "\n" not in content.fault
    return content


@settings(deadline=None)
@given(st.data())
def test_a_cut_file_gives_what_is_whole(whole: Whole, folder: Path, data: st.DataObject) -> None:
    """Wherever it is cut: every message that ends before that; it counts as cut off, not as damaged."""
    size = len(whole.data)
    end = data.draw(st.one_of(st.integers(0, size - 1), st.sampled_from(whole.ends), st.integers(size - 60, size - 1)))
    content = read(folder, whole.data[:end])
    assert isinstance(content, FileContent)
    assert content.entries == whole.before(end)
    assert content.fault == "cut off"


changes = st.one_of(
    st.tuples(st.just("flip"), st.integers(0, 7)),
    st.tuples(st.just("set"), st.binary(min_size=1, max_size=40)),
    st.tuples(st.just("insert"), st.binary(min_size=1, max_size=40)),
    st.tuples(st.just("remove"), st.integers(1, 3000)),
)


def changed(data: bytes, at: int, change: tuple[str, object]) -> bytes:
    kind, what = change
    if isinstance(what, bytes):
        return data[:at] + what + data[at + (len(what) if kind == "set" else 0) :]
    assert isinstance(what, int)
    if kind == "flip":
        return data[:at] + bytes([data[at] ^ (1 << what)]) + data[at + 1 :]
    return data[:at] + data[at + what :]


@settings(max_examples=300, deadline=None)
@given(st.data())
def test_a_changed_file_gives_what_stands_before_the_change(whole: Whole, folder: Path, data: st.DataObject) -> None:
    """Bits flipped, bytes overwritten, put in or taken out: the messages before, in order, and then a fault."""
    at = data.draw(st.integers(0, len(whole.data) - 1))
    damaged = changed(whole.data, at, data.draw(changes))
    for _ in range(data.draw(st.integers(0, 2))):
        later = data.draw(st.integers(0, max(0, len(damaged) - 1)))
        damaged, at = changed(damaged, later, data.draw(changes)), min(at, later)
    content = read(folder, damaged)
    if isinstance(content, str):
        assert at < 8 or "profile" in content
        return
    assert content.entries[: len(whole.before(at))] == whole.before(at)
    # What is read beyond the change was written so: a chunk is read whole and by its CRC, or not at all.
    assert all(entry in whole.entries for entry in content.entries)
    assert content.fault or damaged.startswith(whole.data)


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_recovered_it_reads_with_rosbags(whole: Whole, data: st.DataObject) -> None:
    """After `mobo bag recover` any reader finds those messages, and the damaged file is kept."""
    at = data.draw(st.integers(40, len(whole.data) - 1))
    cut = data.draw(st.booleans())
    damaged = whole.data[:at] if cut else changed(whole.data, at, data.draw(changes))
    with tempfile.TemporaryDirectory() as place:
        bag = Path(place) / "bag"
        bag.mkdir()
        (bag / "bag_0.mcap").write_bytes(damaged)
        content = read_file(bag / "bag_0.mcap")
        assert mobo("bag", "recover", bag) == 0
        with AnyReader([bag]) as reader:
            found = [(c.topic, t, d) for c, t, d in reader.messages()]
        assert sorted(found) == sorted((e.topic, e.time_ns, e.data) for e in content.entries)
        assert not read_bag(bag)[0].fault
        kept = bag / "bag_0.mcap.damaged"
        assert kept.exists() == (bool(content.fault) and not content.cut_off)
        assert not kept.exists() or kept.read_bytes() == damaged


@pytest.mark.slow
@pytest.mark.parametrize(
    ("verb", "part", "how"),
    [
        *itertools.product(["info"], [0.03, 0.35, 0.7, 0.97], ["cut", "overwritten"]),
        *itertools.product(["verify"], [0.03, 0.35, 0.97], ["cut", "overwritten"]),
        ("report", 0.7, "overwritten"),  # cut ones: test_analysis
    ],
)
def test_commands_say_it_in_lines(
    whole: Whole, tmp_path: Path, capsys: pytest.CaptureFixture[str], verb: str, part: float, how: str
) -> None:
    """What reads bags goes as far as it can, says what is wrong, and never ends in a traceback."""
    bag = tmp_path / "bag"
    bag.mkdir()
    at = int(part * len(whole.data))
    damaged = whole.data[:at] if how == "cut" else changed(whole.data, at, ("set", b"\xff\x00" * 20))
    (bag / "bag_0.mcap").write_bytes(damaged)
    arguments = {"info": ["bag", "info", bag], "verify": ["verify", bag, "--workers", "1"]}
    code = mobo(*arguments.get(verb, ["report", bag, "-o", tmp_path / "report"]))
    captured = capsys.readouterr()
    assert code == {"info": 0, "verify": 1, "report": 0}[verb] or (code == 2 and part == 0.03)
    if code == 0 and verb == "info":
        assert ("cut off" if how == "cut" else "damaged after byte") in captured.out
    else:
        assert ("cut off" if how == "cut" else "damaged") in captured.err or code == 2
    assert "Traceback" not in captured.err


@pytest.mark.parametrize(
    "lie",
    [
        lambda data, start: data[: start + 1] + (1 << 50).to_bytes(8, "little") + data[start + 9 :],
        lambda data, start: data[: start + 1] + (1 << 27).to_bytes(8, "little") + data[start + 9 :],
        lambda data, start: data[: start + 25] + (1 << 40).to_bytes(8, "little") + data[start + 33 :],
        lambda data, start: data[: start + 25] + (1 << 27).to_bytes(8, "little") + data[start + 33 :],
    ],
)
def test_sizes_that_lie_fill_no_memory(whole: Whole, folder: Path, lie: Callable[[bytes, int], bytes]) -> None:
    """A record or a chunk that claims to be huge is refused by the claim."""
    damaged = lie(whole.data, whole.starts[10])
    tracemalloc.start()
    content = read(folder, damaged)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert isinstance(content, FileContent) and content.fault
    assert content.entries == whole.entries[:10]
    assert peak < 20_000_000
