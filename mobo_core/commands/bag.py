"""``mobo bag``: what a bag holds, mending one that was cut off, making it small, cutting it before a trial."""

from __future__ import annotations

import argparse
import json
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

from mobo_core.commands.parsing import Verbs
from mobo_core.commands.reading import lock_holder, notice, read_with_notice
from mobo_core.errors import InputError, StudyError, visible


def add(verbs: Verbs) -> None:
    """Add the verb's parser."""
    parser = verbs.add_parser(
        "bag",
        help="what a bag holds; mend, compact or cut it",
        description="Look into a bag, mend it, make it small, or cut it before a trial.",
        epilog="examples:\n  mobo bag info bags/demo_001\n  mobo bag recover bags/demo_001\n"
        "  mobo bag compact bags/demo_001\n  mobo bag cut bags/demo_001 --before 40",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    kinds = parser.add_subparsers(dest="kind", metavar="KIND", required=True)
    info = kinds.add_parser(
        "info",
        help="study, settings, files, counts, evaluators",
        description="Print what a bag holds. A damaged bag is read as far as it goes.",
        epilog="examples:\n  mobo bag info bags/demo_001\n  mobo bag info bags/demo_001 --json",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    info.add_argument("bag", metavar="BAG", help="folder of a bag, or an .mcap file")
    info.add_argument("--json", action="store_true", help="print everything as JSON")
    info.set_defaults(run=run_info)
    recover = kinds.add_parser(
        "recover",
        help="make a bag whole whose writer was killed",
        description="Give every file of a bag its proper end, with all of its whole messages, and write\n"
        "metadata.yaml anew. A file damaged in its middle is kept beside the mended one as NAME.mcap.damaged.",
        epilog="example:\n  mobo bag recover bags/demo_001",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    recover.add_argument("bag", metavar="BAG", help="folder of a bag, or an .mcap file")
    recover.set_defaults(run=run_recover)
    compact = kinds.add_parser(
        "compact",
        help="one smaller file with every message as it was",
        description="Write a bag anew as one file of large chunks, with every message and its time as it was, in\n"
        "some two thirds of the room. The new bag takes the place of the old one in one step: interrupted, or\n"
        "out of room, it leaves the old one as it was. It is resumed, verified and replayed like any other.",
        epilog="example:\n  mobo bag compact bags/demo_001",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    compact.add_argument("bag", metavar="BAG", help="folder of a bag that no optimizer writes to")
    compact.set_defaults(run=run_compact)
    cut = kinds.add_parser(
        "cut",
        help="keep what came before a trial; a resumed study asks anew from there",
        description="Keep of a bag what was recorded until the trial before N was told, and nothing of later trials:\n"
        "the remedy for answers that do not verify. The bag as it was is kept beside it, as BAG_uncut.",
        epilog="example:\n  mobo bag cut bags/demo_001 --before 40",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    cut.add_argument("bag", metavar="BAG", help="folder of a bag that no optimizer writes to")
    cut.add_argument("--before", type=int, metavar="N", required=True, help="first trial that goes")
    cut.set_defaults(run=run_cut)


def run_info(args: argparse.Namespace) -> int:
    """Print what a bag holds."""
    from mobo_core.bag.info import bag_info

    study = read_with_notice(args.bag)
    info = {**bag_info(study), "writer": lock_holder(study.path)}
    if args.json:
        print(json.dumps(info))
    else:
        _print(info)
    return 0


def _print(info: dict[str, Any]) -> None:
    from mobo_core.design import DesignSpace
    from mobo_core.evaluation.spec import EvaluationSpec
    from mobo_core.evaluation.wording import further_asked, poses_text

    settings, trials = info["settings"], info["trials"]
    space, asked = DesignSpace.of(settings["space"]), EvaluationSpec.of(settings["spec"])
    writer = info["writer"]
    started = min((file["first_ns"] for file in info["files"] if file["first_ns"] is not None), default=None)
    a_trial = f", {_size(info['bytes_per_trial'])} a trial" if info["bytes_per_trial"] else ""
    lines = [
        ("study", info["study"] + (f", being written to by {writer}" if writer else "")),
        ("space", f"{space.n_joints} joints of {space.letters}, {space.total_text} m, {space.lengths}"),
        ("spec", f"{poses_text(asked)}, "
                 f"{', '.join([f'{asked.ik_mode} IK, seed {asked.seed}', *further_asked(asked)])}"),
        ("sampler", f"{settings['sampler']}, seed {settings['seed']}, {settings['n_startup_trials']} start-up trials, "
                    f"{settings['in_flight']} in flight"),
        ("versions", _pairs(info["versions"])),
        ("started", _time(started)),
        ("recorded", f"{_duration(info['seconds'])} in {_count(info['sessions'], 'session')}"),
        ("trials", f"{trials['told']} told: {trials['complete']} complete, {trials['failed']} failed; "
                   f"{trials['open']} open"),
        ("answers", f"{info['answers']['recorded']} recorded, {info['answers']['used']} used; "
                    f"{_count(info['resent'], 'candidate')} sent again"),
        ("size", _size(info["bytes"]) + a_trial),
    ]  # fmt: skip
    if trials["told_twice"]:
        lines.append(("fault", "told twice: trial " + ", ".join(map(str, trials["told_twice"][:20]))))
    for name, text in lines:
        print(visible(f"{name:10}{text}"))
    print("files")
    for i, file in enumerate(info["files"]):
        running = writer and i + 1 == len(info["files"]) and file["state"] == "cut off"
        state = "being written" if running else file["state"]
        print(f"  {file['name']:30}  {file['messages']:>7} messages  {_size(file['bytes']):>9}  {state}")
    print("topics")
    for topic, count in info["topics"].items():
        print(visible(f"  {topic:30}  {count:>7}"))
    print("evaluators")
    for who in info["evaluators"]:
        words = [f"{who['share']:.0%} of the trials", f"{who['answers']} answers"]
        words += [_count(who["workers"], "worker")] if who["workers"] else []
        words += [str(who[key]) for key in ("engine", "host") if who[key]]
        words += [f"lost {_count(who['lost'], 'time')}"] if who["lost"] else []
        print(visible(f"  {who['name']:30}  {', '.join(words)}"))


def run_recover(args: argparse.Namespace) -> int:
    """Mend a bag and say what was mended."""
    from mobo_core.bag.files import METADATA_FILE, bag_files
    from mobo_core.bag.lock import BagLock
    from mobo_core.bag.recover import recover_bag

    path = Path(args.bag)
    files = bag_files(path)
    folder = path if path.is_dir() else path.parent
    try:
        lock = BagLock(folder, "mobo bag recover")
        try:
            with notice(f"mending {args.bag}"):
                mended = recover_bag(path)
        finally:
            lock.release()
    except OSError as error:
        raise StudyError(f"{path}: cannot be mended ({error.strerror or error})") from None
    for before, after in mended:
        kept = "" if before.cut_off else "; the damaged file is kept beside it"
        print(f"{before.path}: {before.fault or 'cut off'}; mended, {after.summary.n_messages} whole messages{kept}")
    if not mended:
        print(f"{path}: {_count(len(files), 'file')}, all whole")
    if path.is_dir():
        print(f"{path / METADATA_FILE}: written anew")
    return 0


def run_compact(args: argparse.Namespace) -> int:
    """Compact a bag and say what that saved."""
    from mobo_core.bag.compact import compact_bag
    from mobo_core.bag.files import bag_files
    from mobo_core.bag.lock import BagLock

    path = Path(args.bag)
    n_files = len(bag_files(path))
    try:
        lock = BagLock(path if path.is_dir() else path.parent, "mobo bag compact")
        try:
            with notice(f"compacting {args.bag}"):
                before, after = compact_bag(path)
        finally:
            lock.release()
    except OSError as error:
        raise StudyError(f"{path}: cannot be compacted ({error.strerror or error})") from None
    print(f"{path}: {_count(n_files, 'file')} of {_size(before)}, now one of {_size(after)}")
    return 0


def run_cut(args: argparse.Namespace) -> int:
    """Cut a bag and say where the whole one is."""
    from mobo_core.bag.cut import cut_bag
    from mobo_core.bag.files import bag_files
    from mobo_core.bag.lock import BagLock

    if args.before < 0:
        raise InputError(str(args.before), where="--before", expected="a whole number from 0 up")
    path = Path(args.bag)
    bag_files(path)
    try:
        lock = BagLock(path if path.is_dir() else path.parent, "mobo bag cut")
        try:
            with notice(f"cutting {args.bag}"):
                whole = cut_bag(path, args.before)
        finally:
            lock.release()
    except OSError as error:
        raise StudyError(f"{path}: cannot be cut ({error.strerror or error})") from None
    print(f"{path}: cut before trial {args.before}; as it was: {whole}")
    return 0


def _pairs(versions: object) -> str:
    if not isinstance(versions, dict):
        return str(versions)[:200]
    return ", ".join(f"{key} {value}" for key, value in versions.items())


def _count(n: int, what: str) -> str:
    return f"{n} {what}{'' if n == 1 else 's'}"


def _time(ns: int | None) -> str:
    return "never" if ns is None else datetime.fromtimestamp(ns / 1e9, UTC).strftime("%Y-%m-%d %H:%M:%S UTC")


def _duration(seconds: float) -> str:
    return f"{seconds:.1f} s" if seconds < 60 else str(timedelta(seconds=round(seconds)))


def _size(n: float) -> str:
    for unit in ("B", "kB", "MB"):
        if n < 1000:
            return f"{n:.0f} B" if unit == "B" else f"{n:.1f} {unit}"
        n /= 1000
    return f"{n:.1f} GB"
