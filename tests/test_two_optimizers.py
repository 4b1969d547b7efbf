"""Two optimizers for one bag or one namespace: exactly one goes on, the other says who holds it."""

from __future__ import annotations

import heapq
import itertools
import os
import re
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from nodes import Nodes, finish, output, told_so_far, values, wait_for
from peer import Peer

from mobo_core.coordination.namespace_claim import CLAIM_FRESH_S, LISTEN_S, Claimant, NamespaceClaim, Rivals
from mobo_core.coordination.namespace_lock import NamespaceLock
from mobo_core.errors import InUseError
from mobo_core.messages import Header, encode

LEASE_S = 5.0


def run_claims(starts: list[float], clocks: list[float], delays: list[float], holder_dies: float) -> list[int]:
    """Let claimants claim one namespace; return those that went on, in order.

    Claimant i starts at ``starts[i]`` s with a clock ``clocks[i]`` s off, and is heard ``delays[i]`` s late. A
    holder from before is noticed to be gone at ``holder_dies`` s.
    """
    mes = [Claimant(int((start + clocks[i]) * 1e9), f"host{i}", i, "/optimizer") for i, start in enumerate(starts)]
    claims = [NamespaceClaim(me, start, lease_s=LEASE_S) for me, start in zip(mes, starts, strict=True)]
    holding: dict[int, float] = {-1: 0.0}
    waiting = set(range(len(starts)))
    events = [(start, i) for i, start in enumerate(starts)]
    heapq.heapify(events)
    said: dict[int, list[float]] = {i: [] for i in waiting}
    while events:
        now, i = heapq.heappop(events)
        for j, times in said.items():
            heard = max((t for t in times if t + delays[j] <= now), default=None)
            if j != i and heard is not None:
                claims[i].claimed(mes[j], max(heard + delays[j], starts[i]))
        alive = [j for j, t in holding.items() if (now < holder_dies if j == -1 else t + delays[j] <= now)]
        claims[i].alive(len(alive))
        try:
            if claims[i].may_go(now, "namespace /"):
                holding[i] = now
                waiting.discard(i)
                continue
        except InUseError:
            waiting.discard(i)
            continue
        said[i].append(now)
        heapq.heappush(events, (now + 0.1, i))
    return [j for j in holding if j >= 0]


@given(
    st.lists(
        st.tuples(st.floats(0, 8), st.floats(-100, 100), st.floats(0.001, 0.4 * LISTEN_S)), min_size=1, max_size=5
    ),
    st.sampled_from([0.0, 2.0, 4.0]),
)
def test_exactly_one_claimant_goes_on(claimants: list[tuple[float, float, float]], holder_dies: float) -> None:
    """Whenever they start, however their clocks differ and a holder from before dies: one of them, never two."""
    starts, clocks, delays = (list(column) for column in zip(*claimants, strict=True))
    assert len(run_claims(starts, clocks, delays, holder_dies)) == 1


def test_a_holder_that_stays_is_named_after_one_lease() -> None:
    """A claimant waits for the lease, no longer, and then says node, host and pid."""
    me, holder = Claimant(5, "here", 7, "/b"), Claimant(9, "there", 42, "/a")
    claim = NamespaceClaim(me, 0.0, lease_s=LEASE_S)
    claim.alive(1)
    claim.held(holder, 0.2)
    ticks = (0.1 * i for i in itertools.count(1))
    with pytest.raises(InUseError, match=r"namespace /x: in use by /a on there, pid 42; expected") as error:
        while not claim.may_go(now := next(ticks), "namespace /x"):
            pass
    assert error.value.exit_code == 2
    assert now == pytest.approx(0.1 + LEASE_S)


def test_one_message_does_not_end_who_runs() -> None:
    """Nor do many names heard once each, or one heard now and then; an older one that keeps saying so does."""
    rivals, older = Rivals(Claimant(5, "here", 7, "/b")), Claimant(1, "there", 42, "/a")
    assert not any(rivals.heard(older, now) for now in (0.0, 3.0, 6.0))
    assert not any(rivals.heard(older._replace(pid=i), 7.0 + i / 1000) for i in range(1000))
    assert not any(rivals.heard(Claimant(9, "there", 1, "/c"), now) for now in range(10))
    assert [rivals.heard(older, now) for now in (10.0, 11.0, 12.0)] == [False, False, True]


def test_claims_that_are_no_longer_repeated_do_not_count() -> None:
    """A claimant that died while it waited is not waited for."""
    claim = NamespaceClaim(Claimant(5, "here", 7, "/b"), 0.0, lease_s=LEASE_S)
    claim.claimed(Claimant(1, "there", 42, "/a"), 0.1)
    assert not claim.may_go(0.2, "")
    assert not claim.may_go(0.1 + CLAIM_FRESH_S, "")
    assert claim.may_go(0.1 + CLAIM_FRESH_S + LISTEN_S, "")


@pytest.mark.ros
def test_optimizers_started_at_once_in_one_namespace(nodes: Nodes, tmp_path: Path) -> None:
    """One goes on; the others name who was before them, exit with 2, make no folder; killed, it is followed."""
    bags = [tmp_path / f"bag{i}" for i in range(3)]
    started = [nodes.optimizer(bag, n_trials=4, sampler="random", lease_s=1.0) for bag in bags]
    wait_for(lambda: sum(process.poll() is not None for process in started) == 2, "two of them to end",
             nodes_may_fail=True)  # fmt: skip
    (holder,) = [i for i, process in enumerate(started) if process.poll() is None]
    wait_for(lambda: list(bags[holder].glob("*.mcap")), "its bag")
    for i, process in enumerate(started):
        if i != holder:
            assert process.returncode == 2
            last = output(process).splitlines()[-1]
            # On a busy machine one may come second to one that then gives way to the third, or so late that it meets
            # the namespace's lock, which knows no node's name.
            others = {f"pid {other.pid}" for other in started if other is not process}
            assert re.search("in use by (/optimizer|an optimizer) on ", last) and any(each in last for each in others)
            assert not bags[i].exists()
    # One that waits gets through when the holder is killed, and so does the same one started again.
    waiting = nodes.optimizer(bags[holder], n_trials=4, sampler="random", resume=True, lease_s=60.0)
    wait_for(lambda: f"pid {started[holder].pid}; waiting" in output(waiting), "it to wait")
    started[holder].kill()
    nodes.start("evaluator", workers=1)
    assert finish(waiting) == 0, output(waiting)
    assert len(values(bags[holder])) == 4


def test_a_namespace_is_one_process_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """In each ROS domain; who comes second learns who has it, and gets it when that one ends, however it ends."""
    namespace = f"/test_{os.getpid()}"
    module = NamespaceLock.__module__
    holding = f"from {module} import NamespaceLock as Lock; lock = Lock({namespace!r}); print(flush=True); input()"
    with subprocess.Popen([sys.executable, "-c", holding], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as holder:
        assert holder.stdout is not None and holder.stdout.readline()
        with pytest.raises(InUseError, match=f"in use by an optimizer on .*, pid {holder.pid}; expected a namespace"):
            NamespaceLock(namespace)
        known = Claimant(1, "here", holder.pid, "/left/optimizer")
        with pytest.raises(InUseError, match=f"in use by /left/optimizer on here, pid {holder.pid}"):
            NamespaceLock(namespace, lambda pid: known if pid == holder.pid else None)
        NamespaceLock(namespace + "/other").release()
        with monkeypatch.context() as other_domain:
            other_domain.setenv("ROS_DOMAIN_ID", "77")
            NamespaceLock(namespace).release()
        holder.kill()
    NamespaceLock(namespace).release()


def test_a_claimant_knows_those_it_has_heard_of() -> None:
    """By process, on its own host."""
    claim = NamespaceClaim(Claimant(5, "here", 7, "/b"), 0.0, lease_s=LEASE_S)
    rival, holder = Claimant(1, "here", 42, "/a"), Claimant(2, "there", 43, "/c")
    claim.claimed(rival, 0.0)
    claim.held(holder, 0.0)
    assert claim.known(42) == rival and claim.known(43) is None and claim.known(1) is None


@pytest.mark.ros
def test_two_optimizers_on_a_busy_machine(nodes: Nodes, tmp_path: Path) -> None:
    """Started 2 s apart in each of two namespaces, while others take all cores: one of each pair goes on."""
    busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(os.cpu_count() or 1)]
    try:
        spaces = range(2)

        def start(which: str) -> list[subprocess.Popen[str]]:
            return [
                nodes.start(
                    "optimizer", f"__ns:=/n{i}", bag=tmp_path / f"{which}{i}", spec=nodes.spec, lease_s=0.5
                )
                for i in spaces
            ]  # fmt: skip

        first = start("a")
        with pytest.raises(subprocess.TimeoutExpired):
            first[0].wait(2.0)
        pairs = list(zip(first, start("b"), strict=True))
        for pair in pairs:
            wait_for(lambda pair=pair: any(node.poll() is not None for node in pair), "one of a pair to end",
                     nodes_may_fail=True)  # fmt: skip
        wait_for(lambda: len(list(tmp_path.glob("*/*.mcap"))) == 2, "two bags")
        for pair in pairs:
            (holder,) = [node for node in pair if node.poll() is None]
            (other,) = [node for node in pair if node.poll() is not None]
            assert other.returncode == 2 and f"pid {holder.pid}; expected" in output(other).splitlines()[-1]
    finally:
        for process in busy:
            process.kill()
            process.wait()


@pytest.mark.ros
def test_of_two_that_run_after_all_the_later_one_ends(nodes: Nodes, peer: Peer, tmp_path: Path) -> None:
    """A holder answers a younger one with its name, and ends when it keeps hearing of an older one."""
    from mobo.namespace_claim import _holders_qos
    from mobo_msgs.msg import OptimizerStatus as Kind

    peer.hear("optimizers", "OptimizerStatus", Kind, latched=True)
    optimizer = nodes.optimizer(tmp_path / "bag", n_trials=4)
    peer.until(lambda: "optimizers" in peer.heard, "it to hold its namespace")
    publisher = peer.node.create_publisher(Kind, "optimizers", _holders_qos())
    own = peer.heard["optimizers"][0]
    younger = replace(own, header=Header.at(own.header.time_ns + 1), pid=1, optimizer="/younger")
    older = replace(own, header=Header.at(own.header.time_ns - 1), pid=2, optimizer="/older")
    for once in (younger, older):
        publisher.publish(encode(once))
    peer.until(lambda: sum(m.pid == own.pid for m in peer.heard["optimizers"]) >= 3, "it to repeat its name")
    assert optimizer.poll() is None
    peer.until(lambda: publisher.publish(encode(older)) or optimizer.poll() is not None, "it to end")
    assert optimizer.returncode == 2
    assert f"in use by /older on {own.host_id}, pid 2; expected" in output(optimizer).splitlines()[-1]


@pytest.mark.ros
def test_two_optimizers_on_one_bag_in_two_namespaces(nodes: Nodes, tmp_path: Path) -> None:
    """The bag's lock lets one of them write; another names it, and gets through once it is killed."""
    bag = tmp_path / "bag"
    first = nodes.optimizer(bag, n_trials=1000)
    wait_for(lambda: list(bag.glob("*.mcap")), "the bag")
    other = {"remap": "__ns:=/other", "bag": bag, "study_name": "s", "spec": nodes.spec, "resume": True}
    second = nodes.start("optimizer", **other, lease_s=0.5)
    assert finish(second) == 2
    assert output(second).splitlines()[-1].endswith(f"pid {first.pid}; expected a bag no optimizer writes to")
    third = nodes.start("optimizer", **other, lease_s=60.0)
    wait_for(lambda: f"pid {first.pid}; expected a bag no optimizer writes to; waiting" in output(third), "it to wait")
    first.kill()
    wait_for(lambda: len(list(bag.glob("*.mcap"))) == 2, "the third to write")
    third.send_signal(signal.SIGTERM)
    assert finish(third) == 1
    assert told_so_far(bag) == 0
