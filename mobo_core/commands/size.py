"""``mobo size``: what an arm's joints have to hold with a payload, which motors do, and what payload that leaves."""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from mobo_core.commands.arm_arguments import add_arm_arguments, arm_design, refuse_arm
from mobo_core.commands.arm_values import sizing_dict
from mobo_core.commands.parsing import Verbs
from mobo_core.commands.real_arm import add_file_arguments, is_file, read_file_argument, refuse_file_arguments
from mobo_core.commands.size_text import print_map, print_sizing
from mobo_core.errors import InputError, visible

if TYPE_CHECKING:
    from mobo_core.evaluation.spec import EvaluationSpec

# Of a paper's arm: what the presets' workspaces are made for.
_USUAL_M = 0.6
_SUFFIXES = (".png", ".svg")


def add(verbs: Verbs) -> None:
    """Add the verb's parser."""
    parser = verbs.add_parser(
        "size",
        help="torque that each joint has to hold with a payload, motors that do, payload over the workspace",
        description="Say what the motors of an arm have to hold: the static torque of each joint over the reached\n"
        "poses (median, 95 %, peak, and where). With --motors, which motor each joint needs, and the\n"
        "largest payload that every joint holds over 99 % of the reached poses, in all and by voxel.\n\n"
        "Without --spec the workspace is around the first joint, and as much larger than the preset's as\n"
        "the arm, straightened, is longer than 0.6 m. The payload is a point at the tip.",
        epilog="examples:\n"
        "  mobo size my.urdf --tip tool0 --payload 1.0\n"
        "  mobo size ur5 --payload 5\n"
        "  mobo size --joints PRRYPY --lengths 0.05,0.2,0.2,0.1,0,0.05 --payload 0.5 --motors examples/motors.yaml\n"
        "  mobo size my.urdf --payload 1.0 --motors motors.yaml --use 0.5 -o payload.png",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("arm", nargs="?", metavar="ARM", help="a robot's file, or a name that `mobo arms list` prints")
    add_arm_arguments(parser)
    parser.add_argument("--payload", type=float, default=0.0, metavar="KG", help="at the tip [0]")
    parser.add_argument("--motors", metavar="FILE", help="YAML: motors with name, torque in N m, mass in kg, source")
    parser.add_argument(
        "--motor-mass", metavar="KG[,KG…]",
        help="what the description's motors weigh at the joints' origins, in place of which come those of --motors "
        "[the design space's; of a file or a name: its masses stay]",
    )  # fmt: skip
    parser.add_argument("--use", type=float, default=1.0, metavar="SHARE", help="of the motors' torques to use [1]")
    parser.add_argument("--spec", help="preset (paper, paper_fine, mobo) or YAML file, taken as it is [mobo, larger]")
    parser.add_argument("-o", "--output", metavar="FILE", help="write the map of the payload, .png or .svg")
    parser.add_argument("--json", action="store_true", help="print everything as JSON")
    add_file_arguments(parser)
    parser.set_defaults(run=run)


@dataclass(frozen=True)
class _Asked:
    """An arm, its tip, the question, where it was named, and the masses of its motors if they are known."""

    urdf: str
    tip: str
    spec: EvaluationSpec
    where: str
    own_motors: tuple[float, ...] | None


def run(args: argparse.Namespace) -> int:
    """Size and print."""
    from mobo_core.arms.motors import Motors
    from mobo_core.arms.size import size
    from mobo_core.commands.progress import bar
    from mobo_core.outputs import write_whole

    if not 0 <= args.payload <= 1e4:
        raise InputError(f"{args.payload}", where="--payload", expected="kg, 0 to 10000")
    if not 0 < args.use <= 10:
        raise InputError(f"{args.use}", where="--use", expected="a share, such as 0.5")
    suffix = Path(args.output).suffix.lower() if args.output else ""
    if args.output and (suffix not in _SUFFIXES or not args.motors):
        what = "a map without --motors" if suffix in _SUFFIXES else f"suffix {suffix!r}"
        raise InputError(what, where="--output", expected="--motors FILE -o FILE.png or FILE.svg")
    if args.motor_mass and not args.motors:
        raise InputError("--motor-mass without --motors", where="arguments", expected="--motors FILE")
    motors = Motors.from_yaml(args.motors) if args.motors else None
    asked = _asked(args)
    with bar("evaluating", quiet=args.json) as progress:
        try:
            found = size(
                asked.urdf, asked.spec, args.payload, tip=asked.tip, motors=motors,
                own_motors=asked.own_motors if motors else None, use=args.use, progress=progress,
            )  # fmt: skip
        except InputError as error:
            raise error.at(asked.where) from None
    if args.output:
        from mobo_core.report.payload import payload_picture

        title = f"{asked.where}: payload that all joints hold at all reached poses"
        drawn = payload_picture(found.voxel_payload, found.result.spec, title, "svg" if suffix == ".svg" else "png")
        write_whole(Path(args.output), drawn)
    if args.json:
        print(json.dumps(sizing_dict(found, args.use)))
        return 0
    print_sizing(found, asked.where, replaced=asked.own_motors is not None)
    if motors and args.output:
        print(visible(f"map: {args.output}"))
    elif motors:
        print_map(found)
    return 0


def _asked(args: argparse.Namespace) -> _Asked:
    from mobo_core.arms.catalogue import find_arm
    from mobo_core.arms.straight import arm_of_chain
    from mobo_core.commands.reading import notice
    from mobo_core.design import to_urdf
    from mobo_core.design.numbers import of_joint
    from mobo_core.evaluation.chain import chain_from_urdf

    given = _masses(args.motor_mass)
    if args.arm is None:
        refuse_file_arguments(args, "joints and lengths")
        design, space = arm_design(args)
        own = tuple(of_joint(space.motor_mass, i) for i in range(len(design.joints)))
        urdf = to_urdf(design, space)
        spec = _spec(args.spec, sum(design.lengths), urdf, args.tip)
        return _Asked(urdf, args.tip, spec, design.joints, _one_each(given, urdf, args.tip) or own)
    refuse_arm(args, args.arm)
    if is_file(args.arm):
        read = read_file_argument(args, args.arm, quiet=args.json)
        length = 0.0
        if args.spec is None:
            chain = chain_from_urdf(read.urdf, read.tip)
            with notice(f"straightening {args.arm}"):
                length = arm_of_chain(chain, "").length or chain.reach_radius
        spec = _spec(args.spec, length, read.urdf, read.tip)
        return _Asked(read.urdf, read.tip, spec, args.arm, _one_each(given, read.urdf, read.tip))
    refuse_file_arguments(args, "an arm of the catalogue")
    arm = find_arm(args.arm)
    if "masses" in arm.estimated:
        print(f"note: no source has the masses of {arm.name}; they are estimated", file=sys.stderr)
    urdf = arm.urdf()
    spec = _spec(args.spec, arm.length, urdf, args.tip)
    return _Asked(urdf, args.tip, spec, arm.name, _one_each(given, urdf, args.tip))


def _spec(named: str | None, length: float, urdf: str, tip: str) -> EvaluationSpec:
    """Return what is asked of an arm: as named, or around its first joint and as large as it is."""
    from mobo_core.arms.worth import larger
    from mobo_core.evaluation import DEFAULT_PRESET, load_spec
    from mobo_core.evaluation.chain import chain_from_urdf
    from mobo_core.evaluation.spec import EvaluationSpec

    if named is not None:
        return load_spec(named)
    spec = larger(load_spec(DEFAULT_PRESET), length / _USUAL_M)
    at = [round(float(v), 6) for v in chain_from_urdf(urdf, tip).placement_p[0]]
    ends = {
        name: tuple(a + v for a, v in zip(at, getattr(spec, name), strict=True))
        for name in ("workspace_min", "workspace_max")
    }
    return EvaluationSpec.of({**spec.to_dict(), **ends})


def _masses(text: str | None) -> tuple[float, ...]:
    from mobo_core.commands.numbers import numbers_of

    found = () if text is None else numbers_of(text, "--motor-mass")
    if any(mass < 0 for mass in found):
        raise InputError(repr(text), where="--motor-mass", expected="kg, 0 or more")
    return found


def _one_each(masses: tuple[float, ...], urdf: str, tip: str) -> tuple[float, ...] | None:
    from mobo_core.evaluation.chain import chain_from_urdf

    if not masses:
        return None
    n = chain_from_urdf(urdf, tip).n
    if len(masses) not in (1, n):
        raise InputError(f"{len(masses)} masses", where="--motor-mass", expected=f"one, or {n}")
    return masses * n if len(masses) == 1 else masses
