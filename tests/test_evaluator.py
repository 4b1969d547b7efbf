"""An evaluator without its node: what it takes, what it says, and when."""

from __future__ import annotations

from typing import cast

import pytest

from mobo_core.coordination.answer import Abilities, Answering
from mobo_core.coordination.evaluator import Evaluator
from mobo_core.coordination.pool import WorkerPool
from mobo_core.errors import StudyError
from mobo_core.messages import Candidate, Evaluation, EvaluatorStatus, Trial, decode, encode


class Pool:
    """Workers that do nothing."""

    restarts = 0
    answering, abilities = Answering("e"), Abilities("hash")

    def __init__(self) -> None:
        self.ready = 0
        self.candidates: list[Candidate] = []
        self.answers: list[bytes] = []
        self.broken = False

    def __len__(self) -> int:
        return 2

    @property
    def waiting(self) -> int:
        return len(self.candidates)

    def held(self) -> list[Candidate]:
        return self.candidates

    def submit(self, candidate: Candidate) -> None:
        self.candidates.append(candidate)

    def drop(self, keep: object) -> None:
        assert callable(keep)
        self.candidates = [candidate for candidate in self.candidates if keep(candidate)]

    def collect(self) -> list[bytes]:
        if self.broken:
            raise RuntimeError("workers do not start")
        answers, self.answers = self.answers, []
        return answers


class Scene:
    def __init__(self) -> None:
        self.pool, self.said, self.warned = Pool(), list[tuple[str, bytes]](), list[str]()
        self.evaluator = Evaluator(
            cast(WorkerPool, self.pool), publish=lambda topic, data: self.said.append((topic, data)),
            log=lambda _: None, warn=self.warned.append,
        )  # fmt: skip

    def ready(self) -> Scene:
        self.pool.ready = 1
        self.evaluator.collect()
        return self

    def statuses(self) -> list[EvaluatorStatus]:
        return [decode(EvaluatorStatus, data) for topic, data in self.said if topic == "evaluators"]


def candidate(trial: int, evaluator: str = "e") -> bytes:
    return encode(Candidate(study="s", trial=trial, attempt=1, evaluator=evaluator))


def test_says_nothing_before_a_worker_is_ready() -> None:
    """Then it is there, beat by beat, and takes leave at the end."""
    scene = Scene()
    scene.evaluator.beat()
    scene.evaluator.leave()
    assert not scene.said
    scene.ready().evaluator.beat()
    scene.evaluator.leave()
    alive = EvaluatorStatus.ALIVE
    assert [status.state for status in scene.statuses()] == [alive, alive, EvaluatorStatus.LEFT]
    assert {(status.evaluator, status.workers, status.engine) for status in scene.statuses()} == {("e", 2, "kernel")}


def test_takes_candidates_that_name_it_once_it_is_there() -> None:
    """Others, and what was meant for an earlier node of its name, it leaves; its heartbeat names what it holds."""
    scene = Scene()
    scene.evaluator.on_candidate(candidate(1))
    scene.ready()
    scene.evaluator.on_candidate(candidate(2))
    scene.evaluator.on_candidate(candidate(3, evaluator="f"))
    scene.evaluator.beat()
    assert [held.trial for held in scene.pool.candidates] == [2]
    assert [list(status.trials) for status in scene.statuses()] == [[], [2]]


def test_drops_a_candidate_whose_trial_is_told() -> None:
    """One that still waits for a worker; those of other trials and studies stay."""
    scene = Scene().ready()
    for trial in (1, 2):
        scene.evaluator.on_candidate(candidate(trial))
    scene.evaluator.on_trial(encode(Trial(study="other", trial=1)))
    scene.evaluator.on_trial(encode(Trial(study="s", trial=2)))
    scene.evaluator.on_trial(b"rubbish")
    assert [held.trial for held in scene.pool.candidates] == [1]


def test_rubbish_is_told_and_ignored() -> None:
    """A candidate that cannot be read takes no worker's place."""
    scene = Scene().ready()
    scene.evaluator.on_candidate(candidate(1)[:-40])
    scene.evaluator.on_candidate(b"\x00")
    assert scene.warned and not scene.pool.candidates


def test_answers_go_out_and_are_counted() -> None:
    """As the bytes that a worker made."""
    scene = Scene().ready()
    scene.pool.answers = [b"one", b"two"]
    scene.evaluator.collect()
    assert [data for topic, data in scene.said if topic == "evaluations"] == [b"one", b"two"]
    assert scene.evaluator.health().figures["answered"] == "2"


def test_workers_that_do_not_start_end_it() -> None:
    """With an error that is one line for people."""
    scene = Scene()
    scene.pool.broken = True
    with pytest.raises(StudyError, match="workers do not start"):
        scene.evaluator.collect()


def test_candidates_beyond_all_measure_are_not_held() -> None:
    """Too many, or of a study with a name that no heartbeat could carry: told and ignored; too large: rejected."""
    scene = Scene().ready()
    scene.evaluator.on_candidate(encode(Candidate(study="x" * 300, trial=1, evaluator="e")))
    scene.evaluator.on_candidate(encode(Candidate(study="s", trial=1, evaluator="e", urdf="x" * 3_000_000)))
    (answer,) = [decode(Evaluation, data) for topic, data in scene.said if topic == "evaluations"]
    assert not scene.pool.candidates and len(scene.warned) == 1
    assert answer.status == Evaluation.REJECTED and "bytes" in answer.reason
    for trial in range(200):
        scene.evaluator.on_candidate(candidate(trial))
    assert len(scene.pool.candidates) == len(scene.pool) + 64 and "held already" in scene.warned[-1]
