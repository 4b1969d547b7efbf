"""``mobo example``: settings as a file to start from, each field explained."""

from __future__ import annotations

import argparse

from mobo_core.commands.parsing import Verbs
from mobo_core.errors import InputError

KINDS = ("space", "spec")


def add(verbs: Verbs) -> None:
    """Add the verb's parser."""
    parser = verbs.add_parser(
        "example",
        help="a design space or a spec as a commented file",
        description="Print a design space (the arms of a study) or a spec (what is asked of an arm) as a YAML file\n"
        "in which each field is explained, with its unit and bounds.",
        epilog="examples:\n  mobo example space desk > space.yaml\n  mobo example spec --table",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("kind", choices=KINDS, help="space or spec")
    parser.add_argument("name", nargs="?", help="preset [paper for a space, mobo for a spec]")
    parser.add_argument("--table", action="store_true", help="print the fields and their defaults as a Markdown table")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Print the example."""
    from mobo_core.commands.fields import example, table
    from mobo_core.design import SPACES, load_space
    from mobo_core.evaluation import DEFAULT_PRESET, PRESETS, load_spec

    names = list(SPACES if args.kind == "space" else PRESETS)
    name = args.name or ("paper" if args.kind == "space" else DEFAULT_PRESET)
    if name not in names:
        raise InputError(f"no preset {name!r}", where=args.kind, expected=" or ".join(names))
    settings = load_space(name) if args.kind == "space" else load_spec(name)
    if args.table:
        print(table(type(settings)), end="")
        return 0
    use = f"{args.kind}:={args.kind}.yaml for a study, or --{args.kind} {args.kind}.yaml for mobo evaluate"
    print(f"# The {args.kind} called {name}, as a file: {use}.")
    print("# Fields that are left out keep their defaults.\n")
    print(example(settings), end="")
    return 0
