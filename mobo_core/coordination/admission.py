"""Which evaluators get work: those of the study's engine whose kernel is this one's, and not too many at once."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

from mobo_core.evaluation.kernel_sources import kernel_hash
from mobo_core.evaluation.spec import lacks
from mobo_core.messages import EvaluatorStatus
from mobo_core.version import __version__

# Engines whose numbers come from the kernel's sources.
_OF_THE_KERNEL = ("kernel", "reference")
# Joins are recorded. So many may come at once, and then so many a second: a flood shall not fill the disk.
_JOINS, _JOINS_PER_S = 1000, 1.0
# Names that are remembered, so that each is told once.
_MOST_NAMED = 1000


class Admission:
    """Judges the heartbeats of evaluators that have no work yet.

    Args:
        engine: that the study goes by; "" for that of the first evaluator that joins.
        log: takes lines for people.
        warn: takes lines on what goes wrong.
        ik_mode: of the study's spec, which not every engine has.

    Attributes:
        engine: that the study goes by, "" as long as nobody knows.
    """

    def __init__(self, engine: str, log: Callable[[str], None], warn: Callable[[str], None], ik_mode: str) -> None:
        self.engine, self._log, self._warn, self._ik_mode = engine, log, warn, ik_mode
        self._named: set[str] = set()
        self._joins, self._at = float(_JOINS), 0.0

    @cached_property
    def _kernel_hash(self) -> str:
        return kernel_hash()

    def admits(self, status: EvaluatorStatus, now: float) -> bool:
        """Return whether an evaluator that is new may have work."""
        fault = self._fault(status)
        if not fault and not self._takes_join(now):
            fault = f"more than {_JOINS} evaluators joined in a short time"
        if fault:
            self._name(status.evaluator, fault)
            return False
        if not self.engine and status.engine:
            self.engine = status.engine
            say = self._warn if status.engine == "simulated" else self._log
            invented = ", which invents values" if status.engine == "simulated" else ""
            say(f"the study goes by engine {status.engine}{invented}: that of {status.evaluator}, which joined first")
        return True

    def _fault(self, status: EvaluatorStatus) -> str:
        if self.engine and status.engine != self.engine:
            return f"its engine is {status.engine or 'unknown'}, the study's {self.engine}"
        if lack := lacks(status.engine, self._ik_mode):
            return f"its engine, {status.engine}, lacks {lack}"
        if status.engine in _OF_THE_KERNEL and status.kernel_hash != self._kernel_hash:
            version = status.mobo_version or "of an unknown version"
            return f"its kernel (mobo {version}) is another than here ({__version__})"
        return ""

    def _takes_join(self, now: float) -> bool:
        self._joins = min(_JOINS, self._joins + max(0.0, now - self._at) * _JOINS_PER_S)
        self._at = now
        if self._joins < 1.0:
            return False
        self._joins -= 1.0
        return True

    def _name(self, evaluator: str, fault: str) -> None:
        if evaluator not in self._named and len(self._named) < _MOST_NAMED:
            self._named.add(evaluator)
            self._warn(f"{evaluator} gets no work: {fault}")
