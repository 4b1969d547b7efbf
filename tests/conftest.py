"""What all tests share."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings
from nodes import Nodes, own_domain
from peer import Peer

from mobo_core.commands import progress

# What starts in the background of a script ignores SIGINT, and so would all that the tests start.
signal.signal(signal.SIGINT, signal.default_int_handler)

# The same examples on every run, however slow the machine; `--hypothesis-profile=default` looks for new ones.
settings.register_profile("mobo", deadline=None, derandomize=True, database=None, max_examples=50)
settings.load_profile("mobo")


@pytest.fixture(autouse=True)
def _no_lines_of_progress(monkeypatch: pytest.MonkeyPatch) -> None:
    """Commands in the tests' own process say nothing of how far they are, however slow the machine."""
    monkeypatch.setattr(progress, "FIRST_S", 1e6)


@pytest.fixture
def nodes(tmp_path: Path) -> Iterator[Nodes]:
    """Nodes in a ROS domain of their own."""
    with own_domain() as environment:
        started = Nodes(environment, tmp_path)
        try:
            yield started
        finally:
            started.close()


@pytest.fixture
def peer(nodes: Nodes, monkeypatch: pytest.MonkeyPatch) -> Iterator[Peer]:
    """A node in the domain of this test's nodes."""
    for name in ("ROS_DOMAIN_ID", "ROS_AUTOMATIC_DISCOVERY_RANGE", "FASTDDS_BUILTIN_TRANSPORTS"):
        monkeypatch.setenv(name, nodes.environment[name])
    made = Peer(nodes.environment)
    yield made
    made.close()
