"""No room, no right to write: the study stops before anything is said that is not recorded, and goes on later."""

from __future__ import annotations

import errno
import hashlib
import multiprocessing
import os
import resource
import shutil
import stat
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from nodes import Nodes, alive, children_of, finish, output, told_so_far, values, wait_for
from studies import mobo, run_study

from mobo_core.bag.reader import entries, read_bag
from mobo_core.bag.recover import recover_file
from mobo_core.bag.writer import McapFile
from mobo_core.coordination.optimizer import Optimizer
from mobo_core.errors import StudyError

N = 60
SPEC = {"poses_per_voxel": 2, "restarts": 1, "iterations": 20}  # as the nodes' quick.yaml
SETTINGS = {"sampler": "random", "spec": SPEC}


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study that was never disturbed, in this process."""
    return run_study(tmp_path_factory.mktemp("undisturbed") / "bag", N, name="s", settings=SETTINGS)


def in_child(what: Callable[[], int], file_bytes: int) -> int:
    """Run in a child process that may not write files longer than that; return its exit code."""

    def limited() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (file_bytes, file_bytes))
        os._exit(what())

    child = multiprocessing.get_context("fork").Process(target=limited)
    child.start()
    child.join(300)
    assert child.exitcode is not None
    return child.exitcode


@pytest.mark.slow
@pytest.mark.parametrize("file_bytes", [500, 6_000, 50_000, "all but the index"])
def test_nothing_is_published_that_is_not_recorded(
    undisturbed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, file_bytes: Any
) -> None:
    """Wherever a write fails, what was published before is in the bag, which resumes to the undisturbed trials."""
    bag = tmp_path / "bag"
    if isinstance(file_bytes, str):
        file_bytes = next(undisturbed.glob("*.mcap")).stat().st_size - 500
    reading, writing = os.pipe()
    do = Optimizer.__init__

    def telling(self: Any, *arguments: Any, **more: Any) -> None:
        publish = arguments[4]

        def tell(topic: str, data: bytes) -> None:
            os.write(writing, hashlib.sha256(data).digest())
            publish(topic, data)

        do(self, *arguments[:4], tell, *arguments[5:], **more)

    monkeypatch.setattr(Optimizer, "__init__", telling)

    def run() -> int:
        try:
            run_study(bag, N, name="s", settings=SETTINGS)
        except StudyError as error:
            return 1 if "cannot write the bag (File too large); the study stops here" in str(error) else 3
        return 0

    assert in_child(run, file_bytes) == 1
    monkeypatch.undo()
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        told = pipe.read()
    published = {told[i : i + 32] for i in range(0, len(told), 32)}
    contents = read_bag(bag) if list(bag.glob("*.mcap")) else []
    recorded = {hashlib.sha256(entry.data).digest() for entry in entries(contents)}
    assert published <= recorded
    for content in contents:
        assert content.fault == "cut off" and content.whole_bytes == content.path.stat().st_size
    run_study(bag, N, name="s", settings=SETTINGS, resume=True)
    assert values(bag) == values(undisturbed)


def test_a_short_write_is_cut_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A write of which the disk takes only a part leaves none of it, and no other follows it."""
    file = McapFile(tmp_path / "bag_0.mcap", {"study": "s"})
    file.write("/commands", "Command", bytes(100))
    size = file.path.stat().st_size
    raw, room = file._stream._file, [7]

    class Disk:
        def write(self, data: bytes) -> int:
            if not room[0]:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            done = raw.write(data[: room[0]])
            room[0] -= done
            return done

        truncate, close = raw.truncate, raw.close

    file._stream._file = Disk()  # type: ignore[assignment]
    with pytest.raises(StudyError, match="No space left on device"):
        file.write("/commands", "Command", bytes(100))
    assert not room[0] and file.path.stat().st_size == size
    room[0] = 10**6
    with pytest.raises(StudyError, match="failed before"):
        file.write("/commands", "Command", bytes(100))
    file.finish()
    assert file.path.stat().st_size == size


def test_recovery_without_room_leaves_the_old_file(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Neither the command nor a resumed study touches it, and nothing is left beside it."""
    bag = run_study(tmp_path / "bag", 40, name="s", settings=SETTINGS, kill_after=30)
    before = {path.name: path.read_bytes() for path in bag.iterdir() if path.name != ".lock"}
    for recover in (
        lambda: mobo("bag", "recover", bag),
        lambda: _recovered(bag),
    ):
        assert in_child(recover, 8_000) == 1
        assert {path.name: path.read_bytes() for path in bag.iterdir() if path.name != ".lock"} == before
    assert "File too large" in capfd.readouterr().err
    assert mobo("bag", "recover", bag) == 0
    assert len(values(bag)) == 30


def _recovered(bag: Path) -> int:
    try:
        recover_file(read_bag(bag)[0], {})
    except StudyError:
        return 1
    return 0


@pytest.mark.ros
def test_a_study_whose_disk_fills_says_so_once_and_goes_on_later(nodes: Nodes, tmp_path: Path) -> None:
    """The supervisor ends with 1 and leaves no process; with room again the trials are the undisturbed ones."""
    bag = tmp_path / "bag"
    parameters = {"sampler": "random", "evaluators": 1, "engine": "simulated", "simulated_s": 0.05}
    study = nodes.study(bag, n_trials=100_000, **parameters)
    wait_for(lambda: told_so_far(bag) >= 8, "8 trials")
    family = children_of(study.pid)
    (optimizer,) = [pid for pid in family if b"mobo.optimizer" in Path(f"/proc/{pid}/cmdline").read_bytes()]
    size = next(bag.glob("*.mcap")).stat().st_size + 10_000
    resource.prlimit(optimizer, resource.RLIMIT_FSIZE, (size, size))
    assert finish(study) == 1
    said = [line for line in output(study).splitlines() if "cannot write the bag" in line]
    assert len(said) == 1 and said[0].startswith("mobo optimizer: ") and "File too large" in said[0]
    assert "Traceback" not in output(study) and "resuming" not in output(study)
    assert not [pid for pid in family if alive(pid)]
    n = told_so_far(bag) + 12
    assert n >= 20
    again = nodes.study(bag, n_trials=n, **parameters, resume=True)
    assert finish(again) == 0, output(again)
    assert values(bag) == values(run_study(tmp_path / "undisturbed", n, name="s", settings=SETTINGS))


# Has even root obey the permissions of files: drops CAP_DAC_OVERRIDE and CAP_DAC_READ_SEARCH for what it runs.
BOUND = [
    sys.executable,
    "-c",
    "import ctypes, os, sys\n"
    "for capability in (1, 2): ctypes.CDLL(None).prctl(24, capability, 0, 0, 0)\n"
    "os.execv(sys.argv[1], sys.argv[1:])",
]


@pytest.mark.ros
def test_a_folder_that_is_read_only_is_refused(nodes: Nodes, tmp_path: Path, undisturbed: Path) -> None:
    """A new bag in it, and one in it to be resumed: exit code 2, one line, nothing touched."""
    shelf = tmp_path / "shelf"
    bag = Path(shutil.copytree(undisturbed, shelf / "bag"))
    for path in (*shelf.rglob("*"), shelf):
        path.chmod(path.stat().st_mode & ~(stat.S_IWUSR | stat.S_IWGRP | stat.S_IWOTH))
    before = {path.name: path.read_bytes() for path in bag.iterdir()}
    started = [
        nodes.optimizer(folder, on=BOUND, remap=f"__ns:=/{name}", sampler="random", resume=True)
        for name, folder in (("new", shelf / "new"), ("old", bag))
    ]
    for process in started:
        assert finish(process) == 2
        lines = [line for line in output(process).splitlines() if line]
        assert len(lines) == 1 and "Permission denied; expected a folder that can be made and written to" in lines[0]
    shelf.chmod(0o755)
    bag.chmod(0o755)
    assert not (shelf / "new").exists()
    assert {path.name: path.read_bytes() for path in bag.iterdir()} == before
