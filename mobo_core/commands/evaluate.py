"""``mobo evaluate``: one arm, given as a URDF file, as joints and lengths, or as a trial of a bag."""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from mobo_core.commands.arms import add_arm_arguments, arm_urdf, refuse_arm
from mobo_core.commands.parsing import Verbs
from mobo_core.commands.results import Recorded, print_result
from mobo_core.errors import InputError

if TYPE_CHECKING:
    from mobo_core.bag.record import StudyRecord
    from mobo_core.evaluation.spec import EvaluationSpec


def add(verbs: Verbs) -> None:
    """Add the verb's parser."""
    parser = verbs.add_parser(
        "evaluate",
        help="reach and torque of one arm",
        description="Evaluate one arm: how many poses it reaches, and the gravity torque it takes, in all and of\n"
        "each joint. A trial of a bag is evaluated as recorded: its URDF, tip and spec, unless --spec is given.",
        epilog="examples:\n"
        "  mobo evaluate --joints YPPYPY --lengths 0.05,0.25,0.2,0.05,0,0.05\n"
        "  mobo evaluate panda.urdf --tip panda_hand --spec paper_fine --json\n"
        "  mobo evaluate bags/demo_001 --trial 46 --spec paper_fine",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("urdf_file", nargs="?", metavar="URDF_FILE|BAG", help="a robot's description, or a bag")
    parser.add_argument("--trial", type=int, metavar="N", help="trial of the bag")
    parser.add_argument("--tip", default="", help="link that has to reach; by default the only leaf link")
    add_arm_arguments(parser)
    parser.add_argument("--spec", help="preset (paper, paper_fine, mobo) or YAML file [mobo; the trial's]")
    parser.add_argument("--ik", choices=["paper", "complete"], help="inverse kinematics, over the spec's")
    parser.add_argument("--engine", choices=["kernel", "reference"], default="kernel", help="[kernel]")
    parser.add_argument("--threads", type=int, default=1, help="threads of the kernel [1]")
    parser.add_argument("--json", action="store_true", help="print everything as JSON")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Evaluate and print."""
    from mobo_core.commands.progress import bar
    from mobo_core.evaluation import with_ik
    from mobo_core.evaluation.advice import result_advice
    from mobo_core.evaluation.evaluate import evaluate

    if args.threads < 1:
        raise InputError(str(args.threads), where="--threads", expected="1 or more")
    asked = _asked(args)
    spec = with_ik(asked.spec, args.ik) if args.ik else asked.spec
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
        print(json.dumps(result.to_dict() | ({} if recorded is None else recorded.to_dict())))
        return 0
    print_result(result)
    if recorded is not None:
        print(recorded)
    return 0


@dataclass(frozen=True)
class _Asked:
    """What to evaluate, by what spec, and where it was named; ``study`` if it is a trial of one."""

    urdf: str | bytes
    spec: EvaluationSpec
    where: str
    tip: str = ""
    objectives: tuple[str, ...] = ()
    study: StudyRecord | None = None


def _asked(args: argparse.Namespace) -> _Asked:
    from mobo_core.evaluation import DEFAULT_PRESET, load_spec

    if args.trial is not None:
        return _asked_trial(args)
    # The reference engine has the inverse kinematics of `paper` alone.
    spec = load_spec(args.spec or ("paper" if args.engine == "reference" else DEFAULT_PRESET))
    if args.urdf_file is None:
        return _Asked(arm_urdf(args), spec, "arm", args.tip)
    refuse_arm(args, args.urdf_file)
    path = Path(args.urdf_file)
    if path.is_dir() or path.suffix == ".mcap":
        raise InputError("a bag without --trial", where=args.urdf_file, expected="BAG --trial N, or a URDF file")
    return _Asked(_read(args.urdf_file), spec, args.urdf_file, args.tip)


def _asked_trial(args: argparse.Namespace) -> _Asked:
    from mobo_core.commands.reading import candidate_argument, read_bag_argument
    from mobo_core.evaluation import load_spec
    from mobo_core.evaluation.spec_message import spec_from_message

    if args.urdf_file is None:
        raise InputError("--trial without a bag", where="arguments", expected="BAG --trial N")
    refuse_arm(args, args.urdf_file)
    given = load_spec(args.spec) if args.spec else None  # before the bag, which may take long
    study = read_bag_argument(args.urdf_file)
    candidate = candidate_argument(study, args.trial)
    spec = given or spec_from_message(candidate.spec)
    where = f"{args.urdf_file}: trial {args.trial}"
    return _Asked(candidate.urdf, spec, where, args.tip or candidate.tip, study.settings.objectives, study)


def _read(path: str) -> bytes:
    from mobo_core.evaluation.urdf import MAX_BYTES

    try:
        with Path(path).open("rb") as file:
            return file.read(MAX_BYTES + 1)
    except OSError as error:
        raise InputError(error.strerror or str(error), where=path, expected="a URDF file") from None
