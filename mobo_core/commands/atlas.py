"""``mobo atlas``: the front of every joint order, from bags; ``mobo atlas ask``: the arms of it that meet a wish."""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from mobo_core.commands.parsing import Verbs
from mobo_core.errors import InputError, visible

if TYPE_CHECKING:
    from mobo_core.atlas.ask import Wish
    from mobo_core.atlas.atlas import Atlas

_ASK = "ask"
_TOP = 10
# What belongs to ask alone: name -> what it is if not given.
_WISHES = {"order": None, "without": "", "reach_at_least": None, "max": None, "min": "", "near": "", "top": _TOP}


def add(verbs: Verbs) -> None:
    """Add the verb's parser."""
    parser = verbs.add_parser(
        "atlas",
        help="what every joint order can do, from bags; arms that meet a wish",
        usage="mobo atlas BAG… -o FILE.parquet\n       mobo atlas ask [FILE] [wishes] [--json] [-o FOLDER]",
        description="Collect from bags the front of every joint order, a row an arm: lengths, reach, torque, how many\n"
        "trials its order got, and what hypervolume as many again may be expected to add to it.\n"
        "Bags must agree in space, spec and objectives.\n\n"
        "`mobo atlas ask` prints the arms of an atlas (by default the one that mobo brings) that meet\n"
        "all wishes, by falling reach unless --min or --near says otherwise.",
        epilog="examples:\n"
        "  mobo atlas bags/demo_001 -o atlas.parquet\n"
        "  mobo atlas ask --order YPPYPY\n"
        "  mobo atlas ask --reach-at-least 45 --min torque\n"
        "  mobo atlas ask atlas.parquet --without R --max torque=400 --top 3 -o arms\n"
        "  mobo atlas ask --near 0.05,0.25,0.2,0.05,0,0.05 --json",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    words = parser.add_argument(
        "words", nargs="+", metavar="BAG", help="folders of bags, or .mcap files; or ask, and the file of an atlas"
    )
    words.completer = _complete  # type: ignore[attr-defined]
    parser.add_argument(
        "-o", "--output", metavar="PATH", help="the file to write, which ends in .parquet; of ask: a folder for URDFs"
    )
    parser.add_argument("--json", action="store_true", help="print as JSON")
    parser.add_argument(
        "--searched", action="store_true", help="exit code 1 if an order of use (a tenth of the voxels) got few trials"
    )
    ask = parser.add_argument_group("wishes")
    ask.add_argument("--order", action="append", metavar="ORDER", help="joint order, such as YPPYPY; may be repeated")
    ask.add_argument("--without", default="", metavar="LETTERS", help="joints that it must not have, such as R")
    ask.add_argument(
        "--reach-at-least", type=float, metavar="N", help="voxels that it must reach [a tenth of them]"
    )
    ask.add_argument(
        "--max", action="append", metavar="NAME=N", help="the most of a value, such as torque=400; may be repeated"
    )
    ask.add_argument("--min", default="", metavar="NAME", help="the value to have least of, such as torque")
    ask.add_argument("--near", default="", metavar="LENGTHS", help="m, comma-separated: the nearest lengths first")
    ask.add_argument("--top", type=int, default=_TOP, metavar="N", help=f"how many arms [{_TOP}]")
    parser.set_defaults(run=run)


def _complete(prefix: str, **_: object) -> Iterator[str]:
    from argcomplete.completers import FilesCompleter

    yield from FilesCompleter()(prefix)
    if _ASK.startswith(prefix):
        yield _ASK


def run(args: argparse.Namespace) -> int:
    """Make an atlas, or ask one."""
    if args.words[0] == _ASK:
        return _ask(args)
    for name, default in _WISHES.items():
        if getattr(args, name) != default:
            raise InputError(f"--{name.replace('_', '-')}", where="arguments", expected="mobo atlas ask [FILE] wishes")
    if args.output is None:
        raise InputError("no -o", where="arguments", expected="-o FILE.parquet")
    return _make([Path(bag) for bag in args.words], Path(args.output), as_json=args.json, searched=args.searched)


def _make(bags: Sequence[Path], output: Path, *, as_json: bool, searched: bool) -> int:
    from mobo_core.atlas.atlas import atlas_of
    from mobo_core.atlas.file import check_output, write_atlas
    from mobo_core.atlas.reading import read_trials
    from mobo_core.bag.files import bag_files
    from mobo_core.commands.reading import notice

    check_output(output)
    if output.is_dir():
        raise InputError("is a folder", where=str(output), expected="the path of a file")
    for bag in bags:
        bag_files(bag)  # better to miss one now than after the first
    with notice(f"reading {bags[0]}" + (f" and {len(bags) - 1} more" if bags[1:] else "")):
        sources, trials = read_trials(bags)
        atlas = atlas_of(trials, sources)
    for source in sources:
        for fault in source.faults:
            print(visible(fault), file=sys.stderr)
    if not len(atlas):
        raise InputError("no complete trial", where=str(bags[0]), expected="a study with at least one arm evaluated")
    write_atlas(output, atlas)
    if as_json:
        print(json.dumps(_summary(atlas) | {"file": str(output)}))
    else:
        print(_title(atlas))
        print(visible(f"{len(atlas)} arms on the fronts of {atlas.about.orders} orders: {output}"))
    return 1 if searched and _partial(atlas) else 0


def _ask(args: argparse.Namespace) -> int:
    from mobo_core.atlas.ask import answer
    from mobo_core.atlas.file import DEFAULT_JOINTS, packaged, read_atlas

    _, *files = args.words
    if len(files) > 1:
        raise InputError(f"{len(files)} files", where="arguments", expected="one atlas")
    if args.top < 1:
        raise InputError(str(args.top), where="--top", expected="1 or more")
    if args.searched:
        raise InputError("--searched", where="arguments", expected="mobo atlas BAG… -o FILE.parquet --searched")
    wish = _wish(args)
    n_joints = len(wish.orders[0]) if wish.orders else len(wish.near) or DEFAULT_JOINTS
    path = Path(files[0]) if files else packaged(n_joints) or packaged()
    if path is None:
        raise InputError("this mobo brings no atlas", where="arguments", expected="mobo atlas ask FILE")
    atlas = read_atlas(path)
    rows = answer(atlas, wish).tolist()[: args.top]
    if args.output is not None and rows:
        _write_urdfs(atlas, rows, Path(args.output))
    if args.json:
        print(json.dumps({"atlas": _summary(atlas), "arms": [_plain(atlas, row, wish) for row in rows]}))
    else:
        print(_title(atlas))
        if rows:
            _print(atlas, rows, wish)
        else:
            print("no arm of the atlas is so")
    return 0 if rows else 1


def _wish(args: argparse.Namespace) -> Wish:
    from mobo_core.atlas.ask import Wish
    from mobo_core.commands.numbers import numbers_of

    if args.reach_at_least is not None and not math.isfinite(args.reach_at_least):
        raise InputError(repr(args.reach_at_least), where="--reach-at-least", expected="a finite number of voxels")
    at_most: dict[str, float] = {}
    for text in args.max or ():
        name, found, value = text.partition("=")
        (most,) = numbers_of(value, "--max", 1) if found else (math.nan,)
        if not found:
            raise InputError(repr(text), where="--max", expected="a name and a number, such as torque=400")
        at_most[name] = min(most, at_most.get(name, most))
    return Wish(
        orders=[order.upper() for order in args.order or ()],
        without=args.without.upper(),
        reach_at_least=args.reach_at_least,
        at_most=at_most,
        least=args.min,
        near=numbers_of(args.near, "--near") if args.near else (),
    )


def _title(atlas: Atlas) -> str:
    about = atlas.about
    counts = atlas.trials_of_order.tolist() or [0]
    least, most = min(counts), max(counts)
    text = (
        f"atlas of {about.orders} orders, {about.trials:,} trials ({least:,} to {most:,} an order), "
        f"hypervolume {about.hypervolume:.4f}"
    )
    return text + (f"\n{short}" if (short := _partial(atlas)) else "")


def _partial(atlas: Atlas) -> str:
    from mobo_core.atlas.atlas import partial

    return partial(atlas)


def _summary(atlas: Atlas) -> dict[str, object]:
    about = atlas.about
    return {
        "orders": about.orders,
        "arms": len(atlas),
        "trials": about.trials,
        "hypervolume": about.hypervolume,
        "objectives": list(about.objectives),
        "voxels": about.n_voxels,
        "partial": _partial(atlas),
        "studies": list(about.studies),
    }


def _plain(atlas: Atlas, row: int, wish: Wish) -> dict[str, object]:
    from mobo_core.atlas.ask import distances

    values: dict[str, object] = {
        "joints": atlas.joints[row],
        "twin": atlas.twin[row],
        "lengths": atlas.lengths[row].tolist(),
        "base_height": float(atlas.base[row, 0]),
        "base_tilt": float(atlas.base[row, 1]),
        **{name: float(column[row]) for name, column in atlas.values.items()},
        "trials_of_order": int(atlas.trials_of_order[row]),
        "expected_gain": float(atlas.expected_gain[row]),
        "study": atlas.study[row],
        "trial": int(atlas.trial[row]),
    }
    return values | ({"distance": float(distances(atlas, wish.near)[row])} if wish.near else {})


def _print(atlas: Atlas, rows: Sequence[int], wish: Wish) -> None:
    from mobo_core.report.lengths import lengths_text

    further = [name for name in atlas.values if name not in ("reach", "torque")]
    head = ["joints", "twin", f"reach of {atlas.about.n_voxels}", "torque N m", *further, "trials", "to gain"]
    head += ["off m"] if wish.near else []
    lines = [[*head, "lengths m"]]
    for row in rows:
        one = _plain(atlas, row, wish)
        line = [atlas.joints[row], atlas.twin[row] or "-", f"{one['reach']:.2f}", f"{one['torque']:.1f}"]
        line += [f"{one[name]:.4g}" for name in further]
        line += [f"{one['trials_of_order']}", f"{one['expected_gain']:.4f}"]
        line += [f"{one['distance']:.4f}"] if wish.near else []
        lines.append([*line, lengths_text(atlas.lengths[row].tolist())])
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    for line in lines:
        cells = [text.ljust(width) if k < 2 or k == len(head) else text.rjust(width)
                 for k, (text, width) in enumerate(zip(line, widths, strict=True))]  # fmt: skip
        print("  ".join(cells).rstrip())


def _write_urdfs(atlas: Atlas, rows: Sequence[int], folder: Path) -> None:
    from mobo_core.commands.urdf_folder import write_urdfs
    from mobo_core.design import to_urdf

    space, width = atlas.space, len(str(len(rows)))
    urdfs = {
        f"{place:0{width}}_{atlas.joints[row]}.urdf": to_urdf(atlas.design(row), space)
        for place, row in enumerate(rows, start=1)
    }
    write_urdfs(folder, urdfs)
