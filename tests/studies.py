"""Studies for tests: run in this process, answered by the simulated engine, recorded in a real bag."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from typing import Any

from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from mobo_core.bag.study_bag import StudyBag
from mobo_core.commands import cli
from mobo_core.coordination.answer import AnswerEngine, Answering
from mobo_core.coordination.dispatch import Dispatcher
from mobo_core.coordination.optimizer import Optimizer
from mobo_core.design import Design
from mobo_core.evaluation.kernel_sources import kernel_hash
from mobo_core.messages import Candidate, Evaluation, EvaluatorStatus, StudyStatus, decode, encode
from mobo_core.search.study import StudySettings

QUICK = {"n_startup_trials": 10, "sampler": "random"}


def run_study(
    folder: Path,
    n_trials: int,
    *,
    name: str = "study",
    settings: dict[str, Any] = QUICK,
    engine: AnswerEngine = "simulated",
    evaluators: Sequence[str] = ("e0", "e1"),
    rejected: Collection[int] = (),
    kill_after: int | None = None,
    resume: bool = False,
    statuses: bool = False,
    meanwhile: Callable[[Optimizer], bool] = lambda optimizer: False,
    first: Sequence[tuple[str, Design]] = (),
) -> Path:
    """Run a study into the bag ``folder`` and return it.

    Args:
        folder: of the bag.
        n_trials: the total in it.
        name: of the study.
        settings: of the StudySettings.
        engine: of the evaluators.
        evaluators: names of who answers.
        rejected: trials that are answered with REJECTED.
        kill_after: leave the bag without an end once so many trials are told, as a killed optimizer does.
        resume: go on with the bag that is there.
        statuses: record that the study runs, as the nodes do.
        meanwhile: called again and again; if it returns true, the bag is left as by a killed optimizer.
        first: arms that the first trials are.
    """
    published: list[tuple[str, bytes]] = []
    chosen = StudySettings.of(settings)
    bag = StudyBag(folder, name, chosen, resume=resume)

    def publish(topic: str, data: bytes) -> None:
        published.append((topic, data))

    try:
        optimizer = Optimizer(bag, chosen, n_trials, Dispatcher(), publish, log=lambda line: None, first=first)
    except BaseException:
        bag.close()  # as the node does
        raise
    if statuses:
        optimizer.record_status(StudyStatus.RUNNING)
    who = {name: Answering(name, engine, simulated_s=0.0) for name in evaluators}
    pending: list[Any] = []
    now = 0.0
    while not optimizer.done:
        now += 0.5
        for evaluator in who:
            holds = [candidate for candidate in pending if candidate.evaluator == evaluator]
            status = EvaluatorStatus(evaluator=evaluator,
                workers=2,
                engine=engine,
                kernel_hash="" if engine == "simulated" else kernel_hash(),
                host_id="test",
                studies=[name] * len(holds),
                trials=[candidate.trial for candidate in holds],
                attempts=[candidate.attempt for candidate in holds],
            )
            optimizer.on_evaluator(encode(status), now)
        pending += [decode(Candidate, data) for topic, data in published if topic == "candidates"]
        published.clear()
        if meanwhile(optimizer):
            bag._lock.release()
            return folder
        for candidate in pending:
            if kill_after is not None and len(optimizer.study.told) >= kill_after:
                bag._lock.release()  # as the kernel does for a killed process; the file keeps no end
                return folder
            answering = who[candidate.evaluator]
            if candidate.trial in rejected:
                rejection = Evaluation.REJECTED
                answer = answering.refusal(candidate, rejection, 'no good <arm> & "so" on')
            else:
                answer = answering.answer(candidate)
            optimizer.on_evaluation(encode(answer), now)
        pending.clear()
    bag.close()
    return folder


def messages(bag: Path, topic: str) -> list[Any]:
    """Return the messages of a topic as rosbags reads them, by the definitions in the bag."""
    with AnyReader([bag], default_typestore=get_typestore(Stores.EMPTY)) as reader:
        chosen = [connection for connection in reader.connections if connection.topic == topic]
        return [
            reader.deserialize(data, connection.msgtype) for connection, _, data in reader.messages(connections=chosen)
        ]


def mobo(*arguments: object) -> int:
    """Run the mobo command in this process and return its exit code."""
    try:
        return cli.main([str(argument) for argument in arguments])
    except SystemExit as stop:
        return int(stop.code or 0)


def mobo_json(capsys: Any, *arguments: object) -> Any:
    """Run the mobo command, which must succeed, and return the JSON it prints."""
    capsys.readouterr()
    assert mobo(*arguments) == 0
    return json.loads(capsys.readouterr().out)
