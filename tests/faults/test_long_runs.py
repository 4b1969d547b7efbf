"""Twenty thousand trials: memory and bag stay within bounds. The optimizer killed and the disk filled, at length."""

from __future__ import annotations

import os
import random
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from nodes import Nodes, children_of, finish, output, values, wait_for
from rosbags.highlevel import AnyReader
from studies import mobo

pytestmark = [pytest.mark.ros, pytest.mark.timeout(1800)]

KB = 1000


def memory_kb(pid: int) -> int:
    """Return the resident memory of a process, in kB of 1024 bytes."""
    status = Path(f"/proc/{pid}/status").read_text()
    return int(next(line.split()[1] for line in status.splitlines() if line.startswith("VmRSS")))


def bag_bytes(bag: Path) -> int:
    return sum(path.stat().st_size for path in bag.glob("*.mcap"))


def until_bytes(bag: Path, n_bytes: float, optimizer: subprocess.Popen[str], timeout_s: float) -> None:
    wait_for(lambda: bag_bytes(bag) >= n_bytes or optimizer.poll() is not None, f"{n_bytes} bytes", timeout_s)


def test_twenty_thousand_trials_within_bounds(nodes: Nodes, tmp_path: Path) -> None:
    """Evaluators within 5 MB after the first 2,000 trials; optimizer at most 10 kB, bag at most 3 kB a trial,
    2 kB compacted; no growth where no trial is added.
    """
    bag, n = tmp_path / "bag", 20_000
    optimizer = nodes.optimizer(bag, n_trials=n, in_flight=64, sampler="tpe")
    evaluators = [nodes.start("evaluator", workers=2, engine="simulated", simulated_s=0.0) for _ in range(2)]
    a_trial = 2_300  # bytes of the bag, roughly: to count its trials would take too long
    until_bytes(bag, 2_000 * a_trial, optimizer, 600)
    before = [memory_kb(process.pid) for process in (optimizer, *evaluators)]
    until_bytes(bag, 19_000 * a_trial, optimizer, 1200)
    after = [memory_kb(process.pid) for process in (optimizer, *evaluators)]
    added = (bag_bytes(bag) - 2_000 * a_trial) / a_trial
    print(f"optimizer {(after[0] - before[0]) * 1.024 / added:.1f} kB a trial, evaluators "
          f"{[a - b for a, b in zip(after[1:], before[1:], strict=True)]} kB")  # fmt: skip
    assert (after[0] - before[0]) * 1.024 <= 10 * added
    for grown in (a - b for a, b in zip(after[1:], before[1:], strict=True)):
        assert grown * 1.024 <= 5_000
    assert finish(optimizer, 600) == 0, output(optimizer)
    with AnyReader([bag]) as reader:
        assert reader.topics["/trials"].msgcount == n
    live = bag_bytes(bag)
    assert live <= 3 * KB * n
    assert mobo("bag", "compact", bag) == 0
    print(f"bag {live / n:.0f} bytes a trial, compacted {bag_bytes(bag) / n:.0f}")
    assert bag_bytes(bag) <= 2 * KB * n
    # Resumed with nobody to evaluate, it waits and does not grow.
    for process in evaluators:
        process.terminate()
        finish(process)
    again = nodes.optimizer(bag, n_trials=n + 1, in_flight=64, resume=True)
    wait_for(lambda: len(list(bag.glob("*.mcap"))) == 2, "it to resume", 300)
    time.sleep(20)
    settled = memory_kb(again.pid)
    time.sleep(60)
    assert memory_kb(again.pid) - settled < 500
    assert (memory_kb(again.pid) - before[0]) * 1.024 <= 10 * n


def test_optimizer_killed_again_and_again(nodes: Nodes, tmp_path: Path) -> None:
    """Killed every few seconds through 500 trials of a study node, which resumes it: the undisturbed trials."""
    quiet, bag, n = tmp_path / "quiet", tmp_path / "bag", 500
    slow = {"engine": "simulated", "n_trials": n, "evaluators": 2, "workers": 2}
    assert finish(nodes.study(quiet, simulated_s=0.0, **slow), 300) == 0
    study = nodes.study(bag, simulated_s=0.25, **slow)
    chance, killed = random.Random(0), 0

    def optimizer() -> int:
        for pid in children_of(study.pid):
            try:
                if b"mobo.optimizer" in Path(f"/proc/{pid}/cmdline").read_bytes():
                    return pid
            except OSError:
                continue
        return 0

    size = 0
    while study.poll() is None and killed < 20:
        # By progress, so that each of them gets to tell something.
        size = bag_bytes(bag) + chance.randrange(5_000, 40_000)
        until_bytes(bag, size, study, 120)
        if pid := optimizer():
            os.kill(pid, 9)
            killed += 1
    assert finish(study, 600) == 0, output(study)
    assert killed >= 5
    assert values(bag) == values(quiet)
    with AnyReader([bag]) as reader:
        assert reader.topics["/trials"].msgcount == n


def _mounted(folder: Path, size: str) -> Callable[[], None]:
    folder.mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "none", str(folder)], check=True)
    return lambda: subprocess.run(["umount", "-l", str(folder)], check=True) and None


@pytest.mark.needs("root", "tmpfs")
def test_a_real_disk_fills_up_and_gets_room_again(nodes: Nodes, tmp_path: Path) -> None:
    """A tmpfs of 256 kB: exit code 1 and one line; no room to recover: the same; with room: undisturbed trials."""
    quiet, disk, n = tmp_path / "quiet", tmp_path / "disk", 300
    parameters = {"engine": "simulated", "simulated_s": 0.0, "n_trials": n, "evaluators": 1, "sampler": "random"}
    assert finish(nodes.study(quiet, **parameters), 300) == 0
    unmount = _mounted(disk, "256k")
    try:
        bag = disk / "bag"
        full = nodes.study(bag, **parameters)
        assert finish(full, 300) == 1
        assert output(full).count("cannot write the bag (No space left on device); the study stops here") == 1
        before = {path.name: path.read_bytes() for path in bag.glob("*.mcap")}
        still_full = nodes.study(bag, **parameters, resume=True)
        assert finish(still_full, 300) == 1
        assert output(still_full).count("No space left on device") == 1
        assert {path.name: path.read_bytes() for path in bag.glob("*.mcap")} == before
        subprocess.run(["mount", "-o", "remount,size=20m", str(disk)], check=True)
        again = nodes.study(bag, **parameters, resume=True)
        assert finish(again, 300) == 0, output(again)
        assert values(bag) == values(quiet)
        with AnyReader([bag]) as reader:
            assert reader.topics["/trials"].msgcount == n
        # A file system that is read-only: refused, not touched.
        subprocess.run(["mount", "-o", "remount,ro", str(disk)], check=True)
        refused = nodes.study(bag, **{**parameters, "n_trials": n + 10}, resume=True)
        assert finish(refused, 60) == 2
        assert "Read-only file system; expected a folder that can be made and written to" in output(refused)
    finally:
        unmount()
