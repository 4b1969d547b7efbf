"""An optimizer that is killed again and again: the bag is one record of the undisturbed trials."""

from __future__ import annotations

from pathlib import Path

import pytest
from nodes import Nodes, finish, output, told_so_far, values, wait_for
from rosbags.highlevel import AnyReader
from studies import mobo, run_study

pytestmark = pytest.mark.ros

KILLS = 4
SPEC = {"poses_per_voxel": 2, "restarts": 1, "iterations": 20}  # as the nodes' quick.yaml


def test_optimizer_killed_again_and_again_and_resumed_changes_nothing(nodes: Nodes, tmp_path: Path) -> None:
    """Killed after a few trials, resumed each time, the evaluator never restarted; rosbags reads the bag to its end."""
    bag = tmp_path / "bag"
    evaluator = nodes.start("evaluator", workers=2, engine="simulated", simulated_s=0.1)
    parameters = {"n_startup_trials": 15, "resume": True}
    for _ in range(KILLS):
        more = told_so_far(bag) + 4
        optimizer = nodes.optimizer(bag, n_trials=100_000, **parameters)  # it cannot end before it is killed
        wait_for(lambda more=more: told_so_far(bag) >= more, f"{more} trials")
        optimizer.kill()
        assert optimizer.wait() != 0
    n = told_so_far(bag) + 12
    optimizer = nodes.optimizer(bag, n_trials=n, **parameters)
    assert finish(optimizer) == 0, output(optimizer)
    assert evaluator.poll() is None
    settings = {"sampler": "structured", "n_startup_trials": 15, "spec": SPEC}
    undisturbed = run_study(tmp_path / "undisturbed", n, name="s", settings=settings)
    assert values(bag) == values(undisturbed)
    assert sorted(path.name for path in bag.glob("*.mcap")) == [f"bag_{i}.mcap" for i in range(KILLS + 1)]
    with AnyReader([bag]) as reader:
        told = [
            reader.deserialize(data, connection.msgtype).trial
            for connection, _, data in reader.messages()
            if connection.topic == "/trials"
        ]
    assert told == list(range(n))
    assert mobo("bag", "compact", bag) == 0
    assert values(bag) == values(undisturbed)
