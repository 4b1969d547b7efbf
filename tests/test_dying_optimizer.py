"""An optimizer that is killed five times: the bag is one record of the undisturbed trials."""

from __future__ import annotations

from pathlib import Path

import pytest
from nodes import Nodes, finish, output, told_so_far, values, wait_for
from rosbags.highlevel import AnyReader
from studies import mobo, run_study

pytestmark = [pytest.mark.ros, pytest.mark.timeout(240)]

N = 60
SPEC = {"poses_per_voxel": 2, "restarts": 1, "iterations": 20}  # as the nodes' quick.yaml


def test_optimizer_killed_five_times_and_resumed_changes_nothing(nodes: Nodes, tmp_path: Path) -> None:
    """Killed by progress, resumed each time, the evaluator never restarted; rosbags reads the bag to its end."""
    settings = {"sampler": "structured", "n_startup_trials": 15, "spec": SPEC}
    undisturbed = run_study(tmp_path / "undisturbed", N, name="s", settings=settings)
    bag = tmp_path / "bag"
    evaluator = nodes.start("evaluator", workers=2, engine="simulated", simulated_s=0.1)
    parameters = {"n_trials": N, "n_startup_trials": 15, "resume": True}
    for told in (4, 13, 22, 31, 40):
        optimizer = nodes.optimizer(bag, **parameters)
        wait_for(lambda told=told: told_so_far(bag) >= told, f"{told} trials")
        optimizer.kill()
        assert optimizer.wait() != 0
    optimizer = nodes.optimizer(bag, **parameters)
    assert finish(optimizer) == 0, output(optimizer)
    assert evaluator.poll() is None
    assert values(bag) == values(undisturbed)
    assert sorted(path.name for path in bag.glob("*.mcap")) == [f"bag_{i}.mcap" for i in range(6)]
    with AnyReader([bag]) as reader:
        told = [
            reader.deserialize(data, connection.msgtype).trial
            for connection, _, data in reader.messages()
            if connection.topic == "/trials"
        ]
    assert told == list(range(N))
    assert mobo("bag", "compact", bag) == 0
    assert values(bag) == values(undisturbed)
