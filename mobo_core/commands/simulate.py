"""``mobo simulate``: studies in a simulated world in which much goes wrong."""

from __future__ import annotations

import argparse
import os
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from itertools import count
from multiprocessing import get_context
from typing import TYPE_CHECKING

from mobo_core.commands.parsing import Verbs
from mobo_core.errors import InputError

if TYPE_CHECKING:
    from mobo_core.simulate.simulation import Outcome

_MOST_MINUTES = 100_000.0


def add(verbs: Verbs) -> None:
    """Add the verb's parser."""
    parser = verbs.add_parser(
        "simulate",
        help="run studies in a simulated world in which much goes wrong",
        description="Run a whole study in one process under one seed: the real optimizer, dispatcher, bag and\n"
        "evaluators; a simulated network, disk, clock and processes, which fail as the seed says. After every step:\n"
        "each trial is told at most once, in order, from its first valid answer, recorded before it takes effect, and\n"
        "equal to the undisturbed study. When the faults stop, the study must come to its end, and its bag verify,\n"
        "but for lies and for arms given up. Exit code 1 shows a violation, made as small as can be found.",
        epilog="examples:\n  mobo simulate --seed 7\n  mobo simulate --seed 0 --minutes 10\n"
        "  mobo simulate --seed 0 --minutes 1 --faults torn_write,kill_optimizer",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="what happens; the first of them [0]")
    parser.add_argument("--minutes", type=float, metavar="M", help="take seeds N, N+1, … for so long [one seed]")
    parser.add_argument("--faults", metavar="KIND,…", help="faults that may occur [all]; 'list' lists them")
    parser.add_argument("--trials", type=int, default=0, metavar="N", help="trials of a study [drawn from the seed]")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1, help="processes, with --minutes [cores]")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Simulate and print what came of it."""
    from mobo_core.commands.progress import bar
    from mobo_core.simulate.faults import KINDS
    from mobo_core.simulate.shrink import shrink

    if args.faults == "list":
        for name, what in KINDS.items():
            print(f"{name:16} {what}")
        return 0
    kinds = tuple(args.faults.split(",")) if args.faults else tuple(KINDS)
    for kind in kinds:
        if kind not in KINDS:
            raise InputError(repr(kind), where="--faults", expected=", ".join(KINDS))
    bounds = {"workers": (1, 1000), "trials": (0, 10_000), "minutes": (0, _MOST_MINUTES)}
    for name, (least, most) in bounds.items():
        value = getattr(args, name)
        if value is not None and not least <= value <= most:
            raise InputError(str(value), where=f"--{name}", expected=f"a number from {least} to {most:g}")
    seeds = trials = 0
    faults: Counter[str] = Counter()
    began = time.monotonic()
    total_s = int(60 * args.minutes) if args.minutes else 0
    with bar("seconds of simulating") as progress:
        for outcome in _outcomes(args, kinds):
            seeds, trials, faults = seeds + 1, trials + outcome.told, faults + outcome.faults
            if args.minutes:
                progress(min(total_s, int(time.monotonic() - began)), total_s)
            if outcome.violation is not None:
                break
    if outcome.violation is not None:
        with bar("looking for a smaller case") as progress:
            smallest = shrink(outcome, progress)
        _show(outcome, smallest)
        return 1
    took = time.monotonic() - began
    rate = f", {3600 * trials / took:,.0f} an hour" if args.minutes else ""
    which = f"seed {args.seed}" if seeds == 1 else f"seeds {args.seed} to {args.seed + seeds - 1}"
    print(f"good: {which}, {trials:,} trials told{rate}, {faults.total():,} faults survived")
    for kind in kinds:
        if faults[kind]:
            print(f"  {faults[kind]:7,} {kind}: {KINDS[kind]}")
    return 0


def _show(outcome: Outcome, smallest: Outcome) -> None:
    plan = smallest.plan
    print(f"VIOLATION, seed {plan.seed}: {smallest.violation}")
    print(f"  {plan.n_trials} trials, {len(plan.workers)} evaluators with {plan.workers} workers, "
          f"{plan.evaluation_s:g} s an evaluation, {dict(plan.settings)}")  # fmt: skip
    print(f"  {len(plan.faults)} of {len(outcome.plan.faults)} faults are enough:")
    for fault in plan.faults:
        print(f"  {fault}")
    print("  what happened last:")
    for line in smallest.trace:
        print(f"  {line}")


def _outcomes(args: argparse.Namespace, kinds: tuple[str, ...]) -> Iterator[Outcome]:
    """Yield what comes of one seed, or of seed after seed until the time is over, in no order."""
    if args.minutes is None:
        yield _one(args.seed, kinds, args.trials)
        return
    until, seeds = time.monotonic() + 60.0 * args.minutes, count(args.seed)
    with ProcessPoolExecutor(args.workers, get_context("spawn")) as pool:
        running: set[Future[Outcome]] = set()
        try:
            while True:
                while len(running) < 2 * args.workers and (time.monotonic() < until or not running):
                    running.add(pool.submit(_one, next(seeds), kinds, args.trials))
                done, running = wait(running, return_when=FIRST_COMPLETED)
                for future in done:
                    yield future.result()
                if not running and time.monotonic() >= until:
                    return
        finally:
            pool.shutdown(cancel_futures=True)


def _one(seed: int, kinds: tuple[str, ...], n_trials: int) -> Outcome:
    from mobo_core.simulate.faults import draw_plan
    from mobo_core.simulate.simulation import simulate

    return simulate(draw_plan(seed, kinds, n_trials))
