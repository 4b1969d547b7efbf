"""Which evaluators get work: one engine, one kernel, and no flood of names."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from mobo_core.bag.collector import read_study
from mobo_core.bag.study_bag import StudyBag
from mobo_core.coordination.admission import Admission
from mobo_core.coordination.answer import Answering
from mobo_core.coordination.dispatch import Dispatcher
from mobo_core.coordination.optimizer import Optimizer
from mobo_core.evaluation.kernel_sources import kernel_hash
from mobo_core.messages import Candidate, Evaluation, EvaluatorStatus, decode, encode
from mobo_core.search.study import StudySettings


def heartbeat(name: str, engine: str = "kernel", **fields: Any) -> EvaluatorStatus:
    known = kernel_hash() if engine in ("kernel", "reference") else ""
    return EvaluatorStatus(**{"evaluator": name, "workers": 1, "engine": engine, "kernel_hash": known, **fields})


@pytest.mark.parametrize(
    ("status", "why"),
    [
        (heartbeat("left_over", "simulated"), "its engine is simulated, the study's kernel"),
        (heartbeat("odd", ""), "its engine is unknown, the study's kernel"),
        (heartbeat("old", kernel_hash="0123456789abcdef", mobo_version="9.9"), r"its kernel \(mobo 9.9\) is another"),
        (heartbeat("mute", kernel_hash=""), "its kernel .* is another than here"),
    ],
)
def test_another_engine_or_kernel_gets_no_work_and_is_named_once(
    tmp_path: Path, status: EvaluatorStatus, why: str
) -> None:
    """However often it is heard; the study's own evaluator gets all, and its candidates name the engine."""
    sent: list[Candidate] = []
    warned: list[str] = []
    settings = StudySettings.of({"sampler": "random", "engine": "kernel"})
    bag = StudyBag(tmp_path / "bag", "s", settings, resume=False)

    def publish(topic: str, data: bytes) -> None:
        sent.extend([decode(Candidate, data)] if topic == "candidates" else [])

    optimizer = Optimizer(bag, settings, 5, Dispatcher(), publish, log=lambda line: None, warn=warned.append)
    for now in range(3):
        for heard in (status, heartbeat("good")):
            optimizer.on_evaluator(encode(heard), float(now))
    bag.close()
    assert [(c.evaluator, c.engine) for c in sent] == [("good", "kernel")]
    assert sum(status.evaluator in line for line in warned) == 1
    (line,) = (line for line in warned if line.startswith(f"{status.evaluator} gets no work: "))
    assert re.search(why, line)
    study = read_study(tmp_path / "bag")
    assert [e.evaluator for e in study.evaluators] == ["good"] and study.record["engine"] == "kernel"


def test_a_study_that_names_no_engine_goes_by_its_first_evaluators() -> None:
    """The others are refused from then on; that values are invented is a warning."""
    said: list[str] = []
    admission = Admission("", said.append, lambda line: said.append(f"WARN {line}"), "paper")
    assert admission.admits(heartbeat("a", "simulated"), 0.0)
    assert said == ["WARN the study goes by engine simulated, which invents values: that of a, which joined first"]
    assert not admission.admits(heartbeat("b"), 0.0) and admission.engine == "simulated"


def test_a_flood_of_names_is_not_recorded() -> None:
    """A thousand may join at once, then one a second."""
    admission = Admission("", lambda line: None, lambda line: None, "paper")
    joined = sum(admission.admits(heartbeat(f"e{i}", "simulated"), 0.001 * i) for i in range(5000))
    assert 1000 <= joined <= 1006
    assert admission.admits(heartbeat("late", "simulated"), 60.0)


def test_an_evaluator_does_not_answer_for_another_engine() -> None:
    """What a candidate says of the engine holds for who gets it by mistake, too; it does not count against the arm."""
    answer = Answering("e", "simulated", simulated_s=0.0).answer(Candidate(evaluator="e", engine="kernel"))
    assert answer.status == Evaluation.FAILED and answer.reason.startswith("unable: engine: 'kernel'")


def test_no_stranger_makes_a_bag_unreadable(tmp_path: Path) -> None:
    """Names too long to be read back, and answers larger than any, are not recorded, whoever sends them."""
    settings = StudySettings.of({"sampler": "random", "engine": "simulated"})
    bag, warned = StudyBag(tmp_path / "bag", "s", settings, resume=False), list[str]()
    sent: list[Candidate] = []

    def publish(topic: str, data: bytes) -> None:
        sent.extend([decode(Candidate, data)] if topic == "candidates" else [])

    optimizer = Optimizer(bag, settings, 2, Dispatcher(), publish, log=lambda line: None, warn=warned.append)
    long: dict[str, Any] = {name: "x" * 5000 for name in ("host_id", "mobo_version", "kernel_hash", "engine")}
    for name, value in long.items():
        optimizer.on_evaluator(encode(EvaluatorStatus(evaluator=name, workers=1, **{name: value})), 0.0)
    many = EvaluatorStatus(evaluator="e", workers=1, engine="simulated", objectives=["x" * 100] * 5000)
    optimizer.on_evaluator(encode(many), 0.0)
    optimizer.on_evaluator(encode(heartbeat("good", "simulated")), 0.0)
    answer = Answering("good", "simulated", simulated_s=0.0).answer(sent[0])
    for fields in ({"host_id": "x" * 5000}, {"evaluator": "x" * 5000}, {"reason": "x" * 500_000}):
        optimizer.on_evaluation(encode(replace(answer, **fields)), 0.0)
    assert optimizer.status(optimizer.state).answers_unused == 3 and sum("ignored" in line for line in warned) == 8
    optimizer.on_evaluation(encode(answer), 0.0)
    bag.close()
    study = read_study(tmp_path / "bag")
    assert len(study.evaluations) == len(study.trials) == len(study.evaluators) == 1
