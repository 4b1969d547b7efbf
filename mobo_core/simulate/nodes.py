"""Simulated nodes: around the real optimizer and evaluator, what the ROS nodes are around them."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from mobo_core.bag.study_bag import StudyBag
from mobo_core.coordination.answer import Answering
from mobo_core.coordination.dispatch import Dispatcher
from mobo_core.coordination.evaluator import HEARTBEAT_S, Evaluator
from mobo_core.coordination.leases import LiveEvaluator
from mobo_core.coordination.namespace import Known, Namespace
from mobo_core.coordination.namespace_claim import in_use
from mobo_core.coordination.optimizer import Optimizer
from mobo_core.coordination.options import OptimizerOptions
from mobo_core.coordination.plan import plan_study, total_trials
from mobo_core.coordination.pool import WorkerPool
from mobo_core.errors import InUseError, MoboError
from mobo_core.messages import (
    Candidate,
    Evaluation,
    EvaluatorStatus,
    OptimizerStatus,
    StudyStatus,
    Trial,
    decode,
    encode,
)
from mobo_core.simulate.disk import Disk
from mobo_core.simulate.network import Network
from mobo_core.simulate.oracle import describer
from mobo_core.simulate.violation import Violation
from mobo_core.simulate.witness import Witness
from mobo_core.simulate.workers import EVALUATION_TIMEOUT_S, SimulatedWorkers
from mobo_core.simulate.world import Process, World

TICK_S, STATUS_S, CLAIM_S, HOLD_S = 0.1, 0.5, 0.1, 1.0
LEASE_S = 10.0
# So long the middleware takes to see that a publisher is gone.
LIVELINESS_S = 2.0


@dataclass
class _Heard:
    """What an evaluator said last: when, how many places it has, and what it holds, without what it answered since."""

    at: float
    places: int
    holds: set[tuple[int, int]]


class OptimizerNode(Process):
    """One run of an optimizer, from its claim to its end.

    Args:
        world, name, host: as of any process.
        number: of the process on its host.
        network: it hears and is heard on.
        disk: its bag lies on.
        options: its parameters.
        witness: watches its bag.
        holders: who holds the namespace, or did a moment ago: until when that is believed.
        locks: host -> who has the host's lock on the namespace.

    Attributes:
        optimizer: the real one, once it holds namespace and bag.
        finished: whether the study is done.
    """

    def __init__(
        self,
        world: World,
        name: str,
        host: str,
        number: int,
        network: Network,
        disk: Disk,
        options: OptimizerOptions,
        witness: Witness,
        holders: dict[OptimizerNode, float],
        locks: dict[str, OptimizerNode],
    ) -> None:
        super().__init__(world, name, host)
        self._network, self._disk, self.options, self._witness = network, disk, options, witness
        self._holders, self._locks = holders, locks
        self.optimizer: Optimizer | None = None
        self.finished = False
        self._bag: StudyBag | None = None
        self._heard: dict[str, _Heard] = {}
        self._leased: dict[tuple[int, int, str], LiveEvaluator] = {}
        message = OptimizerStatus(
            optimizer=f"/{name}", study=options.study_name, bag=str(options.folder), host_id=host, pid=number
        )
        self.namespace = Namespace(
            message, "namespace /", self.clock(), lease_s=options.lease_s, lock=self._lock, publish=self._publish,
            say=lambda text: None,
        )  # fmt: skip
        network.subscribe(self, "claims", lambda data: self.namespace.on_claim(data, self.clock()))
        network.subscribe(self, "optimizers", lambda data: self.namespace.on_holder(data, self.clock()))
        self.every(TICK_S, self._tick)
        self.every(HOLD_S, lambda: self.namespace.repeat() if self.namespace.holding else None)
        self.every(STATUS_S, self._report)

    def command(self, give: Callable[[Optimizer], object]) -> None:
        """Give the optimizer a command, as a service does."""

        def act() -> None:
            if self.optimizer is not None:
                give(self.optimizer)
                self.optimizer.tick(self.clock())

        self.do(act)

    def _lock(self, known: Known) -> object:
        holder = self._locks.get(self.host)
        if holder is not None and holder.alive:
            raise in_use(holder.namespace._claim.me, "namespace /")
        self._locks[self.host] = self
        return self

    def _publish(self, topic: str, data: bytes) -> None:
        self._witness.published(topic, data)
        if topic == "candidates":
            sent = decode(Candidate, data)
            self.world.say(f"{self.name} sends trial {sent.trial}, attempt {sent.attempt}, to {sent.evaluator}")
            self._look_at_places(sent.evaluator)
        elif topic == "trials":
            told = decode(Trial, data)
            self.world.say(f"{self.name} tells trial {told.trial} (attempt {told.attempt} on {told.evaluator})")
        self._network.publish(self, topic, data)

    def _tick(self) -> None:
        if self.optimizer is not None:
            self.optimizer.tick(self.clock())
            return
        self.namespace.repeat()
        others = [node for node, until in self._holders.items() if node is not self and self.world.now < until]
        self.namespace.alive(sum(self._network.reaches(self, node) for node in others))
        if (bag := self.namespace.take(self._open_bag, self.clock())) is not None:
            self._begin(bag)

    def _open_bag(self) -> StudyBag:
        plan = plan_study(self.options)
        return StudyBag(plan.folder, plan.name, plan.settings, resume=plan.goes_on, node=f"/{self.name}",
                        create=self._disk.create)  # fmt: skip

    def _begin(self, bag: StudyBag) -> None:
        self._bag = bag
        self.namespace.hold()
        self._holders[self] = float("inf")
        past = bag.past()
        self._witness.reopened()
        options = self.options
        n_trials = options.n_trials
        if past is not None:
            n_trials = total_trials(options, past.n_trials, len(past.trials))
        self._dispatcher = Dispatcher(
            lease_s=options.lease_s, max_attempts=options.max_attempts,
            evaluation_timeout_s=options.evaluation_timeout_s,
        )  # fmt: skip
        self.optimizer = Optimizer(
            bag, bag.settings, n_trials, self._dispatcher, self._publish, log=lambda text: None, warn=lambda text: None,
            describe=describer(bag.settings.space),
        )  # fmt: skip
        self.world.say(f"{self.name} runs: {len(self.optimizer.study.told)} trials told before")
        self._witness.reopened()  # a file that was torn has been made whole
        optimizer = self.optimizer
        self._network.subscribe(self, "evaluators", self._on_evaluator)
        self._network.subscribe(self, "evaluations", self._on_evaluation)
        if not optimizer.done:
            optimizer.record_status(StudyStatus.RUNNING)

    def _on_evaluator(self, data: bytes) -> None:
        with contextlib.suppress(MoboError):
            status = decode(EvaluatorStatus, data)
            named = zip(status.studies, status.trials, status.attempts, strict=True)
            holds = {(int(trial), int(attempt)) for study, trial, attempt in named if study == self.options.study_name}
            if status.state == EvaluatorStatus.ALIVE:
                self._heard[status.evaluator] = _Heard(self.clock(), status.workers, holds)
            else:
                self._heard.pop(status.evaluator, None)
        if self.optimizer is not None:
            self.optimizer.on_evaluator(data, self.clock())

    def _on_evaluation(self, data: bytes) -> None:
        with contextlib.suppress(MoboError):
            answer = decode(Evaluation, data)
            if (heard := self._heard.get(answer.evaluator)) is not None:
                heard.holds.discard((answer.trial, answer.attempt))
        if self.optimizer is not None:
            self.optimizer.on_evaluation(data, self.clock())

    def _report(self) -> None:
        if self.optimizer is not None:
            self._publish("study", encode(self.optimizer.status(self.optimizer.state)))

    def look(self) -> None:
        """See that what it did is in its bag, that it hands out work by its rules, and end if it is over."""
        if (optimizer := self.optimizer) is None or not self.alive:
            return
        self._witness.look(optimizer)
        self._look_at_leases()
        if optimizer.done or optimizer.controls.stopped:
            final = optimizer.end()
            assert self._bag is not None
            self._bag.close()
            self._publish("study", final)
            self.finished = optimizer.done
            self.alive = False
            self.world.say(f"{self.name} ends: {'done' if optimizer.done else 'stopped'}")
            self.is_gone()

    def _look_at_places(self, name: str) -> None:
        """See that what an evaluator was sent, and what it says it has, wanted or not, is no more than its places."""
        known, heard = self._dispatcher._evaluators[name], self._heard.get(name)
        if heard is not None and len(held := known.leases.keys() | heard.holds) > heard.places:
            raise Violation("places", f"{name} has {heard.places} places, and is to have {len(held)} candidates")

    def _look_at_leases(self) -> None:
        """See that no lease has ended of which an evaluator said just now that it has the candidate."""
        now, dispatcher = self.clock(), self._dispatcher
        alive, opened = dispatcher._evaluators, dispatcher._open
        for lease, evaluator in self._leased.items():
            trial, attempt, name = lease
            if trial not in opened or alive.get(name) is not evaluator or not evaluator.is_proven:
                continue
            said, record = self._heard.get(name), opened[trial]
            still = attempt in record.leases or name in record.failed_on() | record.unable
            if said and not still and now - said.at < HEARTBEAT_S and (trial, attempt) in said.holds:
                raise Violation("leases", f"{name} has trial {trial} and says so, but its lease has ended")
        self._leased = {
            (trial, attempt, lease.dispatch.evaluator): alive[lease.dispatch.evaluator]
            for trial, record in opened.items()
            for attempt, lease in record.leases.items()
        }
        if any(len(record.leases) > 2 for record in opened.values()):
            raise Violation("leases", "a trial is with three evaluators")

    def kill(self) -> None:
        """End at once: nothing is written, no file is finished."""
        if self._bag is not None and self._bag._lock is not None:
            self._bag._lock.release()
        super().kill()

    def ends(self, error: MoboError) -> None:
        """End with an error, as the node does."""
        if self._bag is not None:
            with contextlib.suppress(MoboError):
                self._bag.close()
        if not isinstance(error, InUseError) and self.optimizer is not None:
            self._network.publish(self, "study", encode(self.optimizer.status(StudyStatus.FAILED, str(error))))
        super().ends(error)

    def is_gone(self) -> None:
        """Let go of namespace and bag; that it is gone shows a while later."""
        if self._locks.get(self.host) is self:
            del self._locks[self.host]
        if self in self._holders:
            self._holders[self] = self.world.now + LIVELINESS_S
        if self._bag is not None:
            self._disk.bury()


class EvaluatorNode(Process):
    """One run of an evaluator.

    Args:
        world, name, host: as of any process.
        network: it hears and is heard on.
        n_workers: how many it has.
        evaluation_s: s an evaluation takes.
        timeout_s: s after which it replaces a worker.
        engine: it says it has.
        version: of mobo it says it is.
    """

    def __init__(
        self,
        world: World,
        name: str,
        host: str,
        network: Network,
        n_workers: int,
        evaluation_s: float,
        timeout_s: float,
        *,
        engine: str = "simulated",
        version: str = "",
    ) -> None:
        super().__init__(world, name, host)
        self._network, self._engine, self._version = network, engine, version
        self.workers = SimulatedWorkers(self, evaluation_s)
        answering = Answering(name, "simulated", simulated_s=0.0)
        self.pool = WorkerPool(answering, n_workers, timeout_s, clock=self.clock, processes=self.workers)
        self.evaluator = Evaluator(self.pool, self._publish, log=lambda text: None, warn=lambda text: None)
        self.workers.collect = self.evaluator.collect
        network.subscribe(self, "candidates", self.evaluator.on_candidate)
        network.subscribe(self, "trials", self.evaluator.on_trial)
        self.every(0.5, self.evaluator.collect, first=0.5)
        self.every(HEARTBEAT_S, self.evaluator.beat, first=self.workers.random.random())

    def _publish(self, topic: str, data: bytes) -> None:
        if topic == "evaluators" and (self._engine != "simulated" or self._version):
            status = decode(EvaluatorStatus, data)
            data = encode(dataclasses.replace(status, engine=self._engine, mobo_version=self._version))
        self._network.publish(self, topic, data)

    def leave(self) -> None:
        """End in order, with a goodbye."""
        self.do(self.evaluator.leave)
        if self.alive and not self.hangs:
            self.alive = False
            self.world.say(f"{self.name} leaves")


def options_of(folder: Path, name: str, settings: dict[str, object], n_trials: int) -> OptimizerOptions:
    """Return the parameters of an optimizer that begins a study or goes on with it."""
    return OptimizerOptions.of({
        "study_name": name, "bag": str(folder), "n_trials": n_trials, "engine": "simulated", "resume": True,
        "lease_s": LEASE_S, "evaluation_timeout_s": EVALUATION_TIMEOUT_S, **settings,
    })  # fmt: skip
