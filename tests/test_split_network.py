"""Evaluators on other hosts, whose links are cut and lose packets. Hosts are network namespaces; no root needed."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hosts import RANDOM_5_PERCENT, Hosts, lacking
from nodes import QUICK_SPEC, Nodes, finish, output, told_so_far, values, wait_for
from studies import run_study
from yaml import safe_load

from mobo_core.bag.collector import read_study
from mobo_core.messages import EvaluatorStatus

pytestmark = pytest.mark.ros

TPE = {"sampler": "tpe", "n_startup_trials": 10, "in_flight": 8}


@pytest.fixture
def hosts(nodes: Nodes) -> Iterator[Hosts]:
    """Three hosts, and nodes that look for each other beyond their own."""
    if lacking():
        pytest.skip(lacking())
    nodes.environment["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "SUBNET"
    with Hosts(3) as three:
        yield three


def undisturbed(bag: Path, n_trials: int) -> list[Any]:
    """Return the trials of the same study run without nodes, network or faults."""
    return values(run_study(bag, n_trials, name="s", settings={**TPE, "spec": safe_load(QUICK_SPEC)}))


def lost_and_joined(bag: Path) -> tuple[int, int]:
    """Return how often an evaluator was lost and how often one joined, as the bag has it."""
    kinds = EvaluatorStatus
    states = [int(status.state) for status in read_study(bag).evaluators]
    return states.count(kinds.LOST), states.count(kinds.JOINED)


def test_a_link_cut_and_healed_with_packets_lost_changes_nothing(nodes: Nodes, hosts: Hosts, tmp_path: Path) -> None:
    """One evaluator is cut off until it counts as lost, and comes back; every host drops 5 % of what it gets."""
    bag = tmp_path / "bag"
    slow = {"engine": "simulated", "simulated_s": 0.2, "workers": 2}
    for host in range(3):
        hosts.drop(host, *RANDOM_5_PERCENT)
    optimizer = nodes.optimizer(bag, n_trials=100_000, on=hosts.on(0), **TPE)  # it cannot end meanwhile
    for host in (1, 2):
        nodes.start("evaluator", f"__node:=e{host}", on=hosts.on(host), **slow)
    wait_for(lambda: told_so_far(bag) >= 6 and lost_and_joined(bag)[1] == 2, "both to work")
    hosts.cut(1)
    wait_for(lambda: lost_and_joined(bag)[0] >= 1, "the loss")
    hosts.heal(1)
    wait_for(lambda: lost_and_joined(bag)[1] >= 3, "its return")
    more = told_so_far(bag) + 8
    wait_for(lambda: told_so_far(bag) >= more, f"{more} trials")
    optimizer.send_signal(signal.SIGTERM)
    assert finish(optimizer) == 1, output(optimizer)
    told = values(bag)
    quiet = undisturbed(tmp_path / "quiet", told[-1][0] + 1)
    assert told == [quiet[trial[0]] for trial in told]
