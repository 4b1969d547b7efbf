"""Nothing of a node stays in /dev/shm: not after it ends, nor, once the next one has started, after it was killed."""

from __future__ import annotations

import contextlib
import fcntl
import os
import re
import signal
import subprocess
import time
from pathlib import Path

import pytest
from nodes import Nodes, finish, output, wait_for

from mobo.shared_memory import SHM_FOLDER, clean_shared_memory

SEGMENT, PORT = "fastrtps_0123456789abcdef", "fastrtps_port7413"


def test_only_what_nobody_holds_is_removed(tmp_path: Path) -> None:
    """Held pieces stay, and so do young ones and files of others; of a dead owner's all goes."""
    for name in (SEGMENT, PORT, "fastrtps_fedcba9876543210"):
        (tmp_path / name).touch()
        (tmp_path / f"{name}_el").touch()
    (tmp_path / f"sem.{PORT}_mutex").touch()
    for name in ("other", "fastrtps_portx_el", "sem.mp-12", f"{SEGMENT}_elx"):
        (tmp_path / name).touch()
    everything = set(os.listdir(tmp_path))
    assert clean_shared_memory(tmp_path, young_s=60.0) == 0
    assert set(os.listdir(tmp_path)) == everything
    with (tmp_path / f"{PORT}_el").open() as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        assert clean_shared_memory(tmp_path, young_s=-1.0) == 2
        gone = {SEGMENT, f"{SEGMENT}_el", "fastrtps_fedcba9876543210", "fastrtps_fedcba9876543210_el"}
        assert set(os.listdir(tmp_path)) == everything - gone
    assert clean_shared_memory(tmp_path, young_s=-1.0) == 1
    assert set(os.listdir(tmp_path)) == {"other", "fastrtps_portx_el", "sem.mp-12", f"{SEGMENT}_elx"}
    assert clean_shared_memory(tmp_path / "nowhere") == 0


def pieces(process: subprocess.Popen[str]) -> set[Path]:
    """Return the shared memory that a node owns, not what it maps of others; empty while it starts."""
    found = set()
    for link in Path(f"/proc/{process.pid}/fd").iterdir():
        with contextlib.suppress(OSError):  # closed meanwhile
            if match := re.fullmatch(rf"({SHM_FOLDER}/fastrtps_[0-9a-f]{{16}})_el", str(link.readlink())):
                found |= {Path(match[1]), Path(match[0])}
    return found


@pytest.mark.ros
def test_killed_nodes_leave_nothing_once_another_starts(nodes: Nodes, tmp_path: Path) -> None:
    """A living node keeps its shared memory; what a killed one left goes; SIGINT and SIGTERM leave nothing."""
    lives, killed = (nodes.start("evaluator", workers=1) for _ in range(2))
    held = [wait_for(lambda node=node: pieces(node), "its shared memory") for node in (lives, killed)]
    wait_for(lambda: "ready" in output(lives) and "ready" in output(killed), "the evaluators")
    killed.kill()
    killed.wait()  # what it leaves another test's node may take away before ours
    time.sleep(max(0.0, 2.1 - (time.time() - max(path.stat().st_mtime for path in held[1]))))
    bag = tmp_path / "bag"
    optimizer = nodes.optimizer(bag, n_trials=6, sampler="random")
    wait_for(lambda: not any(path.exists() for path in held[1]), "what was left to go")
    assert finish(optimizer) == 0, output(optimizer)  # the living evaluator answers
    assert all(path.exists() for path in held[0])
    lives.send_signal(signal.SIGTERM)
    assert finish(lives) == 0
    other = nodes.start("evaluator", workers=1)
    held.append(wait_for(lambda: pieces(other), "its shared memory"))
    wait_for(lambda: "ready" in output(other), "the evaluator")
    other.send_signal(signal.SIGINT)
    assert finish(other) == 0
    assert not any(path.exists() for paths in held for path in paths)
