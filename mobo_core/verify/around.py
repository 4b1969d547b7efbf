"""What goes on around the trials of a study: commands, evaluators that come and go, statuses."""

from __future__ import annotations

import math
from collections.abc import Callable

from mobo_core.bag.validity import values_of
from mobo_core.coordination.control import COMMANDS
from mobo_core.messages import Candidate, Command, EvaluatorStatus, StudyStatus, Trial
from mobo_core.search.front import RunningFront
from mobo_core.search.study import StudySettings

# Relative: sums of the same numbers in another order.
_ROUNDING = 1e-9


class Around:
    """Takes the messages that are not about one trial, in their order.

    Args:
        settings: of the study.
        blame: takes (trial or -1, field, text) of what cannot have happened.

    Attributes:
        paused: whether nothing may be sent out.
        joined: evaluators that are there.
    """

    def __init__(self, settings: StudySettings, blame: Callable[[int, str, str], None]) -> None:
        self.settings, self._blame = settings, blame
        self.paused = False
        self.joined: set[str] = set()
        self._resent: int | None = None  # in this session, if its beginning is known
        self._front = RunningFront(settings.aims)
        self._best_reach, self._n_told, self._n_failed = 0.0, 0, 0
        self._enqueued: set[int] = set()

    def sent(self, candidate: Candidate) -> None:
        """Take a candidate."""
        if self._resent is not None:
            self._resent += candidate.attempt > 1

    def count(self, told: Trial) -> None:
        """Take a trial that was told."""
        self._n_told += 1
        if told.state != Trial.COMPLETE:
            self._n_failed += 1
            return
        values = values_of(told, self.settings.objectives)
        if all(map(math.isfinite, values)):
            self._front.add(values)
            self._best_reach = max(self._best_reach, told.reach)

    def command(self, command: Command, asked: int, told: int, *, sent_before: bool) -> None:
        """Take a command; ``asked`` trials were sent out, ``told`` told."""
        name, number = command.command, command.trial
        if name not in COMMANDS:
            return self._blame(number, "command", f"unknown: {name[:40]!r}")
        if name == "enqueue":
            if sent_before:
                self._blame(number, "command", "enqueued after it had been sent out")
            if number in self._enqueued:
                self._blame(number, "command", "enqueued more than once")
            self._enqueued.add(number)
            return
        if command.arguments_json != "{}":
            self._blame(number, "command", f"{name} with arguments {command.arguments_json[:40]!r}")
        if not asked <= number <= told + self.settings.in_flight:
            self._blame(number, "command", f"{name} at trial {number}, when {asked} were sent out")
        if name in ("pause", "resume"):
            if self.paused == (name == "pause"):
                self._blame(number, "command", f"{name}, though it was {'' if self.paused else 'not '}paused")
            self.paused = name == "pause"

    def evaluator(self, status: EvaluatorStatus) -> None:
        """Take who joined, left or was lost."""
        known = status.evaluator in self.joined
        if status.state == EvaluatorStatus.JOINED:
            self.joined.add(status.evaluator)
        elif status.state not in (EvaluatorStatus.LEFT, EvaluatorStatus.LOST):
            self._blame(-1, "evaluators", f"{status.evaluator[:80]!r} in state {status.state}, which is not recorded")
        elif not known:
            self._blame(-1, "evaluators", f"{status.evaluator[:80]!r} left or was lost without having joined")
        self.joined -= {status.evaluator} if status.state != EvaluatorStatus.JOINED else set()

    def status(self, status: StudyStatus, asked: int, told: int) -> None:
        """Take what the optimizer said of the study; errors in what the bag can derive are its faults."""
        if status.state == StudyStatus.RUNNING:
            self.joined.clear()
            self._resent = 0
        elif status.state not in (StudyStatus.DONE, StudyStatus.STOPPED):
            self._blame(-1, "study", f"state {status.state}, which is not recorded")
        if status.state == StudyStatus.DONE and status.told < status.n_trials:
            self._blame(-1, "study", f"done with {status.told} of {status.n_trials} trials")
        derived: list[tuple[str, float, float]] = [
            ("told", status.told, self._n_told),
            ("failed", status.failed, self._n_failed),
            ("front_size", status.front_size, len(self._front)),
            ("best_reach", status.best_reach, self._best_reach),
            ("hypervolume", status.hypervolume, self._front.hypervolume),
        ]
        if self._resent is not None:
            derived.append(("resent", status.resent, self._resent))
        for name, said, found in derived:
            if not abs(said - found) <= _ROUNDING * abs(found):
                self._blame(-1, "study", f"its status says {name} {said!r}, but the bag holds {found!r}")
        if not asked <= status.asked <= told + self.settings.in_flight:
            self._blame(-1, "study", f"its status says asked {status.asked}, when {asked} had been sent out")
