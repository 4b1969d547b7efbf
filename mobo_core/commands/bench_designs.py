"""``mobo bench designs``: the lists of arms that ``mobo bench evaluate`` measures."""

from __future__ import annotations

import argparse
from pathlib import Path

from mobo_core.commands.parsing import Verbs
from mobo_core.errors import InputError


def add(benches: Verbs) -> None:
    """Add the bench's parser."""
    parser = benches.add_parser(
        "designs",
        help="draw arms to measure, from a bag or at random",
        description="Draw arms and write them to a file, which mobo bench evaluate takes as a group.\n\n"
        "From a bag: uniformly over the trials that were told with values, without repeating one.\n"
        "At random: N each of 6 and 7 joints at 135 and 270 degrees; the order is uniform over those that can be\n"
        "built, each link is zero with probability 1/4, the other lengths are Dirichlet (all 1), scaled to 0.6 m;\n"
        "of these, the first that an exhaustive search (200 blind attempts of 100 iterations) reaches 100 of the\n"
        "paper's poses with.",
        epilog="examples:\n  mobo bench designs bags/first --sample 32 -o first.json\n"
        "  mobo bench designs --random --sample 10 -o random.json",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("bag", nargs="?", metavar="BAG", help="a study")
    parser.add_argument("--random", action="store_true", help="draw at random instead")
    parser.add_argument("--sample", type=int, default=32, metavar="N", help="arms; at random, of each kind [32]")
    parser.add_argument("--seed", type=int, default=0, help="of the draw [0]")
    parser.add_argument("-o", "--output", required=True, metavar="FILE", help="JSON, a design a line")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Draw and write."""
    from mobo_core.bench.groups import sample_of_study
    from mobo_core.bench.random_arms import draw_random
    from mobo_core.commands.progress import bar
    from mobo_core.commands.reading import read_lean_argument
    from mobo_core.evaluation import load_spec
    from mobo_core.outputs import write_whole

    if bool(args.bag) == args.random:
        raise InputError("both" if args.bag else "neither", where="BAG or --random", expected="one of them")
    if args.sample < 1 or args.seed < 0:
        raise InputError(f"{args.sample} and {args.seed}", where="--sample and --seed", expected="1 and 0, or more")
    if args.bag:
        designs = sample_of_study(read_lean_argument(args.bag), args.sample, args.seed)
    else:
        with bar("drawing") as progress:
            designs = draw_random(load_spec("paper"), args.sample, args.seed, progress)
    write_whole(Path(args.output), designs.to_text())
    return 0
