"""A study in this process and its workers, without ROS: the same trials and the same bag as through the nodes."""

from __future__ import annotations

import contextlib
import time
from collections import deque
from collections.abc import Callable, Iterable
from pathlib import Path

from mobo_core.bag.collector import read_study
from mobo_core.bag.reader import read_record
from mobo_core.bag.record import StudyRecord, settings_of
from mobo_core.bag.study_bag import StudyBag
from mobo_core.coordination.answer import AnswerEngine, Answering
from mobo_core.coordination.dispatch import Dispatcher
from mobo_core.coordination.evaluator import HEARTBEAT_S, Evaluator, default_name
from mobo_core.coordination.optimizer import Optimizer
from mobo_core.coordination.options import OptimizerOptions
from mobo_core.coordination.pool import WorkerPool
from mobo_core.design import Design
from mobo_core.errors import InputError, MoboError
from mobo_core.messages import StudyStatus
from mobo_core.search.study import StudySettings

_TICK_S = 0.1


def run_study(
    settings: StudySettings | None = None,
    n_trials: int = 1000,
    *,
    name: str = "study",
    bag: Path | str | None = None,
    workers: int = 2,
    threads: int = 1,
    engine: AnswerEngine | None = None,
    resume: bool = False,
    progress: Callable[[int, int], None] = lambda told, total: None,
    first: Iterable[tuple[str, Design]] = (),
) -> StudyRecord:
    """Run a study, and return it as its bag has it.

    The trials depend on ``settings`` alone, to the bit; interrupted (Ctrl-C), the bag is as whole as that of a
    stopped node, and ``resume`` goes on.

    Args:
        settings: what the trials depend on; if None those of the bag that is resumed, else the defaults of the nodes.
        n_trials: the total that the bag shall hold.
        name: of the study.
        bag: folder of the bag; ``bags/<name>`` if None.
        workers: processes that evaluate.
        threads: of each worker.
        engine: of the workers; that of the settings or the bag if None, or else the kernel.
        resume: continue the bag if it exists.
        progress: called with (trials told, trials in all) now and then.
        first: arms that the first trials of a new study are, and where each is from, such as
            :func:`mobo_core.arms.twins.known_twins` returns; they are recorded as commands.

    Raises:
        InputError: a number that is none; the bag exists and ``resume`` is false, or is of another study or other
            settings; its engine is another.
        StudyError: the bag cannot be written to, or the workers do not start.
    """
    for value, where in ((n_trials, "n_trials"), (workers, "workers"), (threads, "threads")):
        if value < 1:
            raise InputError(str(value), where=where, expected="1 or more")
    folder = Path(bag) if bag is not None else Path("bags") / name
    chosen = settings
    if chosen is None:
        recorded = resume and any(folder.glob("*.mcap"))
        chosen = settings_of(read_record(folder), str(folder)) if recorded else OptimizerOptions().settings()
    engine = engine or (chosen.engine or "kernel")
    if chosen.engine not in ("", engine):
        raise InputError(f"{engine!r}", where="engine", expected=f"{chosen.engine!r}, the study's")
    study_bag = StudyBag(folder, name, chosen.model_copy(update={"engine": engine}), resume=resume)
    try:
        run = _Run(study_bag, study_bag.settings, n_trials, progress, first)
        run.run(Answering(default_name(), engine, threads), workers)
    finally:
        study_bag.close()
    return read_study(folder)


class _Run:
    """Optimizer, evaluator and workers of one study, with nothing but calls between them."""

    def __init__(
        self, bag: StudyBag, settings: StudySettings, n_trials: int, progress: Callable[[int, int], None],
        first: Iterable[tuple[str, Design]],
    ) -> None:  # fmt: skip
        self._progress = progress
        self._published: deque[tuple[str, bytes]] = deque()
        self._optimizer = Optimizer(
            bag, settings, n_trials, Dispatcher(), lambda *message: self._published.append(message), _quiet, _quiet,
            first=first,
        )  # fmt: skip

    def run(self, answering: Answering, workers: int) -> None:
        """Run until every trial is told."""
        optimizer = self._optimizer
        if optimizer.done:
            return
        optimizer.record_status(StudyStatus.RUNNING)
        pool = WorkerPool(answering, workers)
        try:
            self._loop(pool, Evaluator(pool, lambda *message: self._published.append(message), _quiet, _quiet))
        finally:
            pool.close()
            with contextlib.suppress(MoboError):  # the bag may be what failed
                optimizer.end()

    def _loop(self, pool: WorkerPool, evaluator: Evaluator) -> None:
        optimizer, beat_at, told = self._optimizer, 0.0, -1
        takers: dict[str, Callable[[bytes], None]] = {
            "candidates": evaluator.on_candidate,
            "trials": evaluator.on_trial,
            "evaluations": lambda data: optimizer.on_evaluation(data, time.monotonic()),
            "evaluators": lambda data: optimizer.on_evaluator(data, time.monotonic()),
        }
        while not optimizer.done:
            pool.wait(_TICK_S)
            evaluator.collect()
            if (now := time.monotonic()) - beat_at >= HEARTBEAT_S:
                beat_at = now
                evaluator.beat()
            optimizer.tick(now)
            self._deliver(takers)
            if told != (told := len(optimizer.study.told)):
                self._progress(told, optimizer.n_trials)
        evaluator.leave()
        self._deliver(takers)

    def _deliver(self, takers: dict[str, Callable[[bytes], None]]) -> None:
        while self._published:
            topic, data = self._published.popleft()
            if topic in takers:
                takers[topic](data)


def _quiet(line: str) -> None:
    """Say nothing."""
