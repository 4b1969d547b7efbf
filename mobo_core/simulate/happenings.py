"""How each kind of fault begins and ends in a simulation."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from mobo_core.bag.blank import is_blank
from mobo_core.bag.cut import cut_bag
from mobo_core.bag.recover import recover_bag
from mobo_core.simulate.disk import Disk
from mobo_core.simulate.evaluator_node import EvaluatorNode
from mobo_core.simulate.faults import Fault, Plan
from mobo_core.simulate.network import Network
from mobo_core.simulate.optimizer_node import OptimizerNode
from mobo_core.simulate.stranger import Stranger
from mobo_core.simulate.witness import Witness
from mobo_core.simulate.workers import EVALUATION_TIMEOUT_S, Manners
from mobo_core.simulate.world import Process, World

_HOUR_S = 3600.0
HOME = "home"


class Stage(Protocol):
    """What faults befall.

    Attributes:
        plan, world, network, disk: of the simulation; the disk is that of the bag.
        witness: watches the bag.
        optimizer, rival: of the study, if they were started.
        evaluators, manners, limits: each, what is wrong with its workers, and s after which it replaces them.
        others: processes that end with the faults.
    """

    plan: Plan
    world: World
    network: Network
    disk: Disk
    witness: Witness
    optimizer: OptimizerNode | None
    rival: OptimizerNode | None
    evaluators: list[EvaluatorNode]
    manners: list[Manners]
    limits: list[float]
    others: list[Process]

    def resume(self) -> None:
        """End a pause."""

    def enqueue(self, number: int) -> None:
        """Enqueue an arm."""

    def next_number(self) -> int:
        """Return a number that no process has yet."""

    def start_optimizer(self, name: str, host: str) -> OptimizerNode:
        """Start an optimizer of the study."""

    def start_other_study(self, host: str) -> OptimizerNode:
        """Start the optimizer of another study."""


def begin(simulation: Stage, fault: Fault) -> None:
    """Let a fault begin, and end in time."""
    for kinds, happening in _OF.items():
        if fault.kind in kinds:
            end = happening(simulation, fault)
            if end is not None:
                simulation.world.after(fault.seconds, end)


End = Callable[[], None] | None


def _weather(simulation: Stage, fault: Fault) -> End:
    weather = simulation.network.weather
    host = f"host{fault.target % 4}" if fault.target % 4 else HOME

    def end() -> None:
        if fault.kind == "partition":
            weather.cut.discard(host)
        elif fault.kind == "delay":
            weather.delay_s = 0.0
        elif fault.kind == "loss":
            weather.loss = 0.0
        elif fault.kind == "duplicate":
            weather.twice = 0.0
        else:
            weather.jitter_s = 0.0

    if fault.kind == "partition":
        weather.cut.add(host)
    elif fault.kind == "delay":
        weather.delay_s = 3.0 * fault.amount
    elif fault.kind == "loss":
        weather.loss = 0.6 * fault.amount
    elif fault.kind == "duplicate":
        weather.twice = fault.amount
    else:
        weather.jitter_s = 2.0 * fault.amount
    return end


def _clock(simulation: Stage, fault: Fault) -> End:
    if fault.kind == "wall_clock":
        simulation.world.wall_shift_s += (2.0 * fault.amount - 1.0) * _HOUR_S
        return None
    # It goes at another pace until the process ends: a monotonic clock does not jump.
    nodes = [*simulation.evaluators, simulation.optimizer]
    node = nodes[fault.target % len(nodes)]
    if node is not None:
        before = node.clock()
        node.rate = 0.8 + 0.4 * fault.amount
        node.shift_s += before - node.clock()
    return None


def _disk(simulation: Stage, fault: Fault) -> End:
    disk = simulation.disk
    if fault.kind == "torn_write":
        disk.torn = True
        return None
    if fault.kind == "power_loss":
        _kill_optimizers(simulation)
        disk.lose_tail(simulation.witness.folder)
        simulation.witness.reopened(lost_tail=True)
        return None

    def end() -> None:
        setattr(disk, name, False)

    name = "full" if fault.kind == "disk_full" else "short"
    setattr(disk, name, True)
    return end


def _kill_optimizers(simulation: Stage) -> None:
    for node in (simulation.optimizer, simulation.rival):
        if node is not None:
            node.kill()


def _cut(simulation: Stage, fault: Fault) -> End:
    _kill_optimizers(simulation)
    folder, witness = simulation.witness.folder, simulation.witness
    if not folder.exists() or is_blank(folder):
        return None
    before = int(fault.amount * (witness.told + 1))
    recover_bag(folder)
    cut_bag(folder, before)
    simulation.world.say(f"the bag is cut before trial {before}")
    witness.was_cut(before)
    return None


def _optimizer(simulation: Stage, fault: Fault) -> End:
    node = simulation.optimizer
    if node is None:
        return None
    if fault.kind == "kill_optimizer":
        node.kill()
    elif fault.kind == "hang_optimizer":
        node.hang(fault.seconds)
    elif fault.kind == "stop":
        node.command(lambda o: o.controls.stop(len(o.study.asked), "simulation"))
    elif fault.kind == "pause":
        node.command(lambda o: o.controls.pause(len(o.study.asked), "simulation"))
        return simulation.resume
    else:
        simulation.enqueue(fault.target)
    return None


def _rival(simulation: Stage, fault: Fault) -> End:
    if fault.kind == "rival_bag":
        if simulation.rival is not None and simulation.rival.alive:
            return None
        simulation.rival = rival = simulation.start_optimizer("rival", HOME)
    else:
        rival = simulation.start_other_study(HOME if fault.target % 2 else "host9")
        simulation.others.append(rival)
    return rival.kill


def _evaluator(simulation: Stage, fault: Fault) -> End:
    i = fault.target % len(simulation.evaluators)
    node, manners = simulation.evaluators[i], simulation.manners[i]

    def end() -> None:
        manners.__dict__.update(Manners().__dict__)

    if fault.kind == "kill_evaluator":
        node.kill()
    elif fault.kind == "leave_evaluator":
        node.leave()
    elif fault.kind == "hang_evaluator":
        node.hang(fault.seconds)
    elif fault.kind == "slow_evaluator":
        manners.slow = 1.0 + 29.0 * fault.amount
        return end
    elif fault.kind == "long_limit":
        simulation.limits[i] = EVALUATION_TIMEOUT_S * (1.2 + 1.8 * fault.amount)
        node.kill()  # the next has it
        manners.dawdles = fault.amount
        return end
    else:
        name = {
            "dying_workers": "dies", "hanging_workers": "hangs", "lying_workers": "lies", "convincing_liar": "deceives",
        }[fault.kind]  # fmt: skip
        setattr(manners, name, fault.amount)
        return end
    return None


def _arms(simulation: Stage, fault: Fault) -> End:
    def share(of_trials: float) -> None:
        for manners in simulation.manners:
            manners.fails = of_trials

    share(0.5 * fault.amount)
    return lambda: share(0.0)


def _guest(simulation: Stage, fault: Fault) -> End:
    number, world, network = simulation.next_number(), simulation.world, simulation.network
    if fault.kind == "stranger":
        guest: Stranger | EvaluatorNode = Stranger(world, f"stranger{number}", "host8", network)
    else:
        engine, version = "simulated", ""
        if fault.kind == "other_version":
            engine, version = ("kernel", "reference", "")[fault.target % 3], "9.9.9"
        guest = EvaluatorNode(world, f"guest{number}", "host8", network, 2, simulation.plan.evaluation_s, 1e6,
                              engine=engine, version=version)  # fmt: skip
        guest.workers.manners = Manners(unable=fault.kind == "unable", deaf=fault.kind == "deaf")
    simulation.others.append(guest)
    return guest.kill


_OF: dict[tuple[str, ...], Callable[[Stage, Fault], End]] = {
    ("delay", "loss", "duplicate", "reorder", "partition"): _weather,
    ("wall_clock", "drift"): _clock,
    ("short_writes", "disk_full", "torn_write", "power_loss"): _disk,
    ("kill_optimizer", "hang_optimizer", "stop", "pause", "enqueue"): _optimizer,
    ("rival_namespace", "rival_bag"): _rival,
    ("kill_evaluator", "leave_evaluator", "hang_evaluator", "slow_evaluator", "dying_workers", "hanging_workers",
     "lying_workers", "convincing_liar", "long_limit"): _evaluator,
    ("failing_arms",): _arms,
    ("bag_cut",): _cut,
    ("unable", "deaf", "other_version", "stranger"): _guest,
}  # fmt: skip
