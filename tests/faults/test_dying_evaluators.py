"""Evaluators that die all the time."""

from __future__ import annotations

import random
import time
from pathlib import Path

import pytest
from nodes import Nodes, finish, output, values

N = 500
EVALUATORS = 4

pytestmark = [pytest.mark.ros, pytest.mark.timeout(900)]


def test_a_random_one_of_four_is_killed_every_two_seconds(nodes: Nodes, tmp_path: Path) -> None:
    """Killed every 2 s and restarted a second later through 500 trials: the trials are those of a quiet study."""
    quiet, bag = tmp_path / "quiet", tmp_path / "bag"
    slow = {"engine": "simulated", "simulated_s": 0.2, "workers": 1}
    study = nodes.study(quiet, n_trials=N, evaluators=2, **{**slow, "workers": 4, "simulated_s": 0.0})
    assert finish(study, 300) == 0, output(study)
    optimizer = nodes.optimizer(bag, n_trials=N)
    running = [nodes.start("evaluator", **slow) for _ in range(EVALUATORS)]
    chance, killed = random.Random(0), 0
    until = time.monotonic() + 600
    while optimizer.poll() is None and time.monotonic() < until:
        time.sleep(1.0)
        place = chance.randrange(EVALUATORS)
        running[place].kill()
        running[place].wait()
        killed += 1
        time.sleep(1.0)
        running[place] = nodes.start("evaluator", **slow)
    assert finish(optimizer, 1) == 0, output(optimizer)
    assert killed > 10
    assert values(bag) == values(quiet)
    assert len(values(bag)) == N
