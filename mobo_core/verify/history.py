"""Whether what a bag holds can have happened in the order it holds it: the rule of acceptance, message by message."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from mobo_core.bag.record import StudyRecord
from mobo_core.bag.validity import evaluation_fault, values_of
from mobo_core.coordination.answers import failure_reason
from mobo_core.messages import (
    TOPICS,
    UNABLE,
    Candidate,
    Command,
    Evaluation,
    EvaluatorStatus,
    Header,
    Message,
    StudyStatus,
    Trial,
)
from mobo_core.verify.around import Around
from mobo_core.verify.fault import Fault

Key = tuple[int, str]  # attempt, evaluator


@dataclass
class _Open:
    """A trial sent out and not told, as the dispatcher sees it."""

    sent: set[Key] = field(default_factory=set)
    failed: set[Key] = field(default_factory=set)
    judged: list[Evaluation] = field(default_factory=list)  # answers to what had been sent, in order
    answer: Evaluation | None = None
    is_final: bool = False  # no later answer counts
    exhausted: bool = False


class History:
    """Takes the messages of a bag in their order.

    Attributes:
        faults: what cannot have happened.
        told: the number of the next trial to be told.
        answers: trial -> the valid answers to its sendings, in order.
        failures: trial -> the answer it was told as failed from.
        unsaid: trials told as failed in sessions whose record does not say max_attempts.
    """

    def __init__(self, study: StudyRecord) -> None:
        self.study, self.settings = study, study.settings
        self.faults: list[Fault] = []
        self.told = 0
        self._around = Around(study.settings, self._blame)
        self.answers: dict[int, list[Evaluation]] = {}
        self.failures: dict[int, Evaluation] = {}
        self.unsaid: set[int] = set()
        self._open: dict[int, _Open] = {}
        self._closed: dict[int, set[Key]] = {}  # what was sent of the trials told
        self._asked = 0
        self._told: set[int] = set()
        self._max_attempts: int | None = None

    def replay(self) -> None:
        """Take all messages."""
        begun: dict[str, str] = {}
        for record, entry, message in self.study.messages:
            if record is not begun and record != begun:
                self._begin(record)
            begun = record
            if message is None or entry.topic.rsplit("/", 1)[-1] != _TOPIC_OF.get(entry.kind):
                self._blame(-1, "topic", f"{entry.topic[:80]!r} carries {entry.kind[:80]!r}")
            if message is not None:
                self._take(message)
        missing = 0
        while missing in self._told:
            missing += 1
        if missing < max(self._told, default=0):
            self._blame(missing, "trial", "was never told, though later ones were")

    def _begin(self, record: dict[str, str]) -> None:
        """A session begins: its optimizer judges again what the bag holds of the trials not told."""
        said = record.get("max_attempts", "")
        self._max_attempts = int(said) if said.isdecimal() and len(said) < 10 else None
        for trial in self._open.values():
            again, trial.judged = trial.judged, []
            trial.failed.clear()
            trial.answer, trial.is_final, trial.exhausted = None, False, False
            for evaluation in again:
                self._judge(trial, evaluation)

    def _take(self, message: Message) -> None:
        name = getattr(message, "study", self.study.name)
        trial, header = getattr(message, "trial", -1), getattr(message, "header", _HEADER)
        if header.frame_id != _HEADER.frame_id:
            self._blame(trial, "frame_id", f"{header.frame_id[:80]!r} ({message.kind})")
        if name != self.study.name:
            self._blame(trial, "study", f"{name[:80]!r} in a bag of {self.study.name!r} ({message.kind})")
        match message:
            case Candidate():
                self._sent(message)
            case Evaluation():
                self._answered(message)
            case Trial():
                self._tell(message)
            case Command():
                sent_before = message.trial in self._open or message.trial in self._told
                self._around.command(message, self._asked, self.told, sent_before=sent_before)
            case EvaluatorStatus():
                self._around.evaluator(message)
            case StudyStatus():
                self._around.status(message, self._asked, self.told)
            case _:
                pass

    def _sent(self, candidate: Candidate) -> None:
        number, key = candidate.trial, (candidate.attempt, candidate.evaluator)
        if number in self._told:
            return self._blame(number, "candidate", "sent out after its trial was told")
        is_new = number not in self._open
        if is_new:
            if number != self._asked:
                self._blame(number, "candidate", f"sent out when it was the turn of trial {self._asked}")
            elif number > self.told - 1 + self.settings.in_flight:
                waits = number - self.settings.in_flight
                self._blame(number, "candidate", f"sent out before trial {waits} was told")
            self._open[number] = _Open()
            self._asked = max(self._asked, number + 1)
        trial = self._open[number]
        if self._around.paused:
            self._blame(number, "candidate", "sent out during a pause")
        if trial.is_final or trial.exhausted:
            self._blame(number, "candidate", "sent out after its answer had come")
        if candidate.attempt != len(trial.sent) + 1:
            self._blame(number, "attempt", f"{candidate.attempt} is sending number {len(trial.sent) + 1}")
        trial.sent.add(key)
        self._around.sent(candidate, is_new=is_new)

    def _answered(self, evaluation: Evaluation) -> None:
        number, key = evaluation.trial, (evaluation.attempt, evaluation.evaluator)
        if number >= self.told + self.settings.in_flight:
            return self._blame(number, "evaluation", f"of {evaluation.evaluator!r}, to a trial that was never sent out")
        trial = self._open.get(number)
        was_sent = key in (trial.sent if trial is not None else self._closed.get(number, ()))
        if was_sent and evaluation.status == Evaluation.OK:
            if evaluation.reason:
                self._blame(number, "reason", f"{evaluation.reason[:80]!r} of an answer with values")
            if not 0 <= evaluation.seconds < math.inf:
                self._blame(number, "seconds", f"{evaluation.seconds!r} s for an evaluation")
        if was_sent and self._is_valid(evaluation):
            self.answers.setdefault(number, []).append(evaluation)
        if was_sent and trial is not None:
            self._judge(trial, evaluation)

    def _is_valid(self, evaluation: Evaluation) -> bool:
        if evaluation.status == Evaluation.OK:
            return not evaluation_fault(evaluation, self.settings.spec.n_voxels, self.settings.objectives)
        return evaluation.status == Evaluation.REJECTED

    def _judge(self, trial: _Open, evaluation: Evaluation) -> None:
        """The dispatcher's rule: the first valid answer counts, else the last failure that a trial may have."""
        trial.judged.append(evaluation)
        key = (evaluation.attempt, evaluation.evaluator)
        if trial.is_final:
            return
        if self._is_valid(evaluation):
            trial.answer, trial.is_final = evaluation, True
        elif not trial.exhausted and key not in trial.failed:
            unable = evaluation.status == Evaluation.FAILED and evaluation.reason.startswith(UNABLE)
            if unable:
                return
            trial.failed.add(key)
            if self._max_attempts is not None and len(trial.failed) >= self._max_attempts:
                trial.answer, trial.exhausted = evaluation, True

    def _tell(self, told: Trial) -> None:
        number = told.trial
        if number in self._told:
            return self._blame(number, "trial", "told more than once")
        self._told.add(number)
        if number != self.told:
            self._blame(number, "trial", f"told when it was the turn of trial {self.told}")
        self.told = max(self.told, number + 1)
        trial = self._open.pop(number, None)
        self._around.count(told)
        if trial is None:
            return self._blame(number, "trial", "told though it was never sent out")
        self._closed[number] = trial.sent
        if told.state == Trial.COMPLETE:
            self._check_values(told, trial)
        elif told.state == Trial.FAIL:
            self._check_failure(told, trial)
        else:
            self._blame(number, "state", f"{told.state}, which is none")

    def _check_values(self, told: Trial, trial: _Open) -> None:
        number, answer = told.trial, trial.answer
        if (told.attempt, told.evaluator) not in trial.sent:
            self._blame(number, "attempt", f"attempt {told.attempt} on {told.evaluator} was never sent out")
        if answer is None or not trial.is_final or answer.status != Evaluation.OK:
            return self._blame(number, "evaluation", "no good answer of the attempt it names had come")
        if (answer.attempt, answer.evaluator) != (told.attempt, told.evaluator):
            first = f"attempt {answer.attempt} on {answer.evaluator}"
            return self._blame(number, "evaluation", f"told from another answer than the first good one, of {first}")
        extra = [name for name in self.settings.objectives if name not in ("reach", "torque")]
        if list(told.extra_names) != extra or len(told.extra_values) != len(extra):
            self._blame(number, "extra_names", f"{list(told.extra_names)!r:.80}, but the study's are {extra}")
        fields = tuple(dict.fromkeys(("reach", "torque", *self.settings.objectives)))
        for name, value, answered in zip(fields, values_of(told, fields), values_of(answer, fields), strict=True):
            if value != answered:
                self._blame(number, name, f"told {value!r}, but the evaluation says {answered!r}")
        if told.reason:
            self._blame(number, "reason", f"{told.reason[:80]!r} of a trial that is complete")

    def _check_failure(self, told: Trial, trial: _Open) -> None:
        number, answer, key = told.trial, trial.answer, (told.attempt, told.evaluator)
        if answer is not None and answer.status == Evaluation.OK and trial.is_final:
            return self._blame(number, "state", "told as failed, though a good answer had come")
        if answer is None and self._max_attempts is None:
            # An older tree's record does not say how many failures it took.
            failed = [e for e in trial.judged if (e.attempt, e.evaluator) == key and key in trial.failed]
            answer = failed[0] if failed else None
            self.unsaid.add(number)
        if answer is None:
            few = f"{len(trial.failed)} of {self._max_attempts or 'its'} attempts had failed"
            return self._blame(number, "state", f"told as failed, though {few}")
        self.failures[number] = answer
        if (answer.attempt, answer.evaluator) != key:
            self._blame(number, "evaluation", "told from another answer than the one that counted")
        if not (math.isnan(told.reach) and math.isnan(told.torque)) or len(told.extra_values) or told.extra_names:
            self._blame(number, "reach", "a failed trial with values")
        if number not in self.unsaid and told.reason != (reason := failure_reason(answer, self.settings)):
            self._blame(number, "reason", f"told {told.reason[:80]!r}, but it failed of {reason[:80]!r}")

    def _blame(self, trial: int, what: str, text: str) -> None:
        self.faults.append(Fault(trial, what, text))


_HEADER = Header()
_TOPIC_OF = {cls.kind: topic for topic, cls in TOPICS.items()}
