"""``mobo evaluate``: one arm, given as a URDF file, as joints and lengths, or as a trial of a bag."""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from mobo_core.commands.arm_arguments import add_arm_arguments, arm_urdf, refuse_arm
from mobo_core.commands.parsing import Verbs
from mobo_core.commands.real_arm import add_file_arguments, read_file_argument, refuse_file_arguments
from mobo_core.commands.results import Recorded, print_read, print_result
from mobo_core.errors import InputError

if TYPE_CHECKING:
    from mobo_core.arms.read import ReadArm
    from mobo_core.bag.record import StudyRecord
    from mobo_core.evaluation.spec import EvaluationSpec


def add(verbs: Verbs) -> None:
    """Add the verb's parser."""
    parser = verbs.add_parser(
        "evaluate",
        help="reach and torque of one arm",
        description="Evaluate one arm: how many poses it reaches, and the gravity torque it takes, in all and of\n"
        "each joint. A trial of a bag is evaluated as recorded: its URDF, tip and spec, unless --spec is given.\n\n"
        "A robot's file, URDF or xacro, is taken as it is found: joints beside the way to the tip are held, frames\n"
        "without mass folded, meshes and boxes covered by capsules; what is assumed is said.",
        epilog="examples:\n"
        "  mobo evaluate --joints YPPYPY --lengths 0.05,0.25,0.2,0.05,0,0.05\n"
        "  mobo evaluate panda.urdf --tip panda_hand --spec paper_fine --json\n"
        "  mobo evaluate ur.urdf.xacro --xacro ur_type:=ur5e --package-dir ~/ws/src\n"
        "  mobo evaluate tiago.urdf --tip arm_tool_link --set torso_lift_joint=0.1 --srdf tiago.srdf\n"
        "  mobo evaluate ur5.urdf --poses grasps.csv\n"
        "  mobo evaluate bags/demo_001 --trial 46 --spec paper_fine",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("urdf_file", nargs="?", metavar="URDF_FILE|BAG", help="a robot's description, or a bag")
    parser.add_argument("--trial", type=int, metavar="N", help="trial of the bag")
    add_arm_arguments(parser)
    parser.add_argument("--spec", help="preset (paper, paper_fine, mobo) or YAML file [mobo; the trial's]")
    parser.add_argument(
        "--poses", metavar="FILE",
        help="tool poses in place of the spec's: YAML or CSV, x y z roll pitch yaw (m, rad) or x y z qx qy qz qw",
    )  # fmt: skip
    parser.add_argument("--ik", choices=["paper", "complete", "irteus"], help="inverse kinematics, over the spec's")
    parser.add_argument("--engine", choices=["kernel", "reference"], default="kernel", help="[kernel]")
    parser.add_argument("--threads", type=int, default=1, help="threads of the kernel [1]")
    parser.add_argument("--json", action="store_true", help="print everything as JSON")
    add_file_arguments(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Evaluate and print."""
    from mobo_core.commands.progress import bar
    from mobo_core.evaluation import with_ik
    from mobo_core.evaluation.advice import result_advice
    from mobo_core.evaluation.evaluate import evaluate
    from mobo_core.evaluation.pose_file import read_poses
    from mobo_core.evaluation.spec import with_poses

    if args.threads < 1:
        raise InputError(str(args.threads), where="--threads", expected="1 or more")
    asked = _asked(args)
    spec = with_ik(asked.spec, args.ik) if args.ik else asked.spec
    if args.poses:
        spec = with_poses(spec, read_poses(args.poses))
    with bar("evaluating", quiet=args.json) as progress:
        try:
            result = evaluate(
                asked.urdf, spec, tip=asked.tip, engine=args.engine, threads=args.threads,
                objectives=asked.objectives, joint_torques=True, progress=progress,
            )  # fmt: skip
        except InputError as error:
            raise error.at(asked.where) from None
    for remark in result_advice(result):
        print(f"note: {remark}", file=sys.stderr)
    recorded = None if asked.study is None else Recorded(asked.study, args.trial, result)
    if args.json:
        read = asked.read
        found = {} if read is None else {"collision": read.capsules.to_dict(), "notes": list(read.notes)}
        print(json.dumps(result.to_dict() | found | ({} if recorded is None else recorded.to_dict())))
        return 0
    print_result(result)
    if asked.read is not None:
        print_read(asked.read)
    if recorded is not None:
        print(recorded)
    return 0


@dataclass(frozen=True)
class _Asked:
    """What to evaluate, by what spec, and where it was named; ``study`` if a trial of one, ``read`` if a file."""

    urdf: str | bytes
    spec: EvaluationSpec
    where: str
    tip: str = ""
    objectives: tuple[str, ...] = ()
    study: StudyRecord | None = None
    read: ReadArm | None = None


def _asked(args: argparse.Namespace) -> _Asked:
    from mobo_core.evaluation import DEFAULT_PRESET, load_spec

    if args.trial is not None:
        return _asked_trial(args)
    # The reference engine has the inverse kinematics of `paper` alone.
    spec = load_spec(args.spec or ("paper" if args.engine == "reference" else DEFAULT_PRESET))
    if args.urdf_file is None:
        refuse_file_arguments(args, "joints and lengths")
        return _Asked(arm_urdf(args), spec, "arm", args.tip)
    refuse_arm(args, args.urdf_file)
    path = Path(args.urdf_file)
    if path.is_dir() or path.suffix == ".mcap":
        raise InputError("a bag without --trial", where=args.urdf_file, expected="BAG --trial N, or a URDF file")
    read = read_file_argument(args, args.urdf_file, quiet=args.json)
    return _Asked(read.urdf, spec, args.urdf_file, read.tip, read=read)


def _asked_trial(args: argparse.Namespace) -> _Asked:
    from mobo_core.commands.reading import candidate_argument, read_bag_argument
    from mobo_core.evaluation import load_spec
    from mobo_core.evaluation.spec_message import spec_from_message

    if args.urdf_file is None:
        raise InputError("--trial without a bag", where="arguments", expected="BAG --trial N")
    refuse_arm(args, args.urdf_file)
    refuse_file_arguments(args, "a trial of a bag")
    given = load_spec(args.spec) if args.spec else None  # before the bag, which may take long
    study = read_bag_argument(args.urdf_file)
    candidate = candidate_argument(study, args.trial)
    spec = given or spec_from_message(candidate.spec)
    where = f"{args.urdf_file}: trial {args.trial}"
    return _Asked(candidate.urdf, spec, where, args.tip or candidate.tip, study.settings.objectives, study)

