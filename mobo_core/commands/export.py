"""``mobo export``: arms as URDF, trials as a table, studies for other tools."""

from __future__ import annotations

import argparse
import hashlib
from pathlib import Path

from mobo_core.commands import export_optuna
from mobo_core.commands.arm_arguments import add_arm_arguments, arm_urdf, refuse_arm
from mobo_core.commands.parsing import Verbs
from mobo_core.commands.reading import candidate_argument, read_bag_argument
from mobo_core.errors import InputError
from mobo_core.version import __version__


def add(verbs: Verbs) -> None:
    """Add the verb's parser."""
    parser = verbs.add_parser(
        "export",
        help="arms as URDF, trials as a table or for Optuna, a notebook",
        description="Take arms, tables or all of a study out of its bag, for other tools.",
        epilog="examples:\n"
        "  mobo export urdf bags/demo_001 --top 3 -o arms\n"
        "  mobo export table bags/demo_001 -o trials.csv",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    kinds = parser.add_subparsers(dest="kind", metavar="KIND", required=True)
    _add_urdf(kinds)
    _add_table(kinds)
    export_optuna.add(kinds)


def _add_urdf(kinds: Verbs) -> None:
    parser = kinds.add_parser(
        "urdf",
        help="one arm, or the best of a bag",
        description="Write the URDF of one arm, or of one trial of a bag, into the file PATH, or those of the best\n"
        "arms of a bag into the folder PATH, byte for byte as they were evaluated, named\n"
        "RANK_JOINTS_trialNUMBER.urdf, with manifest.json, which says what each is and is worth.\n\n"
        "Best are the arms of the Pareto front that reach a tenth of the voxels or more, the highest\n"
        "reach first; after them the other arms, the highest reach first.",
        epilog="examples:\n"
        "  mobo export urdf --joints YPPYPY --lengths 0.05,0.25,0.2,0.05,0,0.05 -o arm.urdf\n"
        "  mobo export urdf bags/demo_001 --trial 46 -o arm.urdf\n"
        "  mobo export urdf bags/demo_001 --top 3 -o arms",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("bag", nargs="?", metavar="BAG", help="folder of a bag, or an .mcap file")
    parser.add_argument("--top", type=int, metavar="N", help="how many arms of the bag [1]")
    parser.add_argument("--trial", type=int, metavar="N", help="the arm of this trial of the bag, into a file")
    add_arm_arguments(parser)
    parser.add_argument("-o", "--output", required=True, metavar="PATH", help="file for one arm, folder for the best")
    parser.set_defaults(run=run_urdf)


def _add_table(kinds: Verbs) -> None:
    parser = kinds.add_parser(
        "table",
        help="all trials as CSV or Parquet",
        description="Write every trial told into FILE, a row each, failed ones with their reason; reach counts\n"
        "voxels, torque is in N m, lengths in m. Parquet needs pyarrow.\n\n"
        "With --best only the arms of the front above the reach floor and the arm of the highest reach\n"
        "of each joint order, the highest reach first. A new study that is given such a file as\n"
        "baselines tries its arms first.",
        epilog="examples:\n  mobo export table bags/demo_001 -o trials.csv\n"
        "  mobo export table bags/demo_001 -o trials.parquet\n"
        "  mobo export table bags/demo_001 --best -o best.csv",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("bag", metavar="BAG", help="folder of a bag, or an .mcap file")
    parser.add_argument("--best", action="store_true", help="the front, and the best arm of each joint order")
    parser.add_argument("-o", "--output", required=True, metavar="FILE", help="name ending in .csv or .parquet")
    parser.set_defaults(run=run_table)


def run_table(args: argparse.Namespace) -> int:
    """Write the table of a bag."""
    from mobo_core.report.best import best_of_orders
    from mobo_core.report.columns import table_columns
    from mobo_core.report.table import study_table
    from mobo_core.report.table_files import check_table_path, write_table

    path = Path(args.output)
    check_table_path(path)
    table = study_table(read_bag_argument(args.bag))
    rows = best_of_orders(table) if args.best else table.rows
    write_table(path, table_columns(rows, table.n_joints))
    best = f"{len(rows)} arms of " if args.best else ""
    print(f"{best}{len(table.rows)} trials, {len(table.failed)} of them failed: {path}")
    return 0


def run_urdf(args: argparse.Namespace) -> int:
    """Write one arm, or the best of a bag."""
    from mobo_core.outputs import write_whole

    path = Path(args.output)
    if args.bag is None:
        for name in ("top", "trial"):
            if getattr(args, name) is not None:
                raise InputError(f"--{name} without a bag", where="arguments", expected=f"BAG --{name} N")
        write_whole(path, arm_urdf(args))
        print(path)
        return 0
    refuse_arm(args, f"a bag ({args.bag})")
    if args.trial is not None:
        if args.top is not None:
            raise InputError("both --top and --trial", where="arguments", expected="one of them")
        return _export_trial(args.bag, args.trial, path)
    top = 1 if args.top is None else args.top
    if top < 1:
        raise InputError(str(top), where="--top", expected="1 or more")
    return _export_best(args.bag, top, path)


def _export_trial(bag: str, trial: int, path: Path) -> int:
    from mobo_core.outputs import write_whole

    candidate = candidate_argument(read_bag_argument(bag), trial)
    write_whole(path, candidate.urdf.encode("utf-8"))
    print(path)
    return 0


def _export_best(bag: str, top: int, folder: Path) -> int:
    from mobo_core.commands.urdf_folder import write_urdfs
    from mobo_core.report.best import best_rows, urdf_name
    from mobo_core.report.table import study_table

    study = read_bag_argument(bag)
    rows = best_rows(study, study_table(study), top)
    if not rows:
        raise InputError("no complete trial", where=bag, expected="a study with at least one arm evaluated")
    candidates = [study.candidate_of(row.trial) for row in rows]
    urdfs = {
        urdf_name(i + 1, row, len(rows)): str(candidate.urdf if candidate is not None else "")
        for i, (row, candidate) in enumerate(zip(rows, candidates, strict=True))
    }
    arms = [
        {
            "file": name,
            "sha256": hashlib.sha256(urdfs[name].encode("utf-8")).hexdigest(),
            "tip": candidate.tip if candidate is not None else "",
            "trial": row.trial,
            "joints": row.joints,
            "lengths": row.lengths,
            "reach": row.reach,
            "torque": row.torque,
            **dict(row.extra),
            "on_front": row.on_front,
        }
        for name, row, candidate in zip(urdfs, rows, candidates, strict=True)
    ]
    settings = {"study": study.name, "mobo_version": __version__, "spec": study.settings.spec.to_dict()}
    write_urdfs(folder, urdfs, {**settings, "arms": arms})
    for row, name in zip(rows, urdfs, strict=True):
        off = "" if row.on_front else ", off the front"
        print(f"{folder / name}  reach {row.reach:.2f}, torque {row.torque:.1f} N m{off}")
    if len(rows) < top:
        print(f"only {len(rows)} arms in the bag, not {top}")
    return 0
