"""A simulated optimizer node: around the real optimizer, what the ROS node is around it."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from pathlib import Path

from mobo_core.bag.study_bag import StudyBag
from mobo_core.coordination.dispatch import Dispatcher
from mobo_core.coordination.namespace import Known, Namespace
from mobo_core.coordination.namespace_claim import in_use
from mobo_core.coordination.optimizer import Optimizer
from mobo_core.coordination.options import OptimizerOptions
from mobo_core.coordination.plan import plan_study, total_trials
from mobo_core.errors import InUseError, MoboError
from mobo_core.messages import (
    Candidate,
    OptimizerStatus,
    StudyStatus,
    Trial,
    decode,
    encode,
)
from mobo_core.simulate.disk import Disk
from mobo_core.simulate.network import Network
from mobo_core.simulate.oracle import describer
from mobo_core.simulate.witness import Witness
from mobo_core.simulate.work_watch import WorkWatch
from mobo_core.simulate.workers import EVALUATION_TIMEOUT_S
from mobo_core.simulate.world import Process, World

TICK_S, STATUS_S, CLAIM_S, HOLD_S = 0.1, 0.5, 0.1, 1.0
LEASE_S = 10.0
# So long the middleware takes to see that a publisher is gone.
LIVELINESS_S = 2.0


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
        self._watch: WorkWatch | None = None
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
            if self._watch is not None:
                self._watch.sent(sent.evaluator)
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
        dispatcher = Dispatcher(
            lease_s=options.lease_s, max_attempts=options.max_attempts,
            evaluation_timeout_s=options.evaluation_timeout_s,
        )  # fmt: skip
        self._watch = watch = WorkWatch(options.study_name, dispatcher)
        self.optimizer = optimizer = Optimizer(
            bag, bag.settings, n_trials, dispatcher, self._publish, log=lambda text: None, warn=lambda text: None,
            describe=describer(bag.settings.space),
        )  # fmt: skip
        self.world.say(f"{self.name} runs: {len(self.optimizer.study.told)} trials told before")
        self._witness.reopened()  # a file that was torn has been made whole

        def on_evaluator(data: bytes) -> None:
            watch.heard(data, self.clock())
            optimizer.on_evaluator(data, self.clock())

        def on_evaluation(data: bytes) -> None:
            watch.answered(data)
            optimizer.on_evaluation(data, self.clock())

        self._network.subscribe(self, "evaluators", on_evaluator)
        self._network.subscribe(self, "evaluations", on_evaluation)
        if not optimizer.done:
            optimizer.record_status(StudyStatus.RUNNING)

    def _report(self) -> None:
        if self.optimizer is not None:
            self._publish("study", encode(self.optimizer.status(self.optimizer.state)))

    def look(self) -> None:
        """See that what it did is in its bag, that it hands out work by its rules, and end if it is over."""
        if (optimizer := self.optimizer) is None or not self.alive:
            return
        self._witness.look(optimizer)
        if self._watch is not None:
            self._watch.look(self.clock())
        if optimizer.done or optimizer.controls.stopped:
            final = optimizer.end()
            assert self._bag is not None
            self._bag.close()
            self._publish("study", final)
            self.finished = optimizer.done
            self.alive = False
            self.world.say(f"{self.name} ends: {'done' if optimizer.done else 'stopped'}")
            self.is_gone()

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


def options_of(folder: Path, name: str, settings: dict[str, object], n_trials: int) -> OptimizerOptions:
    """Return the parameters of an optimizer that begins a study or goes on with it."""
    return OptimizerOptions.of({
        "study_name": name, "bag": str(folder), "n_trials": n_trials, "engine": "simulated", "resume": True,
        "lease_s": LEASE_S, "evaluation_timeout_s": EVALUATION_TIMEOUT_S, **settings,
    })  # fmt: skip
