"""``mobo bench``: how fast and how complete evaluation and sampler are, on this machine."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING

from mobo_core.commands.parsing import Verbs
from mobo_core.errors import InputError

if TYPE_CHECKING:
    from mobo_core.design import Design


def add(verbs: Verbs) -> None:
    """Add the verb's parser."""
    parser = verbs.add_parser("bench", help="measure speed and completeness on this machine")
    benches = parser.add_subparsers(dest="bench", metavar="BENCH", required=True)
    evaluate = benches.add_parser(
        "evaluate",
        help="the kernel against the reference engine and an exhaustive search",
        description="Measure the evaluation of some arms, single-threaded, after warm-up: time a pose, speed "
        "against the reference engine on the same poses, and recall of what an exhaustive search finds.",
        epilog="examples:\n  mobo bench evaluate\n"
        "  mobo bench evaluate --json --design YPPYPY:0.05,0.25,0.2,0.05,0,0.05",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    evaluate.add_argument("--design", action="append", metavar="NAME:l1,l2,…", help="an arm; may be repeated")
    evaluate.add_argument("--spec", default="mobo", help="preset or YAML file [mobo]")
    evaluate.add_argument("--ik", choices=["paper", "complete"], help="inverse kinematics, over the spec's")
    evaluate.add_argument("--attempts", type=int, default=200, help="of the exhaustive search; 0: leave it out [200]")
    evaluate.add_argument("--reference-poses", type=int, default=2, metavar="N",
                          help="poses a voxel for the comparison with the reference engine [2]")  # fmt: skip
    evaluate.add_argument("--json", action="store_true", help="print JSON")
    evaluate.set_defaults(run=run_evaluate)
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


def run_evaluate(args: argparse.Namespace) -> int:
    """Measure and print."""
    from mobo_core.bench.evaluation import DESIGNS, bench_evaluate
    from mobo_core.commands.progress import bar
    from mobo_core.design import Design
    from mobo_core.evaluation import load_spec, with_ik

    spec = load_spec(args.spec)
    if args.ik:
        spec = with_ik(spec, args.ik)
    if args.attempts < 0 or not 1 <= args.reference_poses <= spec.poses_per_voxel:
        raise InputError("--attempts or --reference-poses", where="arguments", expected="0 or more; 1 to the spec's")
    designs = [_design(text) for text in args.design] if args.design else [Design(*d) for d in DESIGNS]
    with bar("measuring", quiet=args.json) as progress:
        found = bench_evaluate(designs, spec, args.attempts, args.reference_poses, progress)
    if args.json:
        print(json.dumps(found))
        return 0
    titles = f"{'exhaustive':>10} {'recall':>7} {'us/pose':>8} {'x reference':>11}   lengths in m"
    print(f"{'arm':9} {'reach':>7} {titles}")
    for row in found["designs"]:
        lengths = ",".join(f"{length:g}" for length in row["lengths"])
        print(
            f"{row['name']:9} {row['reach']:7.2f} {_shown(row['reach_exhaustive'], '.2f'):>10} "
            f"{_shown(row['recall'], '.2%'):>7} "
            f"{row['us_per_pose']:8.1f} {row['ratio_reference']:11.0f}   {lengths}"
        )
    least = _shown(found["min_recall"], ".2%")
    print(
        f"median {found['median_us_per_pose']:.1f} us a pose, {found['median_ratio']:.0f} x the reference "
        f"({found['us_per_iteration_reference']:.1f} us an iteration); least recall {least}"
    )
    return 0


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


def _shown(value: float | None, form: str) -> str:
    return "-" if value is None else format(value, form)


def _design(text: str) -> Design:
    from mobo_core.design import Design

    name, _, lengths = text.partition(":")
    try:
        return Design(name, tuple(float(word) for word in lengths.split(",")))
    except ValueError:
        raise InputError(repr(text), where="--design", expected="NAME:l1,l2,… such as RPY:0.2,0.2,0.2") from None


