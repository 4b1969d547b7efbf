"""The nodes that a study starts, as child processes."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

from mobo.runtime import PARENT_VARIABLE


class Child:
    """A node as a child process, which the kernel sends ``parting_signal`` if this process ends, however it ends."""

    def __init__(self, module: str, arguments: list[str], parting_signal: int) -> None:
        self._module, self._arguments, self._signal = module, arguments, parting_signal
        self.start()

    def start(self, more: list[str] | None = None) -> None:
        """Start it, again if it died."""
        command = [sys.executable, "-m", f"mobo.{self._module}", "--ros-args", *self._arguments, *(more or [])]
        parent = {PARENT_VARIABLE: f"{os.getpid()} {int(self._signal)}"}
        # A process group of its own: Ctrl-C reaches this node, which then ends the others in order.
        self.process = subprocess.Popen(command, env={**os.environ, **parent}, process_group=0)

    def stop(self, number: int = signal.SIGTERM) -> None:
        """Send it a signal if it runs."""
        if self.process.poll() is None:
            self.process.send_signal(number)

    def wait(self, until: float) -> None:
        """Wait for its end until then (monotonic s), and no longer: then it is killed."""
        try:
            self.process.wait(max(0.0, until - time.monotonic()))
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
