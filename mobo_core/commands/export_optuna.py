"""``mobo export optuna`` and ``mobo export notebook``: a study for Optuna's tools, and for Jupyter."""

from __future__ import annotations

import argparse
from pathlib import Path

from mobo_core.commands.parsing import Verbs
from mobo_core.commands.reading import read_bag_argument


def add(kinds: Verbs) -> None:
    """Add both to the kinds of ``mobo export``."""
    parser = kinds.add_parser(
        "optuna",
        help="a study for Optuna and its dashboard",
        description="Write a study, under its own name, into a storage that Optuna and optuna-dashboard open: a\n"
        "database such as sqlite:///study.db, or the path of a journal file, which takes a fraction of the time.",
        epilog="examples:\n  mobo export optuna bags/demo_001 -o demo.journal\n"
        "  mobo export optuna bags/demo_001 -o sqlite:///demo.db\n  optuna-dashboard demo.journal",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("bag", metavar="BAG", help="folder of a bag, or an .mcap file")
    parser.add_argument("-o", "--output", required=True, metavar="URL", help="sqlite:///FILE, or a journal file")
    parser.set_defaults(run=run_optuna)
    parser = kinds.add_parser(
        "notebook",
        help="a Jupyter notebook that reads a bag",
        description="Write a notebook that reads a bag by mobo's public API and draws the main pictures.",
        epilog="examples:\n  mobo export notebook bags/demo_001 -o demo.ipynb",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("bag", metavar="BAG", help="folder of a bag, or an .mcap file")
    parser.add_argument("-o", "--output", required=True, metavar="FILE", help="name of the notebook")
    parser.set_defaults(run=run_notebook)


def run_optuna(args: argparse.Namespace) -> int:
    """Write the storage."""
    from mobo_core.commands.progress import bar
    from mobo_core.report.optuna_trials import export_study

    study = read_bag_argument(args.bag)
    with bar("writing trials") as progress:
        name, count = export_study(study, args.output, progress)
    print(f"{count} trials as study {name!r}: {args.output}")
    return 0


def run_notebook(args: argparse.Namespace) -> int:
    """Write the notebook."""
    from mobo_core.outputs import write_whole
    from mobo_core.report.notebook import notebook

    study = read_bag_argument(args.bag)
    write_whole(Path(args.output), notebook(study.name, str(Path(args.bag).resolve())))
    print(args.output)
    return 0
