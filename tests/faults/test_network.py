"""Three hosts on a bridge: a link cut for 20 s, a minute of lost packets, healed. Hosts are network namespaces."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from hosts import MULTICAST, RANDOM_5_PERCENT, Hosts, address
from nodes import Nodes, finish, output, told_so_far, values, wait_for
from test_split_network import TPE, hosts, lost_and_joined, undisturbed

from mobo_core.bag.collector import read_study

pytestmark = [pytest.mark.ros, pytest.mark.timeout(900)]
__all__ = ["hosts"]


@contextmanager
def discovery_server(hosts: Hosts, host: int) -> Iterator[None]:
    """Run Fast DDS's discovery server on a host."""
    program = shutil.which("fast-discovery-server")
    if program is None:
        pytest.skip("lacks fast-discovery-server")
    environment = {**os.environ, "LD_LIBRARY_PATH": f"{sys.prefix}/lib:{os.environ.get('LD_LIBRARY_PATH', '')}"}
    command = [*hosts.on(host), program, "-i", "0", "-l", address(host), "-p", "11811"]
    server = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL)
    try:
        yield
    finally:
        server.kill()
        server.wait()


def test_twenty_seconds_without_a_link_and_a_minute_of_lost_packets(
    nodes: Nodes, hosts: Hosts, tmp_path: Path
) -> None:
    """The bag holds each trial once, and the trials of a study without nodes, network and faults."""
    bag, n = tmp_path / "bag", 900
    slow = {"engine": "simulated", "simulated_s": 0.3, "workers": 2}
    optimizer = nodes.optimizer(bag, n_trials=n, on=hosts.on(0), **TPE)
    for host in (1, 2):
        nodes.start("evaluator", f"__node:=e{host}", on=hosts.on(host), **slow)
    wait_for(lambda: told_so_far(bag) >= 20 and lost_and_joined(bag)[1] == 2, "both to work")
    hosts.cut(1)
    time.sleep(20.0)
    hosts.heal(1)
    cut = told_so_far(bag)
    wait_for(lambda: lost_and_joined(bag)[1] == 3, "the return")
    for host in range(3):
        hosts.drop(host, *RANDOM_5_PERCENT)
    time.sleep(60.0)
    for host in range(3):
        hosts.drop_nothing(host)
    assert optimizer.poll() is None, "the study ended before the faults did"
    lossy = told_so_far(bag)
    assert finish(optimizer, 300) == 0, output(optimizer)
    print(f"{cut} trials told when the link was healed, {lossy} when packets were no longer lost")
    assert values(bag) == undisturbed(tmp_path / "quiet", n)
    assert [trial for trial, *_ in values(bag)] == list(range(n))


def test_static_peers_get_through_where_multicast_does_not(nodes: Nodes, hosts: Hosts, tmp_path: Path) -> None:
    """With multicast dropped everywhere, the evaluator that is told the optimizer's address works, the other not."""
    bag, n = tmp_path / "bag", 20
    for host in range(3):
        hosts.drop(host, *MULTICAST)
    fast = {"engine": "simulated", "simulated_s": 0.0, "workers": 1}
    nodes.start("evaluator", "__node:=deaf", on=hosts.on(2), **fast)
    optimizer = nodes.optimizer(bag, n_trials=n, on=hosts.on(0), **TPE)
    nodes.environment["ROS_STATIC_PEERS"] = address(0)
    nodes.start("evaluator", "__node:=told", on=hosts.on(1), **fast)
    assert finish(optimizer) == 0, output(optimizer)
    assert {candidate.evaluator for candidate in read_study(bag).candidates} == {"told"}
    assert values(bag) == undisturbed(tmp_path / "quiet", n)


def test_a_discovery_server_gets_through_where_multicast_does_not(nodes: Nodes, hosts: Hosts, tmp_path: Path) -> None:
    """With multicast dropped everywhere, nodes that know a discovery server find each other."""
    bag, n = tmp_path / "bag", 20
    for host in range(3):
        hosts.drop(host, *MULTICAST)
    nodes.environment["ROS_DISCOVERY_SERVER"] = f"{address(0)}:11811"
    with discovery_server(hosts, 0):
        optimizer = nodes.optimizer(bag, n_trials=n, on=hosts.on(0), **TPE)
        nodes.start("evaluator", on=hosts.on(1), engine="simulated", simulated_s=0.0, workers=1)
        assert finish(optimizer) == 0, output(optimizer)
    assert values(bag) == undisturbed(tmp_path / "quiet", n)
