"""A trial that used up its attempts takes a good answer until it is told, and resume judges as its bag tells."""

from __future__ import annotations

from pathlib import Path

import pytest
from nodes import values
from studies import QUICK, mobo, run_study

from mobo_core.bag.collector import read_study
from mobo_core.bag.study_bag import StudyBag
from mobo_core.coordination.answer import Answering
from mobo_core.coordination.dispatch import Dispatcher
from mobo_core.coordination.optimizer import Optimizer
from mobo_core.messages import Candidate, Evaluation, EvaluatorStatus, Trial, decode, encode
from mobo_core.search.study import StudySettings
from mobo_core.verify.history import History

N, TIMEOUT_S = 12, 600.0
SETTINGS = {**QUICK, "in_flight": 3}


class Story:
    """A study told step by step: one failed attempt exhausts a trial; it can be killed and resumed at any point."""

    def __init__(self, bag: Path) -> None:
        self.bag, self.now = bag, 0.0
        self.sent: list[Candidate] = []
        self.told: list[Trial] = []
        self.start(resume=False)

    def start(self, *, resume: bool) -> None:
        settings = StudySettings.of(SETTINGS)
        self.store = StudyBag(self.bag, "study", settings, resume=resume)
        dispatcher = Dispatcher(max_attempts=1, evaluation_timeout_s=TIMEOUT_S)
        self.optimizer = Optimizer(
            self.store, settings, N, dispatcher, self.publish, log=lambda line: None, warn=lambda line: None
        )

    def publish(self, topic: str, data: bytes) -> None:
        if topic == "candidates":
            self.sent.append(decode(Candidate, data))
        elif topic == "trials":
            self.told.append(decode(Trial, data))

    def kill(self) -> None:
        self.store._lock.release()  # type: ignore[union-attr]  # as the kernel does
        self.start(resume=True)

    def beat(self, name: str, *holds: Candidate) -> None:
        status = EvaluatorStatus(
            evaluator=name, workers=3, studies=["study"] * len(holds),
            trials=[c.trial for c in holds], attempts=[c.attempt for c in holds],
        )  # fmt: skip
        self.optimizer.on_evaluator(encode(status), self.now)

    def answer(self, candidate: Candidate, status: int = Evaluation.OK) -> None:
        answering = Answering(candidate.evaluator, "simulated", simulated_s=0.0)
        good = status == Evaluation.OK
        answer = answering.answer(candidate) if good else answering.refusal(candidate, status, "it broke")
        self.optimizer.on_evaluation(encode(answer), self.now)

    def finish(self) -> None:
        self.sent.clear()
        for _ in range(10 * N):
            self.now += 0.5
            self.beat("good")
            while self.sent:
                self.answer(self.sent.pop(0))
        assert self.optimizer.done
        self.store.close()
        history = History(read_study(self.bag))
        history.replay()
        assert history.faults == []


def exhausted(story: Story, how: str) -> tuple[Candidate, Candidate]:
    """Have trial 1 use up its attempt while trial 0 is out; return what was first sent of the two."""
    story.beat("slow")
    zero, one, _ = story.sent
    if how == "failed":
        story.answer(one, Evaluation.FAILED)
    else:
        story.now += TIMEOUT_S + 1
        story.beat("slow", one)  # it never got the others
    assert story.told == []
    return zero, one


@pytest.fixture(scope="module")
def quiet(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The study that nothing disturbs."""
    return run_study(tmp_path_factory.mktemp("quiet") / "bag", N, settings=SETTINGS)


@pytest.mark.parametrize("kills", ["", "before", "after", "before, after"])
@pytest.mark.parametrize("how", ["failed", "timed out"])
def test_a_good_answer_replaces_the_failure(tmp_path: Path, quiet: Path, how: str, kills: str) -> None:
    """It comes before the trial's turn: told as complete, the quiet study to the bit, and the bag verifies."""
    story = Story(tmp_path / "bag")
    zero, one = exhausted(story, how)
    if "before" in kills:
        story.kill()
    story.answer(one)
    if "after" in kills:
        story.kill()
    assert story.told == []
    story.answer(one)  # said twice, used once
    story.answer(zero)
    assert [(t.trial, t.state, t.attempt, t.evaluator) for t in story.told] == [(0, 0, 1, "slow"), (1, 0, 1, "slow")]
    assert not any(candidate.trial == 1 and candidate.attempt > 1 for candidate in story.sent)
    story.finish()
    assert values(story.bag) == values(quiet)
    assert mobo("verify", "--sample", 0, story.bag) == 0


@pytest.mark.parametrize("killed", [False, True])
@pytest.mark.parametrize("how", ["failed", "timed out"])
def test_a_good_answer_after_the_telling_changes_nothing(tmp_path: Path, how: str, killed: bool) -> None:
    """The failure is told with its reason, the same after a kill between it and the telling."""
    story = Story(tmp_path / "bag")
    zero, one = exhausted(story, how)
    if killed:
        story.kill()
    story.answer(zero)
    assert [(t.trial, t.state) for t in story.told] == [(0, Trial.COMPLETE), (1, Trial.FAIL)]
    assert story.told[1].reason == ("it broke" if how == "failed" else f"timed out after {TIMEOUT_S:g} s")
    story.answer(one)
    assert not any(candidate.trial == 1 and candidate.attempt > 1 for candidate in story.sent)
    story.finish()
    assert read_study(story.bag).trials[1].state == Trial.FAIL
    assert mobo("verify", "--sample", 0, story.bag) == 0


@pytest.mark.parametrize("first", [Evaluation.OK, Evaluation.REJECTED])
def test_of_two_valid_answers_the_first_counts(tmp_path: Path, first: int) -> None:
    """Also if one says that the arm is bad; either way the bag verifies."""
    story = Story(tmp_path / "bag")
    zero, one = exhausted(story, "failed")
    story.answer(one, first)
    story.answer(one, Evaluation.REJECTED if first == Evaluation.OK else Evaluation.OK)
    story.answer(zero)
    assert story.told[1].state == (Trial.COMPLETE if first == Evaluation.OK else Trial.FAIL)
    story.finish()
    assert mobo("verify", "--sample", 0, story.bag) == 0
