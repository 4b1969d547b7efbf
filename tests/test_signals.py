"""SIGINT and SIGTERM, also where whoever started us ignores SIGINT, as a script's `command &` does."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from nodes import PATIENCE_S, Nodes, alive, children_of, finish, output, told_so_far, wait_for

IGNORING_SIGINT = ("env", "--ignore-signal=INT")


def test_children_of_tests_take_sigint() -> None:
    """A child that a test starts ends on SIGINT."""
    code = "import os, signal; os.kill(os.getpid(), signal.SIGINT); print('alive')"
    child = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert child.returncode == -signal.SIGINT and not child.stdout


def test_children_of_tests_take_sigint_where_the_run_ignores_it() -> None:
    """The test above, run by a pytest that was started with SIGINT ignored."""
    this = f"{__file__}::{test_children_of_tests_take_sigint.__name__}"
    command = [*IGNORING_SIGINT, sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", this]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout


@pytest.mark.ros
def test_nodes_started_with_sigint_ignored_end_on_sigterm(nodes: Nodes, tmp_path: Path) -> None:
    """And their children with them."""
    bag = tmp_path / "bag"
    parameters = {"bag": bag, "study_name": "s", "spec": nodes.spec, "workers": 1, "sampler": "random"}
    study = nodes.start("study", on=IGNORING_SIGINT, n_trials=100_000, evaluators=1, **parameters)
    wait_for(lambda: told_so_far(bag) >= 3, "3 trials")
    family = children_of(study.pid)
    assert len(family) == 3  # optimizer, evaluator, worker
    study.send_signal(signal.SIGTERM)
    assert finish(study) == 1, output(study)
    assert not [pid for pid in family if alive(pid)]


@pytest.mark.ros
@pytest.mark.parametrize("seconds", [0.0, 0.3])
def test_ctrl_c_while_ros2_run_starts_a_node_says_nothing(nodes: Nodes, tmp_path: Path, seconds: float) -> None:
    """Whatever the node is loading just then: it ends, without a traceback and without a bag."""
    command = [sys.executable, "-m", "mobo_ros2_standin", "run", "mobo", "optimizer", "--ros-args"]
    process = subprocess.Popen(
        [*command, "-p", f"bag:={tmp_path / 'bag'}"], env=nodes.environment, text=True, start_new_session=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )  # fmt: skip
    # Before, it is Python itself that starts: what it prints then is its own matter.
    wait_for(lambda: b"mobo_ros2_standin" not in Path(f"/proc/{process.pid}/cmdline").read_bytes(), "the node's start")
    time.sleep(seconds)
    process.send_signal(signal.SIGINT)
    said, _ = process.communicate(timeout=PATIENCE_S)
    assert process.returncode != 0 and "Traceback" not in said, said
    assert not (tmp_path / "bag").exists()
