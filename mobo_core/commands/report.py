"""``mobo report``: what a study found, as tables, pictures and a page."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from mobo_core.commands.parsing import Verbs
from mobo_core.commands.reading import read_bag_argument
from mobo_core.errors import visible

if TYPE_CHECKING:
    from mobo_core.atlas.atlas import Atlas
    from mobo_core.report.report import Report

_OTHER_PREFIXES = 6  # shown in the terminal beside the paper's; the page has all


def add(verbs: Verbs) -> None:
    """Add the verb's parser."""
    parser = verbs.add_parser(
        "report",
        help="front, pictures and a page of recorded studies",
        description="Print the Pareto front and the best arms of a study, and write into DIR tables (front.csv,\n"
        "trials.csv, joint_torques.csv), pictures, and a page of them all (index.html).\n"
        "Of several bags each gets a folder of its own in DIR, and DIR/index.html leads to them.",
        epilog="examples:\n"
        "  mobo report bags/demo_001 -o bags/demo_001_report\n"
        "  mobo report bags/seed_0 bags/seed_1 bags/seed_2 -o reports",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("bags", nargs="+", metavar="BAG", help="folder of a bag, or an .mcap file")
    parser.add_argument("-o", "--output", required=True, metavar="DIR", help="folder to write to; made if missing")
    parser.add_argument(
        "--pin", type=int, nargs="+", default=[], metavar="N", help="trials to evaluate again whatever they are worth"
    )
    parser.add_argument("--hosts", action="store_true", help="name the evaluators, and so their hosts, in trials.csv")
    parser.add_argument(
        "--atlas", metavar="FILE", help="of `mobo atlas`, to say how far a study is from it [the one mobo brings]"
    )
    parser.set_defaults(run=run)
    parser.more = _pictures


def _pictures() -> str:
    from mobo_core.report.figures.registry import FIGURES

    width = max(len(figure.files) for figure in FIGURES.values())
    lines = [f"  {figure.files:{width}}  {figure.caption}" for figure in FIGURES.values()]
    return "\n".join(["pictures:", *lines])


def run(args: argparse.Namespace) -> int:
    """Read, write, print."""
    from mobo_core.atlas.regret import fitting_atlas
    from mobo_core.bag.files import bag_files
    from mobo_core.commands.progress import bar
    from mobo_core.report.own_atlas import engine_of
    from mobo_core.report.report import PAGE, report_folders, write_index, write_report

    output = Path(args.output)
    for bag in args.bags:
        bag_files(bag)  # better to miss one now than after the first reports
    reports = []
    for bag, folder in zip(args.bags, report_folders([Path(bag) for bag in args.bags], output), strict=True):
        study = read_bag_argument(bag)
        atlas, why = fitting_atlas(study.settings, engine_of(study), Path(args.atlas) if args.atlas else None)
        with bar(visible(f"report of {study.name}")[:60]) as progress:
            reports.append(
                write_report(
                    study, folder, progress, bag=bag, pinned=args.pin, hosts=args.hosts, atlas=atlas, no_atlas=why
                )
            )
        _print(reports[-1])
        print(visible(f"atlas      {_against(reports[-1], atlas) if atlas is not None else why}"))
    if len(reports) > 1:
        print(f"\nall pages  {write_index(reports, output)}")
    else:
        print(f"page       {output / PAGE}")
    return 0


def _against(report: Report, atlas: Atlas) -> str:
    from mobo_core.atlas.atlas import partial

    few = partial(atlas)
    return f"{report.regret}, by {atlas.about.trials:,} trials{f' ({few})' if few else ''}"


def _print(report: Report) -> None:
    from mobo_core.report.console import console_for, front_table, prefix_table
    from mobo_core.report.prefixes import found

    table = report.table
    failed = f", {len(table.failed)} failed" if table.failed else ""
    told = f"{len(table.rows)} trials told{failed}, {len(table.front)} on the front"
    print(f"{visible(report.study.name)}: {told}\n")
    if table.complete:
        front = front_table(table)
        prefixes = prefix_table(found(report.groups, others=_OTHER_PREFIXES), table.n_voxels)
        console = console_for(front, prefixes)
        console.print(front)
        console.print()
        console.print(prefixes)
        hidden = sum(not group.in_paper for group in report.groups) - _OTHER_PREFIXES
        if hidden > 0:
            print(f"on the page: {hidden} more\n")
    else:
        print("no complete trial: no front\n")
    print(f"table      {report.folder / 'front.csv'}")
    print(f"torques    {report.folder / 'joint_torques.csv'}")
    print(f"picture    {report.folder / 'sampling.png'}")
