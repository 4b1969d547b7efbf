"""``mobo arms place``: where an arm stands in an atlas, and what small changes of it would do."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from mobo_core.commands.arm_values import place_dict
from mobo_core.commands.arms_place_text import print_changes, print_place
from mobo_core.commands.parsing import Verbs
from mobo_core.commands.real_arm import add_file_arguments, named_arm
from mobo_core.errors import InputError, visible

if TYPE_CHECKING:
    from mobo_core.arms.place import Place
    from mobo_core.arms.what_if import WhatIf
    from mobo_core.atlas.atlas import Atlas

_TOP = 20
_SUFFIXES = (".png", ".svg")


def add(kinds: Verbs) -> None:
    """Add the parser."""
    parser = kinds.add_parser(
        "place",
        help="where an arm stands in an atlas or a study, and what small changes of it would do",
        description="Say where an arm stands: its reach and torque scaled to the arms of an atlas (straightened as\n"
        "long, with their masses and radius, its own offsets and limits kept), how far it is from the\n"
        "front of all and from that of its own joint order, and what small changes would do.\n\n"
        "Gains are measured on other poses than the atlas's, four times as many; ± and [low, high] hold\n"
        "95 % of what drawing these poses anew gives, the same poses for both arms.",
        epilog="examples:\n"
        "  mobo arms place UR5e\n"
        "  mobo arms place my.urdf --tip tool0 --in bags/demo_001\n"
        "  mobo arms place Panda --in atlas.parquet --json\n"
        "  mobo arms place xArm6 -o xarm6.png --what-if none   # with the picture\n"
        "  mobo arms place Z1 --what-if own --by peak --top 10   # with its own size and masses",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("arm", metavar="ARM", help="a robot's file, or a name that `mobo arms list` prints")
    parser.add_argument("--in", dest="among", metavar="BAG|FILE.parquet", help="a study or an atlas [the one of mobo]")
    parser.add_argument(
        "--what-if", choices=["scaled", "own", "none"], default="scaled",
        help="which arm the table of changes is of: scaled, or with its own size and masses [scaled]",
    )  # fmt: skip
    parser.add_argument(
        "--by", choices=["both", "reach", "torque", "peak"], default="both",
        help="what helps most: %% reach less %% torque, or one, or the largest peak of a joint [both]",
    )  # fmt: skip
    parser.add_argument("--top", type=int, default=_TOP, metavar="N", help=f"how many changes to print [{_TOP}]")
    parser.add_argument(
        "-o", "--output", metavar="FILE", help="write the sampling picture with the arm in it, .png or .svg"
    )  # fmt: skip
    parser.add_argument("--json", action="store_true", help="everything, as JSON")
    add_file_arguments(parser)
    parser.set_defaults(run=run)


def _atlas(among: str | None, n_joints: int) -> tuple[Atlas, str]:
    from mobo_core.atlas.file import packaged, read_atlas

    if among is None:
        path = packaged(n_joints) or packaged()
        if path is None:
            raise InputError("mobo brings no atlas", where="--in", expected="a bag, or the file of an atlas")
        return read_atlas(path), "the atlas of mobo"
    path = Path(among)
    if path.suffix.lower() == ".parquet" and not path.is_dir():
        return read_atlas(path), among
    from mobo_core.atlas.atlas import atlas_of
    from mobo_core.atlas.reading import read_trials
    from mobo_core.commands.reading import notice

    with notice(f"reading {among}"):
        sources, trials = read_trials([path])
        atlas = atlas_of(trials, sources)
    for source in sources:
        for fault in source.faults:
            print(visible(fault), file=sys.stderr)
    return atlas, among


def run(args: argparse.Namespace) -> int:
    """Place an arm and print."""
    from mobo_core.arms.place import place
    from mobo_core.atlas.atlas import partial
    from mobo_core.commands.progress import bar
    from mobo_core.commands.reading import notice

    if args.top < 0:
        raise InputError(str(args.top), where="--top", expected="0 or more")
    suffix = Path(args.output).suffix.lower() if args.output else ""
    if args.output and suffix not in _SUFFIXES:
        raise InputError(f"suffix {suffix!r}", where="--output", expected="FILE.png or FILE.svg")
    arm = named_arm(args, args.arm, quiet=args.json)
    atlas, name = _atlas(args.among, arm.n)
    if not len(atlas):
        raise InputError("no complete trial", where=name, expected="a study with at least one arm evaluated")
    with bar("placing", quiet=args.json) as progress:
        found = place(arm, atlas, progress)
    if args.output:
        from mobo_core.outputs import write_whole
        from mobo_core.report.placing import place_picture

        with notice("drawing"):
            drawn = place_picture(found, atlas, name, "svg" if suffix == ".svg" else "png")
        write_whole(Path(args.output), drawn)
    changes = _changes(args, found, atlas)
    few = partial(atlas)
    if args.json:
        print(json.dumps(place_dict(found, atlas, name, few, args.what_if, changes)))
        return 0
    print_place(found, atlas, name, few)
    if changes is not None:
        print()
        print_changes(found.arm, changes, args.by, own=args.what_if == "own", top=args.top)
    return 0


def _changes(args: argparse.Namespace, found: Place, atlas: Atlas) -> list[WhatIf] | None:
    from mobo_core.arms.place import space_of
    from mobo_core.arms.resample import Resamples
    from mobo_core.arms.what_if import alterations, what_if
    from mobo_core.arms.worth import larger
    from mobo_core.commands.progress import bar
    from mobo_core.design.numbers import middle

    if args.what_if == "none":
        return None
    arm, total = found.arm, middle(atlas.space.total_length)
    if args.what_if == "own":
        resamples = Resamples(larger(found.resamples.spec, arm.length / total))
        base, changed = resamples.score(arm.urdf()), list(alterations(arm, None, None))
    else:
        resamples, base = found.resamples, found.score
        changed = list(alterations(arm, total, space_of(atlas.space, arm.n)))
    if base.reach == 0:
        print("note: the arm reaches no pose, so changes are not compared", file=sys.stderr)
        return None
    with bar("changing", quiet=args.json) as progress:
        return what_if(base, changed, resamples, progress, args.by)
