"""``mobo arms place``: where an arm stands in an atlas, and what small changes of it would do."""

from __future__ import annotations

import argparse
import json
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from mobo_core.commands.arm_values import arm_dict
from mobo_core.commands.parsing import Verbs
from mobo_core.commands.real_arm import add_file_arguments, named_arm
from mobo_core.errors import InputError, visible

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mobo_core.arms.place import Distance, Place, Rival
    from mobo_core.arms.resample import Interval
    from mobo_core.arms.what_if import WhatIf
    from mobo_core.atlas.atlas import Atlas

_TOP = 20
_ASKEW = math.radians(30)  # from here on an order says little of an arm


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
    parser.add_argument("--json", action="store_true", help="everything, as JSON")
    add_file_arguments(parser)
    parser.set_defaults(run=run)


def _atlas(among: str | None) -> tuple[Atlas, str]:
    from mobo_core.atlas.file import packaged, read_atlas

    if among is None:
        path = packaged()
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

    if args.top < 0:
        raise InputError(str(args.top), where="--top", expected="0 or more")
    atlas, name = _atlas(args.among)
    if not len(atlas):
        raise InputError("no complete trial", where=name, expected="a study with at least one arm evaluated")
    arm = named_arm(args, args.arm, quiet=args.json)
    with bar("placing", quiet=args.json) as progress:
        found = place(arm, atlas, progress)
    changes = _changes(args, found, atlas)
    few = partial(atlas)
    if args.json:
        print(json.dumps(_plain(found, atlas, name, few, args.what_if, changes)))
        return 0
    _print_place(found, atlas, name, few)
    if changes is not None:
        print()
        _print_changes(found, changes, args)
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


def _plain(
    found: Place, atlas: Atlas, name: str, few: str, which: str, changes: list[WhatIf] | None
) -> dict[str, object]:
    def distance(one: Distance) -> dict[str, object]:
        values: dict[str, object] = {"better": one.better}
        for key in ("more_reach", "less_torque"):
            rival: Rival | None = getattr(one, key)
            values[key] = None if rival is None else {
                "joints": rival.design.joints, "lengths": list(rival.design.lengths),
                "study": atlas.study[rival.row], "trial": int(atlas.trial[rival.row]),
                "reach": rival.reach.to_dict(), "torque": rival.torque.to_dict(),
                "moves": [{"m": by, "from": source, "to": sink} for by, source, sink in rival.moves],
            }  # fmt: skip
        return values

    def point(result: object) -> dict[str, float]:
        return {key: getattr(result, key) for key in ("reach", "torque")}

    return {
        "arm": arm_dict(found.arm), "evaluation": "scaled", "in": name, "partial": few, "spec": atlas.spec.to_dict(),
        "voxels": atlas.about.n_voxels, "scaled": point(found.scaled),
        "twin": None if found.twin is None else point(found.twin),
        "gains_spec": found.resamples.spec.to_dict(), "front_of_all": distance(found.of_all),
        "front_of_order": None if found.of_order is None else distance(found.of_order),
        "trials_of_order": found.trials_of_order,
        "what_if": None if changes is None else {"of": which, "changes": [change.to_dict() for change in changes]},
    }  # fmt: skip


def percent(share: Interval) -> str:
    """Return a share as ``12 % ± 2``; what may be nothing is said to be."""
    value, half = 100 * share.value, 100 * share.half
    digits = 0 if half >= 0.95 else 1
    return f"{abs(value):.{digits}f} % ± {half:.{digits}f}" + ("" if share.sure else " (within chance)")


def _in_words(rival: Rival, wanted: str, atlas: Atlas) -> str:
    """Return what a rival does better, then what else differs, then which arm it is."""
    from mobo_core.report.lengths import lengths_text

    reach = f"{percent(rival.reach)} {'more' if rival.reach.value >= 0 else 'less'} reach"
    torque = f"{percent(rival.torque)} {'more' if rival.torque.value > 0 else 'less'} torque"
    first, second = (reach, torque) if wanted == "reach" else (torque, reach)
    which = f"{rival.design.joints} {lengths_text(rival.design.lengths).replace(',', '/')}"
    how = ""
    if rival.moves:
        moves = [f"{1e3 * by:.0f} mm from link {source} to link {sink}" for by, source, sink in rival.moves]
        how = f", its lengths with {', '.join(moves)}"
    return f"{first}, and {second}, with {which}{how} (trial {int(atlas.trial[rival.row])})"


def _print_place(found: Place, atlas: Atlas, name: str, few: str) -> None:
    from mobo_core.report.lengths import lengths_text

    arm, voxels = found.arm, atlas.about.n_voxels
    assert arm.order is not None
    total = sum(atlas.lengths[0])
    print(
        f"{visible(arm.name)}, {arm.order.joints}, scaled: straightened {total:g} m high above its first joint, with "
        "the masses\nand radius of the atlas's arms, its own offsets and limits"
    )
    print(f"  reach {found.scaled.reach:.2f} of {voxels}, torque {found.scaled.torque:.1f} N m")
    if found.twin is not None:
        lengths = lengths_text(arm.order.twin(total)).replace(",", "/")
        print(
            f"its twin, order and lengths alone ({lengths}, limits of the space)\n"
            f"  reach {found.twin.reach:.2f}, torque {found.twin.torque:.1f} N m"
        )
    print(visible(f"front of all, in {name}: {atlas.about.trials:,} trials, {atlas.about.orders} orders"))
    if few:
        print(f"  {few}")
    _print_distance(found.of_all, atlas, "arm")
    if found.of_order is None:
        n = atlas.lengths.shape[1]
        slide = " that turn" if "S" in arm.order.joints and arm.n == n else ""
        print(f"its own order {arm.order.joints}: none in the atlas, whose arms have {n} joints{slide}")
        return
    print(f"front of its own order {arm.order.joints}: {found.trials_of_order:,} trials")
    _print_distance(found.of_order, atlas, f"{arm.order.joints} arm")


def _print_distance(distance: Distance, atlas: Atlas, what: str) -> None:
    if distance.better:
        print(f"  better in both: {distance.better} of its arms")
    if distance.more_reach is None:
        print(f"  no {what} of it reaches more for the same torque")
    else:
        print(f"  for the same torque, {_in_words(distance.more_reach, 'reach', atlas)}")
    if distance.less_torque is None:
        print(f"  no {what} of it takes less torque for the same reach")
    elif distance.more_reach is None or distance.less_torque.row != distance.more_reach.row:
        print(f"  for the same reach, {_in_words(distance.less_torque, 'torque', atlas)}")


def _signed(one: Interval, digits: int) -> str:
    if max(abs(one.value), one.half) < 0.5 * 10**-digits:
        return "0"
    return f"{one.value:+.{digits}f} ±{one.half:.{digits}f}"


def _print_changes(found: Place, changes: Sequence[WhatIf], args: argparse.Namespace) -> None:
    sense = {
        "both": "% more reach less % more torque", "reach": "reach", "torque": "torque", "peak": "largest peak",
    }  # fmt: skip
    what = "scaled" if args.what_if == "scaled" else "with its own size and masses"
    print(f"what if, {what}; by {sense[args.by]}; ± of 95 %")
    sliding = [str(i) for i, joint in enumerate(found.arm.joints, start=1) if joint.slides]
    if sliding:
        print(f"joints that slide ({', '.join(sliding)}): N m of their force at a pinion, docs/settings.md")
    joints = "".join(f"{f'peak {i + 1}':>12}" for i in range(found.arm.n))
    print(f"{'change':34}{'reach':>14}{'torque N m':>16}{joints}")
    for change in changes[: args.top]:
        peaks = "".join(f"{_signed(peak, 2):>12}" for peak in change.peaks)
        print(f"{change.change:34}{_signed(change.reach, 2):>14}{_signed(change.torque, 1):>16}{peaks}")
    if len(changes) > args.top:
        print(f"{len(changes) - args.top} more with --top {len(changes)}, or --json")
