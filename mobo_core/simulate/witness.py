"""Watches a bag as it grows, and what takes effect: nothing may before it is there, and all must be as it should."""

from __future__ import annotations

import math
from collections.abc import Collection
from pathlib import Path

from mobo_core.bag.validity import evaluation_fault
from mobo_core.coordination.control import enqueued_params
from mobo_core.coordination.optimizer import Optimizer
from mobo_core.messages import UNABLE, Candidate, Command, Evaluation, Trial, decode
from mobo_core.search.study import Params, StudySettings
from mobo_core.simulate.oracle import Oracle, Values
from mobo_core.simulate.tail import OF_A_TRIAL, Raw, Tail, kept_before
from mobo_core.simulate.violation import Violation
from mobo_core.simulate.workers import MOST_FAILURES

# Of what the optimizer publishes, this is in the bag.
_RECORDED = ("candidates", "trials", "commands")

Key = tuple[int, int, str]  # trial, attempt, evaluator


class Witness:
    """Holds what a bag says, in its order, against the rules and against the undisturbed study.

    Args:
        folder: of the bag.
        settings: of the study.
        oracle: of the same.
        lies: answers (CDR bytes) that are false, and do not look it: a trial may be told from one.
        may_exhaust: whether a trial may fail because its attempts are used up.

    Attributes:
        folder: of the bag.
        told: trials that the bag tells.
        sent: what the bag says was sent out.
        lied: sendings that were answered with a lie.
        exhausted: trials told as failed because their attempts were used up.
    """

    def __init__(
        self,
        folder: Path,
        settings: StudySettings,
        oracle: Oracle,
        lies: Collection[bytes] = (),
        *,
        may_exhaust: bool = False,
    ) -> None:
        self.folder, self._settings, self._oracle = folder, settings, oracle
        self._lies, self._may_exhaust = lies, may_exhaust
        self._raw: Raw = []
        self._tail = Tail(folder, self._take)
        self._forget()

    def _forget(self) -> None:
        self.told = 0
        self.sent: set[Key] = set()
        self.lied: set[Key] = set()
        self.exhausted: set[int] = set()
        self._attempts: dict[int, int] = {}
        self._asked = 0
        self._answers: dict[int, Evaluation] = {}
        self._false: set[int] = set()  # whose answer is a lie
        self._failed: dict[int, list[Key]] = {}  # without what was no fault of the arm's
        self._enqueued: dict[int, Params] = {}
        self._otherwise: dict[int, Values] = {}  # told, other than in the undisturbed study
        self._paused = False
        self._raw = []

    def published(self, topic: str, data: bytes) -> None:
        """See that what is published on a topic now was recorded before."""
        if topic not in _RECORDED:
            return
        self._tail.follow()
        if not any(known == topic and message == data for known, message in reversed(self._raw[-4:])):
            raise Violation("recorded before effect", f"a message on {topic} is published, but not in the bag")

    def look(self, optimizer: Optimizer) -> None:
        """See that an optimizer has told no more than its bag says."""
        self._tail.follow()
        if len(optimizer.study.told) != self.told:
            text = f"{len(optimizer.study.told)} trials are told, {self.told} are in the bag"
            raise Violation("recorded before effect", text)

    def reopened(self, *, lost_tail: bool = False) -> None:
        """Read the bag anew: an optimizer goes on with it, or it lost its end. Else what was in it must be there."""
        before = self._raw
        if lost_tail:
            self._oracle = self._oracle.anew()
        self._forget()
        self._tail.again()
        if not lost_tail and self._raw[: len(before)] != before:
            raise Violation("nothing is lost", f"the bag held {len(before)} messages, and now {len(self._raw)} others")

    def was_cut(self, before: int) -> None:
        """Read a bag anew that was cut before a trial: what came before that is there, and nothing else."""
        kept = kept_before(self._raw, before)
        self.reopened(lost_tail=True)
        if (found := [entry for entry in self._raw if entry[0] in ("commands", *OF_A_TRIAL)]) != kept:
            text = f"the bag was cut before trial {before}: {len(found)} messages are in it, not those {len(kept)}"
            raise Violation("nothing is lost", text)

    def _take(self, topic: str, data: bytes) -> None:
        self._raw.append((topic, data))
        if topic == "candidates":
            self._take_candidate(decode(Candidate, data))
        elif topic == "evaluations":
            self._take_evaluation(decode(Evaluation, data), is_lie=data in self._lies)
        elif topic == "trials":
            self._take_trial(decode(Trial, data))
        elif topic == "commands":
            self._take_command(decode(Command, data))

    def _take_candidate(self, candidate: Candidate) -> None:
        number = candidate.trial
        if self._paused:
            raise Violation("order", f"trial {number} is sent out during a pause")
        if number < self.told:
            raise Violation("order", f"trial {number} is sent out after it was told")
        if number > self._asked or number >= self.told + self._settings.in_flight:
            raise Violation("order", f"trial {number} is sent out, {self._asked} are asked and {self.told} told")
        if candidate.attempt != self._attempts.get(number, 0) + 1:
            raise Violation("order", f"trial {number}: attempt {candidate.attempt} follows another than the one before")
        self._attempts[number] = candidate.attempt
        self._asked = max(self._asked, number + 1)
        self.sent.add((number, candidate.attempt, candidate.evaluator))
        expected = self._oracle.expects(number, self._enqueued, self._otherwise)
        if candidate.params_json != expected.params_json:
            raise Violation("same study", f"trial {number} is another arm than in the undisturbed study")
        if candidate.urdf != expected.urdf:
            raise Violation("same study", f"trial {number} has another URDF than in the undisturbed study")

    def _take_evaluation(self, evaluation: Evaluation, *, is_lie: bool) -> None:
        number, key = evaluation.trial, (evaluation.trial, evaluation.attempt, evaluation.evaluator)
        if key not in self.sent:
            return
        if is_lie:
            self.lied.add(key)
        ok = evaluation.status == Evaluation.OK and not evaluation_fault(
            evaluation, self._settings.spec.n_voxels, self._settings.objectives
        )
        if ok or evaluation.status == Evaluation.REJECTED:
            if number not in self._answers:
                self._answers[number] = evaluation
                self._false |= {number} if is_lie else set()
        elif evaluation.status != Evaluation.FAILED or not evaluation.reason.startswith(UNABLE):
            failed = self._failed.setdefault(number, [])
            failed += [key] if key not in failed else []

    def _take_trial(self, trial: Trial) -> None:
        number = trial.trial
        if number != self.told:
            rule = "told once" if number < self.told else "order"
            raise Violation(rule, f"trial {number} is told when it is the turn of trial {self.told}")
        self.told += 1
        complete = trial.state == Trial.COMPLETE
        said: Values = (trial.reach, trial.torque) if complete else None
        if not complete and not (trial.state == Trial.FAIL and math.isnan(trial.reach) and math.isnan(trial.torque)):
            raise Violation("same study", f"trial {number} is told with state {trial.state} and values")
        expected = self._oracle.expects(number, self._enqueued, self._otherwise).values
        if self._comes_from(trial) and said != expected:
            self._otherwise[number] = said
        elif said != expected:
            raise Violation("same study", f"trial {number} is told {said} {trial.reason}, not {expected}")

    def _comes_from(self, trial: Trial) -> bool:
        """See that a trial is told from the answer that counts; return whether that need not be the true one."""
        number, key = trial.trial, (trial.trial, trial.attempt, trial.evaluator)
        answer = self._answers.get(number)
        if answer is None:
            failed = self._failed.get(number, [])
            if not self._may_exhaust or len(failed) <= MOST_FAILURES or failed[MOST_FAILURES] != key:
                why = f"{trial.reason!r:.60}; {len(failed)} attempts failed"
                raise Violation("told from its answer", f"trial {number} is told ({why}) without an answer")
            self.exhausted.add(number)
            return True
        if (number, answer.attempt, answer.evaluator) != key:
            raise Violation("told from its answer", f"trial {number} is told from another than its first valid answer")
        if number not in self._false:
            return False
        good = answer.status == Evaluation.OK
        if good != (trial.state == Trial.COMPLETE) or (good and (trial.reach, trial.torque) != _values(answer)):
            raise Violation("told from its answer", f"trial {number} is told otherwise than it was answered")
        return True

    def _take_command(self, command: Command) -> None:
        if command.command in ("pause", "resume"):
            self._paused = command.command == "pause"
        elif command.command == "enqueue":
            self._enqueued[command.trial] = enqueued_params(command)


def _values(evaluation: Evaluation) -> tuple[float, float]:
    return evaluation.reach, evaluation.torque
