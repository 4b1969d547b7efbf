"""Real nodes as real processes, for tests: each test in a ROS domain of its own."""

from __future__ import annotations

import fcntl
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from mobo_core.bag.collector import read_study
from mobo_core.bag.record import StudyRecord

# A question that takes milliseconds: what the nodes do with it is the same.
QUICK_SPEC = "poses_per_voxel: 2\nrestarts: 1\niterations: 20\n"

# For what takes seconds: a machine may be busy with other things, and a longer wait costs only where a test fails.
PATIENCE_S = 300.0


@contextmanager
def own_domain() -> Iterator[dict[str, str]]:
    """Yield the environment of a ROS domain that no other test on this machine uses meanwhile."""
    for number in range(1, 100):
        with (Path(tempfile.gettempdir()) / f"mobo-test-domain-{number}").open("a") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            yield {
                **os.environ,
                "ROS_DOMAIN_ID": str(number),
                "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
                "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4",
            }
            return
    raise RuntimeError("no free ROS domain")


def ends_with_tests() -> dict[str, str]:
    """Return the environment of a node that ends if this process is killed: the next tests may be in its domain."""
    return {"MOBO_PARENT": f"{os.getpid()} {signal.SIGKILL}"}


class Node(subprocess.Popen[str]):
    """A node's process, whose output goes to a file.

    Attributes:
        log: where its output goes.
        was_signalled: whether the test had a hand in its end.
    """

    def __init__(self, command: Sequence[str], log: Path, environment: dict[str, str], folder: Path) -> None:
        self.log, self.was_signalled = log, False
        with log.open("w") as out:
            super().__init__(command, env=environment, stdout=out, stderr=subprocess.STDOUT, text=True, cwd=folder)

    def send_signal(self, sig: int) -> None:
        """Send a signal."""
        self.was_signalled |= sig not in (signal.SIGSTOP, signal.SIGCONT)
        super().send_signal(sig)


# Those of this process that were started and not ended by :meth:`Nodes.close`.
_RUNNING: list[Node] = []


class Nodes:
    """Starts nodes and ends them all at the end of a test."""

    def __init__(self, environment: dict[str, str], folder: Path) -> None:
        self.environment, self.folder = environment, folder
        self.spec = folder / "quick.yaml"
        self.spec.write_text(QUICK_SPEC)
        self._processes: list[Node] = []

    def start(
        self, executable: str, remap: str = "", on: Sequence[str] = (), arguments: Sequence[str] = (), **parameters: Any
    ) -> Node:
        """Start a node; its output goes to a file of its own, see :meth:`output`. ``on``: see ``hosts.Hosts.on``.

        ``arguments`` come before the parameters.
        """
        command = [*on, sys.executable, "-m", f"mobo.{executable}", "--ros-args"]
        command += [*(["-r", remap] if remap else []), *arguments]
        for name, value in parameters.items():
            command += ["-p", f"{name}:={json.dumps(str(value) if isinstance(value, Path) else value)}"]
        log = self.folder / f"{len(self._processes)}_{executable}.log"
        node = Node(command, log, self.environment | ends_with_tests(), self.folder)
        self._processes.append(node)
        _RUNNING.append(node)
        return node

    def study(self, bag: Path, **parameters: Any) -> Node:
        """Start a whole study with the quick spec."""
        return self.start("study", **{"bag": bag, "study_name": "s", "spec": self.spec, "workers": 1, **parameters})

    def optimizer(self, bag: Path, **parameters: Any) -> Node:
        """Start an optimizer with the quick spec."""
        return self.start("optimizer", **{"bag": bag, "study_name": "s", "spec": self.spec, **parameters})

    def close(self) -> None:
        """Kill what is left."""
        for process in self._processes:
            if process.poll() is None:
                process.kill()
            process.wait()
            _RUNNING.remove(process)


def output(node: Node) -> str:
    """Return what a node has printed so far."""
    return node.log.read_text()


def finish(process: Node, timeout_s: float = PATIENCE_S) -> int:
    """Wait for a node to end and return its exit code."""
    try:
        return process.wait(timeout_s)
    except subprocess.TimeoutExpired:
        process.send_signal(signal.SIGKILL)
        raise AssertionError(f"still running after {timeout_s:g} s:\n{output(process)}") from None


def wait_for(what: Callable[[], Any], text: str, timeout_s: float = PATIENCE_S, *, nodes_may_fail: bool = False) -> Any:
    """Wait until ``what`` returns something true, and return it.

    A node that fails meanwhile, or did unseen, ends the wait at once, unless ``nodes_may_fail``.
    """
    until = time.monotonic() + timeout_s
    while time.monotonic() < until:
        failed = [] if nodes_may_fail else [node for node in _RUNNING if _has_failed_unseen(node)]
        found = what()
        if found:
            return found
        for node in failed:
            last = "".join(output(node).splitlines(keepends=True)[-20:])
            raise AssertionError(f"waited for {text}, but {node.log.stem} ended with {node.returncode}:\n{last}")
        time.sleep(0.05)
    raise AssertionError(f"waited {timeout_s:g} s for {text}")


def _has_failed_unseen(node: Node) -> bool:
    """Return whether a node has ended with an error of which the test knows nothing yet."""
    return node.returncode is None and not node.was_signalled and node.poll() not in (None, 0)


def told_so_far(bag: Path) -> int:
    """Return how many trials a bag that is being written holds."""
    try:
        return len(read_study(bag).trials)
    except Exception:  # not there yet, or just being begun
        return 0


def values(bag: Path) -> list[tuple[Any, ...]]:
    """Return what defines a study's trials: (trial, parameters, state, reach, torque), by number."""
    study: StudyRecord = read_study(bag)
    assert not study.faults and not study.repeated
    found = []
    for number in sorted(study.trials):
        trial, candidate = study.trials[number], study.candidate_of(number)
        assert candidate is not None
        found.append((number, candidate.params_json, int(trial.state), trial.reach.hex(), trial.torque.hex()))
    return found


def control(environment: dict[str, str], *words: str) -> str:
    """Have the optimizer of these nodes do something and return what `control` prints; it must agree.

    On a busy machine `control` may give up before it has found the optimizer: then it is asked again.
    """
    command = [sys.executable, "-m", "mobo.control", *words]

    def done() -> subprocess.CompletedProcess[str] | None:
        asked = subprocess.run(
            command, env=environment, capture_output=True, text=True, timeout=PATIENCE_S, check=False
        )
        return None if "no optimizer in" in asked.stderr else asked

    asked: subprocess.CompletedProcess[str] = wait_for(done, "an optimizer to control")
    assert asked.returncode == 0, asked
    return asked.stdout


def alive(pid: int) -> bool:
    """Return whether a process runs: one that nobody has waited for yet, as an orphan's, does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except (FileNotFoundError, ProcessLookupError):
        return False


def children_of(pid: int) -> list[int]:
    """Return the process ids of all descendants."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                parent = int((entry / "stat").read_text().rsplit(")", 1)[1].split()[1])
            except (OSError, ValueError):
                continue
            if parent == pid:
                found += [int(entry.name), *children_of(int(entry.name))]
    return found
