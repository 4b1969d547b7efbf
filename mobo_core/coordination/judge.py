"""Which answers to a study's trials are recorded, and which of them its trials are told from."""

from __future__ import annotations

from collections.abc import Callable

from mobo_core.bag.study_bag import StudyBag
from mobo_core.bag.validity import check_plain
from mobo_core.coordination.answers import claim_of, failure_reason
from mobo_core.coordination.dispatch import Dispatcher
from mobo_core.coordination.leases import Dispatch, Verdict
from mobo_core.coordination.progress import Progress
from mobo_core.errors import InputError
from mobo_core.messages import UNABLE, Evaluation, decode
from mobo_core.search.study import StudySettings

# Answers to a trial that change nothing are recorded too, but a flood of them shall not fill the disk.
_MAX_UNUSED_RECORDED = 16
# Of an answer: a voxel's entries in all maps, and far more than all the rest.
_VOXEL_BYTES, _ANSWER_BYTES = 26, 100_000


class Judge:
    """Takes the answers that come in: records them, has the dispatcher judge them, and keeps those that count.

    Args:
        bag: of the study.
        settings: of the study.
        dispatcher: knows what was sent out.
        progress: keeps a trial's answer until it is told.
        warn: takes lines on what went wrong.

    Attributes:
        answers: how many came in.
        unused: how many of them changed nothing.
    """

    def __init__(
        self,
        bag: StudyBag,
        settings: StudySettings,
        dispatcher: Dispatcher,
        progress: Progress,
        warn: Callable[[str], None],
    ) -> None:
        self._bag, self._settings = bag, settings
        self._dispatcher, self._progress, self._warn = dispatcher, progress, warn
        self._max_bytes = _ANSWER_BYTES + _VOXEL_BYTES * settings.spec.n_voxels
        self._unused_of: dict[int, int] = {}
        self.answers = self.unused = 0

    def take(self, data: bytes, now: float) -> bool:
        """Take an answer (CDR bytes of an Evaluation); return whether it is in the bag."""
        self.answers += 1
        try:
            if len(data) > self._max_bytes:
                raise InputError(f"{len(data):,} bytes", where="answer", expected=f"at most {self._max_bytes:,}")
            evaluation = decode(Evaluation, data)
            check_plain(evaluation, "answer")  # else nobody could read the bag
        except InputError as error:
            self.unused += 1
            self._warn(f"answer ignored: {error}")
            return False
        trial = evaluation.trial
        if evaluation.study != self._bag.name or trial >= len(self._progress.study.asked):
            self.unused += 1
            self._warn(f"answer ignored: trial {trial} of study {evaluation.study[:40]!r} was never sent out")
            return False
        dispatch, ok, _ = claim_of(evaluation, self._settings)
        if self._unused_of.get(trial, 0) >= _MAX_UNUSED_RECORDED and not self._dispatcher.matters(dispatch, ok=ok):
            self.unused += 1
            return False
        self._bag.append_raw("evaluations", "Evaluation", data)
        if not self.judge(evaluation, now):
            self.unused += 1
            self._unused_of[trial] = self._unused_of.get(trial, 0) + 1
        return True

    def judge(self, evaluation: Evaluation, now: float, *, overdue: bool = False) -> bool:
        """Let the dispatcher judge an answer that is in the bag; return whether it changed anything."""
        dispatch, ok, _ = claim_of(evaluation, self._settings)
        unable = evaluation.status == Evaluation.FAILED and evaluation.reason.startswith(UNABLE)
        verdict = self._dispatcher.answered(dispatch, now, ok=ok, unable=unable, overdue=overdue)
        good = ok and evaluation.status == Evaluation.OK
        reason = "" if good else failure_reason(evaluation, self._settings)
        if verdict in (Verdict.ACCEPTED, Verdict.EXHAUSTED):
            self._progress.answer(evaluation, reason)
        elif verdict is Verdict.RETRY:
            self._warn(f"trial {dispatch.trial}, attempt {dispatch.attempt} on {dispatch.evaluator}: {reason}")
        return verdict in (Verdict.ACCEPTED, Verdict.EXHAUSTED)

    def time_out(self, dispatch: Dispatch, now: float) -> None:
        """Record that an evaluator took too long as the FAILED answer it comes to, so that resume judges it too."""
        if not self._dispatcher.matters(dispatch, ok=False):
            return  # another attempt that timed out was the trial's last
        evaluation = Evaluation(
            study=self._bag.name,
            trial=dispatch.trial,
            attempt=dispatch.attempt,
            evaluator=dispatch.evaluator,
            status=Evaluation.FAILED,
            reason=f"timed out after {self._dispatcher.evaluation_timeout_s:g} s",
        )
        self._bag.append("evaluations", evaluation)
        self.judge(evaluation, now, overdue=True)
