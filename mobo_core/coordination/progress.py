"""How far a study has come: what was asked, answered and told, its front and its best arm."""

from __future__ import annotations

import json
import math
from collections.abc import Callable

import numpy as np

from mobo_core.bag.record import StudyRecord
from mobo_core.bag.validity import values_of
from mobo_core.coordination.leases import Dispatch
from mobo_core.errors import InputError
from mobo_core.messages import Evaluation, Trial
from mobo_core.search.front import RunningFront
from mobo_core.search.study import OrderedStudy, Params, StudySettings, Told

# Trials of a resumed study between two lines on how far it has come, some two seconds.
_SAY_EVERY = 2000


class Progress:
    """The ordered study, the answers that wait for their turn in it, and what was told so far.

    Args:
        name: of the study.
        settings: what its trials depend on.

    Attributes:
        study: what was asked and told.
        front: of the arms told.
        failed: how many trials were told as failed.
        best: Evaluation and URDF of the highest reach.
    """

    def __init__(self, name: str, settings: StudySettings) -> None:
        self.study, self.front = OrderedStudy(settings), RunningFront(settings.aims)
        self.failed = 0
        self.best: tuple[Evaluation, str] | None = None
        self._name, self._objectives = name, settings.objectives
        self._extra = [name for name in settings.objectives if name not in ("reach", "torque")]
        self._answers: dict[int, Trial] = {}
        self._evaluations: dict[int, Evaluation] = {}  # the accepted ones, by trial

    @property
    def answered(self) -> int:
        """How many trials have an answer and wait to be told."""
        return len(self._answers)

    def answer(self, evaluation: Evaluation, failure: str) -> None:
        """Take a trial's answer, in the place of an earlier one; ``failure`` says why the trial failed, if it did."""
        self._answers[evaluation.trial] = Trial(
            study=self._name,
            trial=evaluation.trial,
            state=Trial.FAIL if failure else Trial.COMPLETE,
            attempt=evaluation.attempt,
            evaluator=evaluation.evaluator,
            reach=math.nan if failure else evaluation.reach,
            torque=math.nan if failure else evaluation.torque,
            extra_names=[] if failure else self._extra,
            extra_values=np.array([] if failure else values_of(evaluation, self._extra)),
            reason=failure[:2000],
        )
        if not failure:
            self._evaluations[evaluation.trial] = evaluation

    def due(self) -> Trial | None:
        """Return the record of the next trial to be told, if it is answered."""
        return self._answers.get(len(self.study.told))

    def tell(self, trial: Trial, urdf: str) -> None:
        """Tell the trial that is due; ``urdf`` describes its arm."""
        self._answers.pop(trial.trial, None)
        evaluation = self._evaluations.pop(trial.trial, None)
        self._count(trial)
        if trial.state != Trial.COMPLETE or evaluation is None:
            return
        if self.best is None or evaluation.reach > self.best[0].reach:
            self.best = (evaluation, urdf)

    def rebuild(self, past: StudyRecord, say: Callable[[str], None]) -> dict[int, set[Dispatch]]:
        """Ask and tell what a bag holds; return what was sent out of the trials that it does not tell, by trial.

        Raises:
            InputError: what no study can have been, or parameters that are none of the space's.
        """
        sent: dict[int, set[Dispatch]] = {}
        params: dict[int, str] = {}
        for candidate in past.candidates:
            trial = candidate.trial
            if trial not in past.trials:
                sent.setdefault(trial, set()).add(Dispatch(trial, candidate.attempt, candidate.evaluator))
            params.setdefault(trial, candidate.params_json)
        for number in range(len(params)):
            if number not in params:
                raise InputError(f"no candidate of trial {number}", expected="every trial")
            while not self.study.may_ask():
                self._retell(past)
            self.study.recall(_params(params[number], number))
            if number and number % _SAY_EVERY == 0:
                say(f"resuming {past.name}: {number} of {len(params)} trials")
        while len(self.study.told) in past.trials:
            self._retell(past)
        self.best = past.best
        return sent

    def _retell(self, past: StudyRecord) -> None:
        number = len(self.study.told)
        if number not in past.trials:
            raise InputError(f"trial {number} was never told", expected="trials in order")
        self._count(past.trials[number])

    def _count(self, trial: Trial) -> None:
        if trial.state == Trial.COMPLETE:
            values = values_of(trial, self._objectives)
            self.study.tell(Told(trial.trial, values))
            self.front.add(values)
        else:
            self.study.tell(Told(trial.trial, None))
            self.failed += 1


def _params(text: str, trial: int) -> Params:
    try:
        return dict(json.loads(text))
    except (ValueError, TypeError, RecursionError) as error:
        where = f"params_json of trial {trial}"
        raise InputError(f"not readable ({error!r:.80})", where=where, expected="parameters of the space") from None
