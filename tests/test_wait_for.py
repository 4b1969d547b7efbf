"""What tests wait for: a node that dies ends the wait."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest
from nodes import Nodes, finish, wait_for


def test_a_node_that_fails_ends_the_wait_with_what_it_said(tmp_path: Path) -> None:
    """Whether it fails before or meanwhile; unless the test knows that it ended."""
    nodes = Nodes(dict(os.environ), tmp_path)
    try:
        node = nodes.start("none_of_this_name")
        with pytest.raises(AssertionError, match="(?s)waited for nothing, but 0_none.* ended with 1:.*No module named"):
            wait_for(lambda: False, "nothing", 60.0)
        assert finish(node) == 1
        began = time.monotonic()
        assert wait_for(lambda: time.monotonic() > began + 0.2, "some time")
        killed = nodes.start("none_of_this_name")
        killed.kill()
        assert wait_for(lambda: killed.poll() is not None, "its end")
    finally:
        nodes.close()
