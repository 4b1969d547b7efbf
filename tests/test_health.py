"""Health of optimizer and evaluators, and what of it goes out on /diagnostics."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from nodes import Nodes, told_so_far, wait_for

from mobo_core.coordination.health import Level, Rate, bag_bytes, evaluator_health, free_bytes, optimizer_health

WELL = {
    "told": 50, "n_trials": 100, "in_flight": 8, "failed": 0, "waiting": 2, "resent": 0, "evaluators": 2,
    "workers": 4, "paused": False, "trials_per_s": 2.5, "bag_bytes": 1000, "free_bytes": 10**12,
}  # fmt: skip


@pytest.mark.parametrize(
    ("change", "level", "says"),
    [
        ({}, Level.OK, "50 of 100"),
        ({"evaluators": 0}, Level.WARN, "no evaluator"),
        ({"evaluators": 0, "told": 100}, Level.OK, "100 of 100"),
        ({"paused": True}, Level.WARN, "paused"),
        ({"failed": 6}, Level.WARN, "6 of 50"),
        ({"failed": 5}, Level.OK, "50 of 100"),
        ({"told": 3, "failed": 3}, Level.OK, "3 of 100"),  # too few to tell
        ({"free_bytes": 5 * 10**8}, Level.WARN, "500 MB"),
        ({"free_bytes": 5 * 10**7, "paused": True}, Level.ERROR, "50 MB"),
        ({"free_bytes": 0}, Level.ERROR, "0 MB left"),
        ({"free_bytes": None}, Level.OK, "50 of 100"),  # cannot be told
    ],
)
def test_health_of_an_optimizer(change: dict[str, Any], level: Level, says: str) -> None:
    """The worst that is so decides; the figures are there whatever the level."""
    health = optimizer_health(**{**WELL, **change})
    assert health.level is level and says in health.message
    assert health.figures["trials_per_s"] == "2.50" and health.figures["queue"] == "2"


def test_health_of_an_evaluator() -> None:
    """Fewer workers ready than there are: a warning; none: an error."""
    for ready, level in ((4, Level.OK), (3, Level.WARN), (0, Level.ERROR)):
        health = evaluator_health(workers=4, ready=ready, restarts=1, held=2, answered=9)
        assert health.level is level and f"{ready} of 4" in health.message
        assert health.figures["worker_restarts"] == "1"


def test_rate_is_that_of_the_last_seconds() -> None:
    """Steady counts give their rate, at once and when the pace has changed for longer than the window."""
    rate = Rate(10.0)
    assert rate.at(0.0, 0) == 0.0
    assert [rate.at(float(t), 3 * t) for t in range(1, 20)] == pytest.approx([3.0] * 19)
    assert [rate.at(float(t), 57) for t in range(20, 40)][-1] == 0.0


def test_sizes(tmp_path: Path) -> None:
    """Of a bag's files together; nothing, not an error, where there is none. A full disk is not an unknown one."""
    (tmp_path / "a_0.mcap").write_bytes(b"1234")
    (tmp_path / "metadata.yaml").write_bytes(b"12")
    assert bag_bytes(tmp_path) == 6 and (free_bytes(tmp_path) or 0) > 0
    assert bag_bytes(tmp_path / "none") == 0 and free_bytes(tmp_path / "none") is None


_LISTEN = """
import sys, rclpy
from diagnostic_msgs.msg import DiagnosticArray
rclpy.init()
node = rclpy.create_node("listener")
def show(array):
    for s in array.status:
        print(s.level[0], s.name, s.hardware_id, {v.key: v.value for v in s.values}, flush=True)
node.create_subscription(DiagnosticArray, "/diagnostics", show, 10)
rclpy.spin(node)
"""


@pytest.mark.ros
def test_diagnostics_topic(nodes: Nodes, tmp_path: Path) -> None:
    """Optimizer and evaluator are on it; with its evaluator gone, the optimizer's level is WARN."""
    bag = tmp_path / "bag"
    nodes.optimizer(bag, n_trials=100_000, sampler="random")
    evaluator = nodes.start("evaluator", "__node:=e", workers=1, engine="simulated", simulated_s=0.05)
    with (tmp_path / "said").open("w") as said:
        listener = subprocess.Popen([sys.executable, "-c", _LISTEN], env=nodes.environment, stdout=said)
    try:
        wait_for(lambda: told_so_far(bag) > 3, "trials")

        def heard(*words: str, after: int = 0) -> int:
            lines = (tmp_path / "said").read_text().splitlines()
            return next((i + 1 for i, line in enumerate(lines[after:], after) if all(w in line for w in words)), 0)

        wait_for(lambda: heard("0 e: workers", "'workers_ready': '1'"), "the evaluator's health")
        well = wait_for(lambda: heard("0 optimizer: study", "'evaluators': '1'"), "the optimizer's health")
        evaluator.send_signal(signal.SIGINT)
        wait_for(lambda: heard("1 optimizer: study", "'evaluators': '0'", after=well), "the optimizer's warning")
    finally:
        listener.kill()
        listener.wait()
