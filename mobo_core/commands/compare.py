"""``mobo compare``: studies side by side."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from mobo_core.commands.parsing import Verbs
from mobo_core.commands.reading import read_bag_argument
from mobo_core.errors import InputError, visible

if TYPE_CHECKING:
    from mobo_core.report.compare.comparison import Comparison

_MOST = 40


def add(verbs: Verbs) -> None:
    """Add the verb's parser."""
    parser = verbs.add_parser(
        "compare",
        help="studies side by side",
        description="Print of several studies which settings differ, their hypervolumes and the best arm of each\n"
        "prefix, with 95 % intervals; and warn where they were asked different things, so that values\n"
        "must not be compared. Studies that differ in their seeds alone are taken together. With -o\n"
        "also pictures (fronts, attained by any, half and all of the seeds; progress; structures),\n"
        "tables as CSV, and a page of them all.",
        epilog="examples:\n"
        "  mobo compare bags/seed_0 bags/seed_1 bags/seed_2 bags/wide_limits\n"
        "  mobo compare bags/six bags/seven -o comparison\n"
        "  mobo compare bags/tpe bags/structured --json",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("bags", nargs="+", metavar="BAG", help="two or more: folder of a bag, or an .mcap file")
    parser.add_argument("-o", "--output", metavar="DIR", help="folder to write to; made if missing")
    parser.add_argument("--json", action="store_true", help="print everything as JSON")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Read, compare, print, write."""
    from mobo_core.commands.progress import bar
    from mobo_core.report.compare.write import write_comparison

    comparison = _comparison(args.bags)
    for line in comparison.warnings:
        print(visible(f"note: {line}"), file=sys.stderr)
    if args.output is not None:
        with bar("writing the comparison", quiet=args.json) as progress:
            page = write_comparison(comparison, Path(args.output), progress)
    if args.json:
        print(json.dumps(comparison.to_dict(), allow_nan=False))
        return 0
    _print(comparison)
    if args.output is not None:
        print(f"page       {page}")
    return 0


def _comparison(bags: list[str]) -> Comparison:
    from mobo_core.bag.files import bag_files
    from mobo_core.report.compare.comparison import Comparison, labels_of
    from mobo_core.report.compare.summary import summary_of

    if not 2 <= len(bags) <= _MOST:
        raise InputError(f"{len(bags)} bag{'s' * (len(bags) > 1)}", where="arguments", expected=f"2 to {_MOST}")
    paths = [Path(bag).resolve() for bag in bags]
    for bag in bags:
        bag_files(bag)
    for i, path in enumerate(paths):
        if path in paths[:i]:
            raise InputError("named twice", where=bags[i], expected="each bag once")
    names = labels_of([path.stem if path.is_file() else path.name for path in paths])
    summaries = []
    for bag, label in zip(bags, names, strict=True):
        summary = summary_of(read_bag_argument(bag), visible(label))
        if summary.best is None:
            raise InputError("no complete trial", where=bag, expected="a study with at least one arm evaluated")
        summaries.append(summary)
    return Comparison(tuple(summaries))


def _print(comparison: Comparison) -> None:
    from rich.console import Console

    from mobo_core.report.compare.tables import console_tables

    console = Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=10_000)
    for table in console_tables(comparison):
        if table.row_count:
            console.print(table)
            console.print()
