"""``mobo bench``: how fast and how complete evaluation and sampler are, on this machine."""

from __future__ import annotations

import argparse
import json

from mobo_core.commands import bench_designs, bench_evaluate
from mobo_core.commands.parsing import Verbs
from mobo_core.errors import InputError


def add(verbs: Verbs) -> None:
    """Add the verb's parser."""
    parser = verbs.add_parser("bench", help="measure speed and completeness on this machine")
    benches = parser.add_subparsers(dest="bench", metavar="BENCH", required=True)
    bench_evaluate.add(benches)
    bench_designs.add(benches)
    sampler = benches.add_parser(
        "sampler",
        help="mobo's TPE against Optuna's",
        description="Measure ask + tell of mobo's TPE sampler and of Optuna's with equal settings, on the same "
        "history of random designs, and the largest difference of their densities.",
        epilog="examples:\n  mobo bench sampler\n"
        "  mobo bench sampler --json --trials 20000 --joints 7 --mode sequential",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    sampler.add_argument("--trials", default="1000,5000,20000", metavar="N,N,…",
                         help="finished trials to measure at [1000,5000,20000]")  # fmt: skip
    sampler.add_argument("--joints", type=int, default=6, help="joints of an arm [6]")
    sampler.add_argument("--mode", choices=["fractions", "sequential"], default="fractions",
                         help="how link lengths are drawn [fractions]")  # fmt: skip
    sampler.add_argument("--json", action="store_true", help="print JSON")
    sampler.set_defaults(run=run_sampler)


def run_sampler(args: argparse.Namespace) -> int:
    """Measure and print."""
    from mobo_core.bench.sampler import bench_sampler
    from mobo_core.commands.progress import bar
    from mobo_core.design import DesignSpace

    try:
        trials = [int(word) for word in args.trials.split(",")]
    except ValueError:
        trials = []
    if not trials or min(trials) < 200:
        raise InputError(repr(args.trials), where="--trials", expected="whole numbers from 200, such as 1000,5000")
    space = DesignSpace.of({"n_joints": args.joints, "lengths": args.mode}, where="arguments")
    with bar("measuring", quiet=args.json) as progress:
        found = bench_sampler(trials, space, progress)
    if args.json:
        print(json.dumps(found))
        return 0
    print(f"{found['joints']} joints, {found['mode']}; ask + tell in ms, Optuna {found['optuna']}")
    print(f"{'trials':>7} {'mobo':>7} {'Optuna':>8} {'ratio':>6} {'of it draw':>10} {'bytes kept a trial':>19}")
    for row in found["rows"]:
        print(
            f"{row['n_trials']:7} {row['ms_mobo']:7.2f} {row['ms_optuna']:8.1f} {row['ratio']:6.1f} "
            f"{row['ms_draw']:10.2f} {row['bytes_per_trial']:19.0f}"
        )
    print(f"largest difference of log densities and acquisition values: {found['max_density_error']:.1e}")
    return 0
