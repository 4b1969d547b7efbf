"""One simulated study: what its plan says goes wrong, all is put right, and it must come to its end."""

from __future__ import annotations

import tempfile
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path

from mobo_core.clock import told_by
from mobo_core.coordination.options import OptimizerOptions
from mobo_core.simulate.aftermath import check_verified
from mobo_core.simulate.disk import Disk
from mobo_core.simulate.evaluator_node import EvaluatorNode
from mobo_core.simulate.faults import CHANGING, Fault, Plan
from mobo_core.simulate.happenings import HOME, begin
from mobo_core.simulate.network import Network, Weather
from mobo_core.simulate.optimizer_node import OptimizerNode, options_of
from mobo_core.simulate.oracle import oracle_of
from mobo_core.simulate.violation import Violation
from mobo_core.simulate.witness import Witness
from mobo_core.simulate.workers import Manners
from mobo_core.simulate.world import Process, World

# So long after the last fault the study may still take, and so long two optimizers may not see each other.
LIVENESS_S, SEE_EACH_OTHER_S = 900.0, 8.0
STUDY = "s"
# Arms of four joints to enqueue.
_ARMS = (("YPPP", (0.15, 0.15, 0.15, 0.15)), ("PRRY", (0.3, 0.1, 0.1, 0.1)))


@dataclass
class Outcome:
    """What became of a simulated study.

    Attributes:
        plan: it was run by.
        told: trials told.
        faults: kind -> how many of them began before it ended.
        seconds: of simulated time.
        violation: what should not have happened, or None.
        trace: the last lines on what happened.
    """

    plan: Plan
    told: int = 0
    faults: Counter[str] = field(default_factory=Counter)
    seconds: float = 0.0
    violation: Violation | None = None
    trace: list[str] = field(default_factory=list)


class Simulation:
    """The processes of a study, started and started again, and what else is there.

    Args:
        plan: what happens.
        folder: an empty one, for the bags.
    """

    def __init__(self, plan: Plan, folder: Path) -> None:
        self.plan, self.folder = plan, folder
        self.world = World(plan.seed)
        self.network = Network(self.world)
        self.disk = Disk(self.world.chance("disk"))
        self.manners = [Manners() for _ in plan.workers]
        self.limits = [plan.timeout_s for _ in plan.workers]
        self.others: list[Process] = []  # that belong to no study of ours
        self.faults: Counter[str] = Counter()
        self.options = options_of(folder / STUDY, STUDY, dict(plan.settings), plan.n_trials)
        self.witness = self._witness(self.options)
        self.optimizer: OptimizerNode | None = None
        self.rival: OptimizerNode | None = None
        self.evaluators: list[EvaluatorNode] = []
        self._holders: dict[OptimizerNode, float] = {}
        self._locks: dict[str, OptimizerNode] = {}
        self._pids = count(100)
        self._healed = False
        self._clear_since = 0.0

    def run(self) -> Outcome:
        """Run it to its end."""
        outcome = Outcome(self.plan)
        with told_by(self.world.wall_ns):
            try:
                self._start()
                self._live()
                self.witness.reopened()
                if self.witness.told != self.plan.n_trials:
                    told = f"{self.witness.told} of {self.plan.n_trials} trials"
                    raise Violation("all are told", f"{told} are in the bag of a study that is done")
                check_verified(self.witness)
            except Violation as violation:
                outcome.violation = violation
            finally:
                for process in (self.optimizer, self.rival, *self.others):
                    if process is not None:
                        process.kill()
        outcome.told, outcome.faults, outcome.seconds = self.witness.told, self.faults, self.world.now
        outcome.trace = [line.replace(f"{self.folder}/", "") for line in self.world.trace]
        return outcome

    def _start(self) -> None:
        for fault in self.plan.faults:
            self.world.after(fault.at, self._begin(fault))
        self.evaluators = [self._evaluator(i) for i in range(len(self.plan.workers))]
        self._watch()

    def _live(self) -> None:
        end = max((fault.at + fault.seconds for fault in self.plan.faults), default=0.0)
        if self.world.run(end + 1.0, self._is_over):
            return
        self._heal()
        if not self.world.run(end + LIVENESS_S, self._is_over):
            told = f"{self.witness.told} of {self.plan.n_trials} trials told"
            raise Violation("liveness", f"{told} {LIVENESS_S:g} s after the last fault")

    def _is_over(self) -> bool:
        return any(node is not None and node.finished for node in (self.optimizer, self.rival))

    def _begin(self, fault: Fault) -> Callable[[], None]:
        def now() -> None:
            self.world.say(f"fault: {fault.kind}")
            self.faults[fault.kind] += 1
            begin(self, fault)

        return now

    def _heal(self) -> None:
        self.world.say("all is put right")
        self.network.weather = Weather()
        self.disk.full = self.disk.short = self.disk.torn = False
        for manners in self.manners:
            manners.__dict__.update(Manners().__dict__)
        for process in self.others:
            process.kill()
        for node, limit in zip(self.evaluators, self.limits, strict=True):
            if limit > LIVENESS_S:  # nobody else ends workers that hang
                node.kill()
        self._healed = True

    def resume(self) -> None:
        """End a pause, if there is one."""
        for node in (self.optimizer, self.rival):
            if node is not None and node.options.study_name == STUDY:
                node.command(lambda o: o.controls.paused and o.controls.resume(len(o.study.asked), "simulation"))

    def enqueue(self, number: int) -> None:
        """Enqueue one of some arms."""
        joints, lengths = _ARMS[number % len(_ARMS)]
        if self.optimizer is not None:
            self.optimizer.command(
                lambda o: o.controls.enqueue(len(o.study.asked), "simulation", joints, lengths, o.n_trials)
            )

    def next_number(self) -> int:
        """Return a number that no process has yet."""
        return next(self._pids)

    def start_optimizer(self, name: str, host: str) -> OptimizerNode:
        """Start an optimizer of the study."""
        node = OptimizerNode(
            self.world, name, host, next(self._pids), self.network, self.disk, self.options, self.witness,
            self._holders, self._locks,
        )  # fmt: skip
        return node

    def start_other_study(self, host: str) -> OptimizerNode:
        """Start the optimizer of another study in the same namespace."""
        name = f"t{next(self._pids)}"
        folder = self.folder / name
        options = options_of(folder, name, dict(self.plan.settings), self.plan.n_trials)
        witness = self._witness(options)
        return OptimizerNode(
            self.world, name, host, next(self._pids), self.network, Disk(self.world.chance(name)), options, witness,
            self._holders, self._locks,
        )  # fmt: skip

    def _witness(self, options: OptimizerOptions) -> Witness:
        kinds, settings = {fault.kind for fault in self.plan.faults}, options.settings()
        oracle = oracle_of(settings, alone=not kinds.isdisjoint(CHANGING))
        exhausts = "failing_arms" in kinds
        return Witness(options.folder, settings, oracle, self.world.lies, may_exhaust=exhausts)

    def _evaluator(self, i: int) -> EvaluatorNode:
        plan = self.plan
        node = EvaluatorNode(
            self.world, f"e{i}", f"host{i}" if i else HOME, self.network, plan.workers[i], plan.evaluation_s,
            self.limits[i],
        )  # fmt: skip
        node.workers.manners = self.manners[i]
        return node

    def _watch(self) -> None:
        """Start again what has ended, a second later at most; see that one optimizer runs."""
        for i, node in enumerate(self.evaluators):
            if not node.alive:
                self.evaluators[i] = self._evaluator(i)
        if self.optimizer is None or (not self.optimizer.alive and not self.optimizer.finished):
            self.optimizer = self.start_optimizer("optimizer", HOME)
        if self._healed:
            self.resume()
        self._look_at_holders()
        self.world.after(1.0, self._watch)

    def _look_at_holders(self) -> None:
        holders = [node for node in self._holders if node.alive and node.namespace.holding]
        if len(holders) < 2 or not self.network.weather.fair or any(node.hangs for node in holders):
            self._clear_since = self.world.now
        elif self.world.now - self._clear_since > SEE_EACH_OTHER_S:
            raise Violation("one optimizer", f"{' and '.join(node.name for node in holders)} run in one namespace")


def simulate(plan: Plan) -> Outcome:
    """Run one simulated study, in a folder that is gone afterwards."""
    memory = Path("/dev/shm")
    with tempfile.TemporaryDirectory(prefix="mobo_simulate_", dir=memory if memory.is_dir() else None) as folder:
        return Simulation(plan, Path(folder)).run()
