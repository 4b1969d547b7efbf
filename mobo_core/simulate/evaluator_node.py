"""A simulated evaluator node: around the real evaluator and its pool, what the ROS node is around them."""

from __future__ import annotations

import dataclasses

from mobo_core.coordination.answer import Answering
from mobo_core.coordination.evaluator import HEARTBEAT_S, Evaluator
from mobo_core.coordination.pool import WorkerPool
from mobo_core.messages import EvaluatorStatus, decode, encode
from mobo_core.simulate.network import Network
from mobo_core.simulate.workers import SimulatedWorkers
from mobo_core.simulate.world import Process, World


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
