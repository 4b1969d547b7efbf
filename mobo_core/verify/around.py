"""What goes on around the trials of a study: commands, evaluators that come and go, statuses."""

from __future__ import annotations

import math
from collections.abc import Callable

from mobo_core.bag.validity import values_of
from mobo_core.coordination.answers import MAX_WORKERS
from mobo_core.coordination.control import COMMANDS, STOPPED_BY_COMMAND, STOPPED_BY_SIGNAL
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
        joined: evaluators that are there, and what they said of themselves.
    """

    def __init__(self, settings: StudySettings, blame: Callable[[int, str, str], None]) -> None:
        self.settings, self._blame = settings, blame
        self.paused = False
        self.joined: dict[str, EvaluatorStatus] = {}
        # Of this session, if its beginning is known.
        self._resent: int | None = None
        self._n_trials: int | None = None
        self._stop_commanded = False
        self._front = RunningFront(settings.aims)
        self._best_reach, self._n_told, self._n_failed = 0.0, 0, 0
        self._enqueued: set[int] = set()

    def sent(self, candidate: Candidate, *, is_new: bool) -> None:
        """Take a candidate; ``is_new``: the first of its trial."""
        number, who = candidate.trial, self.joined.get(candidate.evaluator)
        if who is None:
            self._blame(number, "evaluator", f"{candidate.evaluator!r} was sent it without having joined")
        elif candidate.engine and who.engine != candidate.engine:
            text = f"{candidate.evaluator!r}, whose engine is {who.engine[:40]!r}, was sent it for {candidate.engine!r}"
            self._blame(number, "engine", text)
        if self._resent is not None:
            self._resent += candidate.attempt > 1
        if is_new and self._n_trials is not None and number >= self._n_trials:
            self._blame(number, "candidate", f"sent out in a study of {self._n_trials} trials")

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
        if not asked <= number <= self._most_asked(asked, told):
            self._blame(number, "command", f"{name} at trial {number}, when {asked} were sent out")
        self._stop_commanded |= name == "stop"
        if name in ("pause", "resume"):
            if self.paused == (name == "pause"):
                self._blame(number, "command", f"{name}, though it was {'' if self.paused else 'not '}paused")
            self.paused = name == "pause"

    def evaluator(self, status: EvaluatorStatus) -> None:
        """Take who joined, left or was lost."""
        name, known = status.evaluator, status.evaluator in self.joined
        if status.state == EvaluatorStatus.JOINED:
            if known and self._resent is not None:
                self._blame(-1, "evaluators", f"{name[:80]!r} joined more than once")
            if not 0 < status.workers <= MAX_WORKERS:
                self._blame(-1, "evaluators", f"{name[:80]!r} joined with {status.workers} workers")
            self.joined[name] = status
        elif status.state not in (EvaluatorStatus.LEFT, EvaluatorStatus.LOST):
            self._blame(-1, "evaluators", f"{name[:80]!r} in state {status.state}, which is not recorded")
        elif not known:
            self._blame(-1, "evaluators", f"{name[:80]!r} left or was lost without having joined")
        if status.state != EvaluatorStatus.JOINED:
            self.joined.pop(name, None)
        if len(status.studies) or len(status.trials) or len(status.attempts):
            self._blame(-1, "evaluators", f"{name[:80]!r} with candidates it holds, which are not recorded")

    def status(self, status: StudyStatus, asked: int, told: int) -> None:
        """Take what the optimizer said of the study; errors in what the bag can derive are its faults."""
        if status.state == StudyStatus.RUNNING:
            self.joined.clear()
            self._resent, self._n_trials, self._stop_commanded = 0, int(status.n_trials), False
        self._check_state(status)
        derived: list[tuple[str, float, float]] = [
            ("told", status.told, self._n_told),
            ("failed", status.failed, self._n_failed),
            ("evaluators", status.evaluators, len(self.joined)),
            ("front_size", status.front_size, len(self._front)),
            ("best_reach", status.best_reach, self._best_reach),
            ("hypervolume", status.hypervolume, self._front.hypervolume),
        ]
        if self._resent is not None and self._n_trials is not None:
            derived += [("resent", status.resent, self._resent), ("n_trials", status.n_trials, self._n_trials)]
        for name, said, found in derived:
            if not abs(said - found) <= _ROUNDING * abs(found):
                self._blame(-1, "study", f"its status says {name} {said!r}, but the bag holds {found!r}")
        most = asked if status.state == StudyStatus.RUNNING else self._most_asked(asked, told)
        if not asked <= status.asked <= most:
            self._blame(-1, "study", f"its status says asked {status.asked}, when {asked} had been sent out")
        if status.answers_unused > status.answers or bool(status.workers) < bool(status.evaluators):
            self._blame(-1, "study", "its status says more answers unused than came, or evaluators without a worker")

    def _most_asked(self, asked: int, told: int) -> int:
        """Return how many trials can be asked when so many were sent out and told."""
        most = told + self.settings.in_flight
        return max(asked, most if self._n_trials is None else min(most, self._n_trials))

    def _check_state(self, status: StudyStatus) -> None:
        """See that a study's state is one it can have: a session begins RUNNING, and ends DONE or STOPPED."""
        state, all_told = status.state, status.told >= status.n_trials
        if state not in (StudyStatus.RUNNING, StudyStatus.DONE, StudyStatus.STOPPED):
            self._blame(-1, "study", f"state {state}, which is not recorded")
        elif all_told != (state == StudyStatus.DONE):
            word = {StudyStatus.RUNNING: "running", StudyStatus.DONE: "done", StudyStatus.STOPPED: "stopped"}[state]
            self._blame(-1, "study", f"{word} with {status.told} of {status.n_trials} trials")
        reasons = ("",)
        if state == StudyStatus.STOPPED:
            reasons = (STOPPED_BY_COMMAND,) if self._stop_commanded else (STOPPED_BY_SIGNAL,)
        if status.reason not in reasons:
            self._blame(-1, "study", f"its status says {status.reason[:80]!r}, but the bag {reasons[0]!r}")
