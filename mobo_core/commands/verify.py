"""``mobo verify``: whether a bag says the truth."""

from __future__ import annotations

import argparse
import os
import sys

from mobo_core.commands.parsing import Verbs
from mobo_core.commands.reading import read_with_notice
from mobo_core.errors import InputError
from mobo_core.verify.fault import Fault

_MOST_SHOWN = 20


def add(verbs: Verbs) -> None:
    """Add the verb's parser."""
    parser = verbs.add_parser(
        "verify",
        help="make a recorded study again and compare, to the bit",
        description="Check a bag: its files and the order of its messages, every URDF by xacro, every design by the\n"
        "sampler, every answer by the study's engine, every trial told once, from the answer that counted, and what\n"
        "was told as failed. Exit code 1 names trial and field of what differs.",
        epilog="examples:\n  mobo verify bags/first\n  mobo verify bags/first --sample 20",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("bag", metavar="BAG", help="folder of the bag")
    parser.add_argument("--sample", type=int, metavar="N", help="make N evaluations again, not all")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1, help="processes [cores]")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Verify and print what differs."""
    from mobo_core.commands.progress import bar
    from mobo_core.evaluation.kernel.load import kernel
    from mobo_core.verify.verify import verify

    for name, least in (("sample", 0), ("workers", 1)):
        value = getattr(args, name)
        if value is not None and value < least:
            raise InputError(str(value), where=f"--{name}", expected=f"a whole number from {least} up")
    study = read_with_notice(args.bag)
    kernel(study.settings.space.n_joints)  # before the workers: one compiles, not each
    with bar("verifying") as progress:
        found = verify(study, sample=args.sample, workers=args.workers, progress=progress)
    for fault in found.faults[:_MOST_SHOWN]:
        print(f"{args.bag}: {fault}", file=sys.stderr)
    if len(found.faults) > _MOST_SHOWN:
        print(f"{args.bag}: and {len(found.faults) - _MOST_SHOWN} more", file=sys.stderr)
    if remedy := _remedy(found.faults):
        command = f"mobo bag cut {args.bag} --before {remedy}"
        print(f"{args.bag}: {command} keeps what came before; resume asks anew from there", file=sys.stderr)
    if found.faults and found.other_versions:
        others = ", ".join(f"{name} {old} (here {new})" for name, (old, new) in found.other_versions.items())
        print(f"{args.bag}: recorded with {others}", file=sys.stderr)
    print(
        f"{'DIFFERS' if found.faults else 'good'}: {found.trials} trials told ({found.failed} failed), "
        f"{found.candidates} candidates, "
        f"{found.designs} designs asked again, {found.evaluations} evaluations made again"
    )
    for note in found.notes:
        print(note)
    return 1 if found.faults else 0


def _remedy(faults: list[Fault]) -> int | None:
    """Return the first trial at fault, if it is trials that are and not files."""
    trials = [fault.trial for fault in faults]
    return min(trials) if trials and min(trials) > 0 else None
