"""``mobo claims``: what the paper says, checked on recorded studies."""

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
    from mobo_core.report.claims.claim import Pair
    from mobo_core.report.claims.verdict import Checked


def add(verbs: Verbs) -> None:
    """Add the verb's parser."""
    parser = verbs.add_parser(
        "claims",
        help="the paper's claims, checked on studies of 6 and 7 joints",
        description="Check what the paper says of robot arms on a study of 6 joints, one of 7, or both: for each\n"
        "claim a verdict (reproduced, not reproduced, inconclusive), the margin by which its tightest\n"
        "statement holds (a share; above 0: it does) and the margin's 95 % interval. A prefix of four\n"
        "joints that the search hardly visited is inconclusive, not worse. With an atlas each claim gets\n"
        "a second verdict, fair: not what one search met, but what the structures can do.\n"
        "docs/analysis.md says how each claim is measured.",
        epilog="examples:\n"
        "  mobo claims bags/six bags/seven\n"
        "  mobo claims bags/six bags/seven --parts\n"
        "  mobo claims bags/six bags/seven --atlas atlas_6.parquet atlas_7.parquet\n"
        "  mobo claims bags/six --json",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("bag6", metavar="BAG6", help="study of 6 joints (alone: one of 6 or 7)")
    parser.add_argument("bag7", nargs="?", metavar="BAG7", help="study of 7 joints")
    parser.add_argument(
        "--atlas", nargs="+", default=[], metavar="FILE", help="atlas of 6 or 7 joints, of `mobo atlas`, or one of each"
    )
    parser.add_argument("--parts", action="store_true", help="each statement of a claim, with its numbers")
    parser.add_argument("--json", action="store_true", help="print everything as JSON")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Read, check, print."""
    from mobo_core.commands.progress import bar
    from mobo_core.report.claims.check import check_claims

    fair = _fair(args.atlas)  # before the bags, which may take long
    pair = _pair(args.bag6, args.bag7)
    for line in fair.unlike(pair) if fair is not None else []:
        print(f"note: the fair verdicts are of another question: {line}", file=sys.stderr)
    for line in pair.apart:
        print(f"note: values of the two studies do not compare: {line}", file=sys.stderr)
    with bar("checking claims", quiet=args.json) as progress:
        checked = check_claims(pair, fair, progress)
    if args.json:
        print(json.dumps([one.to_dict() for one in checked], allow_nan=False))
        return 0
    _print(checked, parts=args.parts)
    return 0


def _pair(bag6: str, bag7: str | None) -> Pair:
    from mobo_core.bag.files import bag_files
    from mobo_core.report.claims.claim import Pair
    from mobo_core.report.claims.evidence import Evidence, of_study
    from mobo_core.report.table import study_table

    bags = [bag for bag in (bag6, bag7) if bag is not None]
    for bag in bags:
        bag_files(bag)
    found: dict[int, Evidence] = {}
    counts = []
    for bag in bags:
        study = read_bag_argument(bag)
        n = study.settings.space.n_joints
        if n not in (6, 7):
            raise InputError(f"arms of {n} joints", where=bag, expected="a study of 6 or 7 joints")
        if n in found:
            raise InputError(f"of {n} joints as {bags[0]} is", where=bag, expected=f"a study of {13 - n} joints")
        if "simulated" in {study.settings.engine, *(candidate.engine for candidate in study.candidates[:1])}:
            print(visible(f"note: {bag}: values are invented (engine simulated)"), file=sys.stderr)
        evidence = of_study(study, study_table(study))
        if not evidence.arms:
            raise InputError("no complete trial", where=bag, expected="a study with at least one arm evaluated")
        found[n] = evidence
        counts.append(n)
    if counts == [7, 6]:
        raise InputError("is of 7 joints", where=bags[0], expected=f"the study of 6 joints first: {bags[1]} {bags[0]}")
    return Pair(found.get(6), found.get(7))


def _fair(files: list[str]) -> Pair | None:
    from mobo_core.atlas.file import read_atlas
    from mobo_core.report.claims.claim import Pair
    from mobo_core.report.claims.evidence import Evidence
    from mobo_core.report.claims.fair import of_atlas

    found: dict[int, Evidence] = {}
    for file in files:
        atlas = read_atlas(Path(file))
        try:
            evidence = of_atlas(atlas)
        except InputError as error:
            raise error.at(file) from None
        n = evidence.n_joints
        if n not in (6, 7) or n in found:
            what = f"of {n} joints" + (", as another one is" if n in found else "")
            raise InputError(what, where=file, expected="one atlas of 6 joints, one of 7, or both")
        found[n] = evidence
    return Pair(found.get(6), found.get(7)) if found else None


def _print(checked: list[Checked], *, parts: bool) -> None:
    from rich.console import Console

    from mobo_core.report.claims.show import claims_table, numbers_text
    from mobo_core.report.claims.verdict import INCONCLUSIVE, NOT_REPRODUCED, REPRODUCED

    console = Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=max(console.width, 160))
    console.print(claims_table(checked, parts=parts))
    if parts:
        for one in checked:
            for part in one.outcome.parts:
                if part.numbers:
                    print(f"{one.claim}  {part.name}: {numbers_text(part)}")
    verdicts = [one.outcome.verdict for one in checked]
    counts = [f"{verdicts.count(kind)} {kind}" for kind in (REPRODUCED, NOT_REPRODUCED, INCONCLUSIVE)]
    print(f"\n{len(checked)} claims: {', '.join(counts)}")
