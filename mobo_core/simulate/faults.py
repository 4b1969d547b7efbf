"""What may go wrong in a simulation, kind by kind, and when it does: a plan drawn from the seed."""

from __future__ import annotations

from dataclasses import dataclass
from random import Random

# name -> what it is, for people.
KINDS: dict[str, str] = {
    "delay": "messages take up to 3 s longer",
    "loss": "a share of the messages, up to 60 %, gets lost",
    "duplicate": "messages come twice",
    "reorder": "messages overtake each other by up to 2 s",
    "partition": "a host is cut off",
    "wall_clock": "the wall clock jumps, by up to an hour",
    "drift": "the clock of a process goes up to a fifth too fast or too slow",
    "short_writes": "the disk takes a part of what is written at a time",
    "disk_full": "the disk is full; the optimizer ends, and is started again and again",
    "torn_write": "the optimizer dies in the midst of a write",
    "power_loss": "the bag's host goes down, and the bag lacks some of its end",
    "kill_optimizer": "the optimizer is killed",
    "hang_optimizer": "the optimizer hangs",
    "stop": "the optimizer is told to stop, and started again",
    "pause": "the study is paused for a while",
    "enqueue": "an arm is enqueued",
    "rival_namespace": "another study's optimizer is started in the same namespace, on this host or another",
    "rival_bag": "another optimizer is started for the same bag",
    "kill_evaluator": "an evaluator is killed, and started again",
    "leave_evaluator": "an evaluator ends in order, and is started again",
    "hang_evaluator": "an evaluator hangs",
    "slow_evaluator": "an evaluator takes up to thirty times as long",
    "dying_workers": "workers of an evaluator die over candidates",
    "hanging_workers": "workers of an evaluator hang over candidates",
    "lying_workers": "workers of an evaluator answer what cannot be",
    "unable": "an evaluator joins that is unable to answer",
    "deaf": "an evaluator joins that never answers",
    "other_version": "an evaluator of another version or engine joins",
    "stranger": "somebody sends answers nobody asked for, old ones, false heartbeats and noise",
    "failing_arms": "some arms let every worker die, hang or answer what cannot be, until their attempts are used up",
    "convincing_liar": "workers of an evaluator answer what is false, and adds up",
    "bag_cut": "the optimizer is killed, the bag made whole and cut before some trial, and gone on with",
    "long_limit": "an evaluator has a longer time limit than the optimizer, and its workers take that long, or hang",
}

# They change what later trials are; with the bag's end, what says so would be lost.
CHANGING = ("enqueue", "failing_arms", "convincing_liar")

# One draws without looking; the other sees every value told, but is compiled first.
SAMPLERS = ("random", "random", "random", "tpe")


@dataclass(frozen=True)
class Fault:
    """One thing that goes wrong.

    Attributes:
        at, seconds: when it begins, and how long it lasts.
        kind: one of KINDS.
        target: which evaluator, host or the like.
        amount: how bad it is, 0 to 1.
    """

    at: float
    kind: str
    seconds: float
    target: int
    amount: float

    def __str__(self) -> str:
        return f"{self.at:9.3f} s  {self.kind} for {self.seconds:.1f} s, target {self.target}, amount {self.amount:.2f}"


@dataclass(frozen=True)
class Plan:
    """A study and all that goes wrong in it.

    Attributes:
        seed: of all that is drawn while it runs.
        settings: of the study.
        n_trials: how many.
        workers: of each evaluator.
        evaluation_s: s an evaluation takes.
        timeout_s: s after which an evaluator replaces a worker.
        faults: by time.
    """

    seed: int
    settings: tuple[tuple[str, object], ...]
    n_trials: int
    workers: tuple[int, ...]
    evaluation_s: float
    timeout_s: float
    faults: tuple[Fault, ...]


def draw_plan(seed: int, kinds: tuple[str, ...] = tuple(KINDS), n_trials: int = 0) -> Plan:
    """Return what a seed means.

    Args:
        seed: any whole number.
        kinds: faults that may occur.
        n_trials: how many trials; 0: drawn too.
    """
    random = Random(f"plan {seed}")
    sampler = random.choice(SAMPLERS)
    settings = {
        "sampler": sampler,
        "seed": random.randrange(4),
        "in_flight": random.choice((1, 3, 8)),
        "n_startup_trials": 12,
        "n_joints": 4,
    }
    drawn = random.randint(24, 96)
    n_trials = n_trials or drawn
    workers = tuple(random.randint(1, 3) for _ in range(random.randint(1, 4)))
    evaluation_s = random.choice((0.05, 0.3, 1.0, 3.0))
    busy = min(sum(workers), int(str(settings["in_flight"])))
    span = max(8.0, 1.5 * n_trials * evaluation_s / busy)
    faults = [
        Fault(
            at=random.uniform(0.0, span),
            kind=random.choice(kinds),
            seconds=random.choice((0.5, 2.0, 5.0, 15.0, 30.0)) * random.uniform(0.5, 1.5),
            target=random.randrange(1000),
            amount=random.random(),
        )
        for _ in range(random.randint(1, 12))
    ]
    if any(fault.kind == "power_loss" for fault in faults):
        # A command that is lost with the bag's end changes what its trial is; an answer to what it was may still come.
        faults = [fault for fault in faults if fault.kind not in CHANGING]
    faults.sort(key=lambda fault: fault.at)
    timeout_s = random.choice((20.0, 1e6))
    return Plan(seed, tuple(settings.items()), n_trials, workers, evaluation_s, timeout_s, tuple(faults))
