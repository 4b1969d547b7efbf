"""``mobo evaluate``: one arm, given as a URDF file or as joints and lengths."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from mobo_core.commands.arms import add_arm_arguments, arm_urdf
from mobo_core.commands.parsing import Verbs
from mobo_core.errors import InputError


def add(verbs: Verbs) -> None:
    """Add the verb's parser."""
    parser = verbs.add_parser(
        "evaluate",
        help="reach and torque of one arm",
        description="Evaluate one arm: how many poses it reaches, and the gravity torque it takes.",
        epilog="examples:\n"
        "  mobo evaluate --joints YPPYPY --lengths 0.05,0.25,0.2,0.05,0,0.05\n"
        "  mobo evaluate panda.urdf --tip panda_hand --spec paper_fine --json",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("urdf_file", nargs="?", metavar="URDF_FILE", help="a robot's description")
    parser.add_argument("--tip", default="", help="link that has to reach; by default the only leaf link")
    add_arm_arguments(parser)
    parser.add_argument("--spec", default="paper", help="preset (paper, paper_fine, mobo) or YAML file [paper]")
    parser.add_argument("--ik", choices=["paper", "complete"], help="inverse kinematics, over the spec's")
    parser.add_argument("--engine", choices=["kernel", "reference"], default="kernel", help="[kernel]")
    parser.add_argument("--threads", type=int, default=1, help="threads of the kernel [1]")
    parser.add_argument("--json", action="store_true", help="print everything as JSON")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Evaluate and print."""
    from mobo_core.commands.progress import bar
    from mobo_core.evaluation import load_spec, with_ik
    from mobo_core.evaluation.evaluate import evaluate

    if args.threads < 1:
        raise InputError(str(args.threads), where="--threads", expected="1 or more")
    spec = load_spec(args.spec)
    if args.ik:
        spec = with_ik(spec, args.ik)
    if args.urdf_file and args.joints:
        raise InputError("both URDF_FILE and --joints", where="arguments", expected="one of them")
    urdf = _read(args.urdf_file) if args.urdf_file else arm_urdf(args)
    where = args.urdf_file or "arm"
    with bar("evaluating", quiet=args.json) as progress:
        try:
            result = evaluate(
                urdf, spec, tip=args.tip, engine=args.engine, threads=args.threads, progress=progress
            )
        except InputError as error:
            raise error.at(where) from None
    if args.json:
        print(json.dumps(result.to_dict()))
        return 0
    failures = ", ".join(f"{count} {name.replace('_', ' ')}" for name, count in result.failures().items())
    n = spec.n_voxels * spec.poses_per_voxel
    print(f"reach   {result.reach:.2f} of {spec.n_voxels} voxels ({result.reach / spec.n_voxels:.1%} of {n} poses)")
    print(f"torque  {result.torque:.1f} N m, summed over the voxels' means")
    print(f"failed  {failures}")
    print(f"effort  {result.attempts} attempts, {result.iterations} iterations, {result.seconds:.2f} s")
    print(f"chain   {', '.join(result.joints)} to {result.tip}")
    if result.ignored_shapes:
        print(f"note    {result.ignored_shapes} collision shapes left out: only cylinders and spheres count")
    return 0


def _read(path: str) -> bytes:
    from mobo_core.evaluation.urdf import MAX_BYTES

    try:
        with Path(path).open("rb") as file:
            return file.read(MAX_BYTES + 1)
    except OSError as error:
        raise InputError(error.strerror or str(error), where=path, expected="a URDF file") from None
