"""How well optimizer and evaluators are: a level, a line for people, and figures. Published as /diagnostics."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from shutil import disk_usage

from mobo_core.coordination.dispatch import Dispatcher
from mobo_core.coordination.optimizer import Optimizer

_WARN_FREE_BYTES = 1_000_000_000
_ERROR_FREE_BYTES = 100_000_000
# A share of failed trials above which something is wrong, once there are enough of them to tell.
_MANY_FAILED, _ENOUGH = 0.1, 10


class Level(IntEnum):
    """As in diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2


@dataclass(frozen=True)
class Health:
    """A level, the reason for it, and figures by name, units in the names."""

    level: Level
    message: str
    figures: dict[str, str]


class Rate:
    """Events per second over the last ``window_s`` seconds.

    Args:
        window_s: s.
    """

    def __init__(self, window_s: float = 10.0) -> None:
        self._window_s = window_s
        self._points: deque[tuple[float, int]] = deque()

    def at(self, now: float, count: int) -> float:
        """Take how many events there were in all at ``now`` (s); return the rate."""
        self._points.append((now, count))
        while len(self._points) > 2 and self._points[1][0] <= now - self._window_s:
            self._points.popleft()
        (since, before) = self._points[0]
        return (count - before) / (now - since) if now > since else 0.0


def bag_bytes(folder: Path) -> int:
    """Return the size of a bag's files; 0 if there are none."""
    try:
        return sum(entry.stat().st_size for entry in folder.iterdir())
    except OSError:
        return 0


def free_bytes(folder: Path) -> int | None:
    """Return the room left where a bag is; None if that cannot be told."""
    try:
        return disk_usage(folder).free
    except OSError:
        return None


def optimizer_health(
    *,
    told: int,
    n_trials: int,
    in_flight: int,
    failed: int,
    waiting: int,
    resent: int,
    evaluators: int,
    workers: int,
    paused: bool,
    trials_per_s: float,
    bag_bytes: int,
    free_bytes: int | None,
) -> Health:
    """Return the health of an optimizer; ``waiting`` counts the trials without an answer that nobody evaluates."""
    figures = {
        "trials_told": f"{told}", "trials": f"{n_trials}", "trials_in_flight": f"{in_flight}",
        "trials_failed": f"{failed}", "trials_per_s": f"{trials_per_s:.2f}", "queue": f"{waiting}",
        "candidates_resent": f"{resent}", "evaluators": f"{evaluators}", "workers": f"{workers}",
        "bag_bytes": f"{bag_bytes}", "free_disk_bytes": "unknown" if free_bytes is None else f"{free_bytes}",
    }  # fmt: skip
    said = f"{told} of {n_trials} trials told"
    left = math.inf if free_bytes is None else free_bytes
    if left < _ERROR_FREE_BYTES:
        return Health(Level.ERROR, f"{left / 1e6:.0f} MB left for the bag", figures)
    if paused:
        return Health(Level.WARN, f"paused; {said}", figures)
    if not evaluators and told < n_trials:
        return Health(Level.WARN, f"no evaluator; {said}", figures)
    if told >= _ENOUGH and failed > _MANY_FAILED * told:
        return Health(Level.WARN, f"{failed} of {told} trials failed", figures)
    if left < _WARN_FREE_BYTES:
        return Health(Level.WARN, f"{left / 1e6:.0f} MB left for the bag", figures)
    return Health(Level.OK, said, figures)


class StudyHealth:
    """The health of an optimizer, to be asked for now and then.

    Args:
        optimizer: a running one.
        dispatcher: its dispatcher.
        bag: folder of its bag.
    """

    def __init__(self, optimizer: Optimizer, dispatcher: Dispatcher, bag: Path) -> None:
        self._optimizer, self._dispatcher, self._bag = optimizer, dispatcher, bag
        self._rate = Rate()

    def at(self, now: float) -> Health:
        """Return the health at ``now`` (s)."""
        optimizer, alive = self._optimizer, self._dispatcher.evaluators
        told = len(optimizer.study.told)
        return optimizer_health(
            told=told, n_trials=optimizer.n_trials, in_flight=len(optimizer.study.asked) - told,
            failed=optimizer.failed, waiting=self._dispatcher.waiting, resent=optimizer.resent, evaluators=len(alive),
            workers=sum(alive.values()), paused=optimizer.controls.paused, trials_per_s=self._rate.at(now, told),
            bag_bytes=bag_bytes(self._bag), free_bytes=free_bytes(self._bag),
        )  # fmt: skip


def evaluator_health(*, workers: int, ready: int, restarts: int, held: int, answered: int) -> Health:
    """Return the health of an evaluator; ``held`` counts its candidates, ``restarts`` the workers replaced so far."""
    figures = {
        "workers": f"{workers}", "workers_ready": f"{ready}", "worker_restarts": f"{restarts}",
        "candidates_held": f"{held}", "answered": f"{answered}",
    }  # fmt: skip
    said = f"{ready} of {workers} workers ready"
    level = Level.OK if ready == workers else Level.WARN if ready else Level.ERROR
    return Health(level, said, figures)
