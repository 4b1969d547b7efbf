"""Fresh seeds of the simulated system for an hour; bugs planted on purpose are found by them within a minute each."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from itertools import count, takewhile

import pytest
from studies import mobo
from test_simulate import BUGS, found

from mobo_core.simulate.faults import KINDS

# Of fresh seeds; and s of CPU for a planted bug.
MINUTES = float(os.environ.get("MOBO_SIMULATE_MINUTES", "60"))
SOON_S = 60.0


@pytest.mark.timeout(60 * MINUTES + 600)
def test_fresh_seeds(capsys: pytest.CaptureFixture[str]) -> None:
    """None of them breaks a promise; the command prints how many trials that were, and the faults."""
    seed = time.time_ns() // 10**9
    code = mobo("simulate", "--seed", str(seed), "--minutes", str(MINUTES), "--workers", "2")
    with capsys.disabled():
        print(capsys.readouterr().out)
    assert code == 0


@pytest.mark.parametrize("bug", BUGS, ids=lambda bug: bug.__name__.strip("_"))
def test_planted_bugs_are_found_soon(
    bug: Callable[[pytest.MonkeyPatch], None], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Whatever the seeds, one of those that a minute has room for breaks a rule that the bug breaks."""
    bug(monkeypatch)
    began = time.process_time()
    seeds = takewhile(lambda seed: time.process_time() - began < SOON_S, count(time.time_ns() // 10**9))
    seed = found(bug, seeds, tuple(KINDS))
    assert seed is not None
    with capsys.disabled():
        print(f"\n{bug.__name__}: seed {seed}, after {time.process_time() - began:.1f} s of CPU")
