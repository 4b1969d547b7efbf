"""Signals that come in bursts end a process, each time."""

from __future__ import annotations

import signal
import subprocess
import sys

_CHILD = """
from mobo_core.coordination.stop import Stop
stop = Stop()
print("ready", flush=True)
count = 0
while not stop:
    pass
print("stopped", flush=True)
while count < 2_000_000:  # signals go on
    count += 1
print("ended", flush=True)
"""


def test_bursts_of_signals_end_it_once() -> None:
    """Hundreds of SIGTERM and SIGINT, one within the other's handler: it stops, and nothing waits for itself."""
    with subprocess.Popen([sys.executable, "-c", _CHILD], stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        assert child.stdout.readline() == "ready\n"
        for _ in range(500):
            child.send_signal(signal.SIGTERM)
            child.send_signal(signal.SIGINT)
        assert child.communicate(timeout=300)[0] == "stopped\nended\n"
    assert child.returncode == 0
