"""The optimizer without its ROS node: study, dispatch and bag together, messages in and out as bytes."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable

import numpy as np

from mobo_core.bag.record import StudyRecord
from mobo_core.bag.study_bag import StudyBag
from mobo_core.coordination.admission import Admission
from mobo_core.coordination.attendance import Attendance
from mobo_core.coordination.control import STOPPED_BY_COMMAND, STOPPED_BY_SIGNAL, Controls
from mobo_core.coordination.dispatch import Dispatcher
from mobo_core.coordination.judge import Judge
from mobo_core.coordination.leases import Dispatch
from mobo_core.coordination.progress import Progress
from mobo_core.design.description import TIP_LINK
from mobo_core.design.design import Design
from mobo_core.design.prepared import PreparedXacro
from mobo_core.errors import InputError, visibly
from mobo_core.evaluation.spec_message import spec_to_message
from mobo_core.messages import Candidate, Command, Evaluation, StudyStatus, Trial, encode
from mobo_core.search.study import Asked, OrderedStudy, StudySettings

Publish = Callable[[str, bytes], None]


class Optimizer:
    """Runs a study: call :meth:`on_evaluator` and :meth:`on_evaluation` with what comes in, :meth:`tick` often.

    Every message is in the bag, flushed, before it takes effect.

    Args:
        bag: the open bag; a study it holds already is continued.
        settings: what the trials depend on.
        n_trials: the total to reach.
        dispatcher: hands trials to evaluators.
        publish: sends bytes on a topic (relative name).
        log: takes lines for people.
        warn: takes lines on what went wrong; a flood of them may come.
        describe: makes the URDF of an arm; xacro, unless who calls keeps what it made before.
        first: arms that the first trials of a new study are, and where each is from; those that the space does not
            hold are left out.
    """

    def __init__(
        self,
        bag: StudyBag,
        settings: StudySettings,
        n_trials: int,
        dispatcher: Dispatcher,
        publish: Publish,
        log: Callable[[str], None] = print,
        warn: Callable[[str], None] = print,
        describe: Callable[[Design], str] | None = None,
        first: Iterable[tuple[str, Design]] = (),
    ) -> None:
        self.settings, self.n_trials = settings, n_trials
        self._progress = Progress(bag.name, settings)
        self.controls = Controls(bag.name, settings.space, self._record_command)
        self._bag, self._dispatcher, self._publish = bag, dispatcher, publish
        self._log, self._warn = visibly(log), visibly(warn)
        self._admission = Admission(bag.settings.engine, self._log, self._warn, settings.spec.ik_mode)
        self._attendance = Attendance(bag, self._admission, dispatcher, self._log, self._warn)
        self._judge = Judge(bag, settings, dispatcher, self._progress, self._warn)
        bag.note(max_attempts=dispatcher.max_attempts)
        self._spec_message = spec_to_message(settings.spec)
        self._describe = PreparedXacro(settings.space).to_urdf if describe is None else describe
        self._urdfs: dict[int, str] = {}
        self.resent = 0
        if (past := bag.past()) is not None:
            try:
                self._replay(past)
            except InputError as error:
                raise error.at(str(bag.folder)) from None
            bag.go_on(past)
        else:
            self._enqueue(first)

    def _enqueue(self, first: Iterable[tuple[str, Design]]) -> None:
        """Make arms the first trials, as commands do: the bag has them, and what is verified or resumed knows them."""
        taken = 0
        for name, design in first:
            taken += self.controls.enqueue(0, name, design.sampled_joints, design.lengths, self.n_trials).accepted
        if taken:
            self._log(f"the first {taken} trials are the arms of baselines")

    @property
    def study(self) -> OrderedStudy:
        """What was asked and told."""
        return self._progress.study

    @property
    def failed(self) -> int:
        """How many trials were told as failed."""
        return self._progress.failed

    @property
    def best(self) -> tuple[Evaluation, str] | None:
        """Evaluation and URDF of the highest reach so far."""
        return self._progress.best

    @property
    def done(self) -> bool:
        """Whether every trial is told."""
        return len(self.study.told) >= self.n_trials

    @property
    def state(self) -> int:
        """The StudyStatus state of a study that is not over."""
        return StudyStatus.PAUSED if self.controls.paused else StudyStatus.RUNNING

    def on_evaluator(self, data: bytes, now: float) -> None:
        """Take a heartbeat (CDR bytes of an EvaluatorStatus)."""
        if self._attendance.heard(data, now):
            self.tick(now)

    def on_evaluation(self, data: bytes, now: float) -> None:
        """Take an answer (CDR bytes of an Evaluation): recorded, judged, and if it is its trial's first, used."""
        if self._judge.take(data, now):
            self.tick(now)

    def tick(self, now: float) -> None:
        """Do all there is to do: tell, ask, send out."""
        lost, overdue = self._dispatcher.expire(now)
        for name in lost:
            self._attendance.lost(name)
        for dispatch in overdue:
            self._judge.time_out(dispatch, now)
        while True:
            while (trial := self._progress.due()) is not None:
                self._tell(trial)
            if len(self.study.asked) < self.n_trials and self.study.may_ask() and not self.controls.paused:
                params = self.controls.enqueued.pop(len(self.study.asked), None)
                self._open(self.study.ask() if params is None else self.study.recall(params))
            else:
                break
        if self.controls.paused:
            return
        for dispatch in self._dispatcher.next_dispatches(now):
            self._send(dispatch)

    def status(self, state: int, reason: str = "") -> StudyStatus:
        """Return the study's StudyStatus."""
        return StudyStatus(
            study=self._bag.name,
            state=state,
            reason=reason,
            n_trials=self.n_trials,
            asked=len(self.study.asked),
            told=len(self.study.told),
            failed=self.failed,
            evaluators=len(self._dispatcher.evaluators),
            workers=sum(self._dispatcher.evaluators.values()),
            front_size=len(self._progress.front),
            best_reach=self.best[0].reach if self.best is not None else 0.0,
            hypervolume=self._progress.front.hypervolume,
            answers=self._judge.answers,
            answers_unused=self._judge.unused,
            resent=self.resent,
            bag=str(self._bag.folder),
        )

    def record_status(self, state: int, reason: str = "") -> bytes:
        """Put the study's status into the bag; return it as CDR bytes."""
        return self._bag.append("study", self.status(state, reason))

    def end(self) -> bytes:
        """Record that the study is done or was stopped, if this changes its bag; return that status as CDR bytes."""
        if self.done:
            final = self.status(StudyStatus.DONE)
        else:
            why = STOPPED_BY_COMMAND if self.controls.stopped else STOPPED_BY_SIGNAL
            final = self.status(StudyStatus.STOPPED, why)
        if not self.done or self._bag.recording:
            self._bag.append("study", final)
        return encode(final)

    def _replay(self, past: StudyRecord) -> None:
        """Bring the study to where its bag left it."""
        sent = self._progress.rebuild(past, self._log)
        self._admission.engine = self._admission.engine or next((c.engine for c in past.candidates if c.engine), "")
        self.controls.repeat(past.commands, len(self.study.asked))
        for number in range(len(self.study.told), len(self.study.asked)):
            self._open(self.study.asked[number], sent.get(number))
        for evaluation in past.evaluations:
            if evaluation.trial >= len(self.study.told):
                self._judge.judge(evaluation, 0.0)  # no lease of that time is left to measure
        answered = self._progress.answered
        self._log(f"resuming {past.name}: {len(self.study.told)} trials told, {answered} answered")
        if self.controls.paused:
            self._log("paused, as it was when it ended; `ros2 run mobo control resume` goes on")

    def _open(self, asked: Asked, sent: set[Dispatch] | None = None) -> None:
        self._urdfs[asked.number] = self._describe(asked.design)
        self._dispatcher.open(asked.number, sent or ())

    def _send(self, dispatch: Dispatch) -> None:
        asked = self.study.asked[dispatch.trial]
        candidate = Candidate(
            study=self._bag.name,
            trial=dispatch.trial,
            attempt=dispatch.attempt,
            evaluator=dispatch.evaluator,
            sampled_joints=asked.design.sampled_joints,
            joints=asked.design.joints,
            lengths=np.array(asked.design.lengths),
            urdf=self._urdfs[dispatch.trial],
            tip=TIP_LINK,
            spec=self._spec_message,
            objectives=list(self.settings.objectives),
            engine=self._admission.engine,
            params_json=json.dumps(asked.params),
        )
        self.resent += dispatch.attempt > 1
        self._publish("candidates", self._bag.append("candidates", candidate))

    def _tell(self, trial: Trial) -> None:
        self._publish("trials", self._bag.append("trials", trial))
        self._dispatcher.close(trial.trial)
        self._progress.tell(trial, self._urdfs.pop(trial.trial))
        if trial.state != Trial.COMPLETE:
            self._warn(f"trial {trial.trial} failed: {trial.reason}")

    def _record_command(self, command: Command) -> None:
        self._publish("commands", self._bag.append("commands", command))
