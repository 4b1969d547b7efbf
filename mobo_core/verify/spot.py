"""A look at a bag that is gone on with: whether a few of its answers verify. In a process of its own.

Run as ``python -m mobo_core.verify.spot BAG PARENT_PID``; it prints a line for each of the first faults.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

_SAMPLE, _MOST_SHOWN = 4, 3
_PATIENCE_S = 10.0


class SpotCheck:
    """Evaluates some answers of a bag again while its study goes on.

    Args:
        bag: its folder.
    """

    def __init__(self, bag: Path) -> None:
        command = [sys.executable, "-m", "mobo_core.verify.spot", str(bag), str(os.getpid())]
        self._process: subprocess.Popen[str] | None = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
            errors="replace",
        )  # fmt: skip

    def lines(self, wait: bool = False) -> list[str]:
        """Return what it found, once, when it is done; ``wait`` for that, but not for long."""
        process = self._process
        if process is None or (not wait and process.poll() is None):
            return []
        self._process = None
        try:
            found, _ = process.communicate(timeout=_PATIENCE_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            return []
        return found.splitlines()

    def close(self) -> None:
        """End it."""
        if self._process is not None:
            self._process.kill()
            self._process.communicate()
            self._process = None


def spot_faults(bag: Path, sample: int = _SAMPLE) -> list[str]:
    """Return what is wrong with a bag's history and with ``sample`` of its evaluations made again, a line each."""
    from mobo_core.bag.collector import read_study
    from mobo_core.verify.evaluations import evaluated_again, evaluation_jobs, faults_of, sampled
    from mobo_core.verify.history import History

    history = History(read_study(bag))
    history.replay()
    jobs = evaluation_jobs(history.study, history)
    faults = [fault for fault in history.faults if fault.trial >= 0]
    for again in evaluated_again(sampled(jobs, sample), 1):
        faults += faults_of(again, history.unsaid)[0]
    shown = [str(fault) for fault in faults[:_MOST_SHOWN]]
    if faults:
        first = max(0, min(fault.trial for fault in faults))
        shown.append(f"{bag} does not verify: mobo verify says more, mobo bag cut {bag} --before {first} is the remedy")
    return shown


def main() -> None:
    """Print what a look at a bag shows."""
    from mobo_core.coordination.processes import die_with_parent

    bag, parent = Path(sys.argv[1]), int(sys.argv[2])
    die_with_parent(parent)
    os.nice(10)
    for line in spot_faults(bag):
        print(line)


if __name__ == "__main__":
    main()
