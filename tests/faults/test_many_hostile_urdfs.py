"""Mutated URDFs and floods of answers, in numbers."""

from __future__ import annotations

from pathlib import Path

import pytest
from hostile import answers_to, candidate, live_evaluator
from nodes import Nodes, children_of, output
from peer import Peer
from test_hostile_candidates import check_mutated
from test_strangers import check_flood

from mobo_core.messages import Evaluation

pytestmark = [pytest.mark.ros, pytest.mark.timeout(900)]


def test_a_thousand_mutated_urdfs(nodes: Nodes, peer: Peer) -> None:
    """2,100 of them, 300 of a kind: each answered, by one and the same worker, which then still gives values."""
    evaluator = live_evaluator(nodes, peer)
    workers = children_of(evaluator.pid)
    for seed in range(7):
        check_mutated(peer, 300, seed)
        peer.heard.clear()
    (good,) = answers_to(peer, [candidate(100_000, "e1")]).values()
    assert good.status == Evaluation.OK
    assert children_of(evaluator.pid) == workers, output(evaluator)


def test_a_hundred_thousand_answers_nobody_asked_for(nodes: Nodes, peer: Peer, tmp_path: Path) -> None:
    """As in the short form, ten times as many."""
    check_flood(nodes, peer, tmp_path, bursts=100)
