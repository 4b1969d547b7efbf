"""``mobo bench evaluate``: how fast and how complete the evaluation of some arms is."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING

from mobo_core.commands.bench_tables import print_groups, print_rows
from mobo_core.commands.parsing import Verbs
from mobo_core.errors import InputError

if TYPE_CHECKING:
    from mobo_core.bench.groups import Arm
    from mobo_core.design import Design
    from mobo_core.evaluation.spec import EvaluationSpec


def add(benches: Verbs) -> None:
    """Add the bench's parser."""
    parser = benches.add_parser(
        "evaluate",
        help="speed and completeness of the evaluation, over groups of arms",
        description="Measure the evaluation of groups of arms, single-threaded, in CPU time, after warm-up: time a\n"
        "candidate, speed against the reference engine on the same poses, and recall: the share that it finds of\n"
        "what it or an exhaustive search finds (blind attempts of 100 iterations; kept in the cache folder).\n\n"
        "groups:\n"
        "  visited6, visited7  32 arms each, drawn uniformly over the trials of a study of 20,000 (tpe, spec paper)\n"
        "  picked              13 arms of known structures, most of whose poses succeed at once\n"
        "  random              40 arms of any order and lengths, at 135 and 270 degrees (see mobo bench designs)",
        epilog="examples:\n"
        "  mobo bench evaluate\n"
        "  mobo bench evaluate --ik paper --ik complete --attempts 0   # the first against the second\n"
        "  mobo bench evaluate --group random --rows --reference-poses 0\n"
        "  mobo bench evaluate --from bags/first --sample 16 --torque\n"
        "  mobo bench evaluate --json --design YPPYPY:0.05,0.25,0.2,0.05,0,0.05",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--group", action="append", metavar="NAME|FILE", default=[],
                        help="a group, or a file of mobo bench designs; may be repeated "
                        "[visited6, visited7 and picked]")  # fmt: skip
    parser.add_argument("--design", action="append", metavar="NAME:l1,l2,…", default=[],
                        help="an arm, of the group given; may be repeated")  # fmt: skip
    parser.add_argument("--from", dest="bag", metavar="BAG", help="a study, arms of which make the group sampled")
    parser.add_argument("--sample", type=int, metavar="N", help="arms of it, drawn uniformly over its trials [32]")
    parser.add_argument("--seed", type=int, default=0, help="of that draw [0]")
    parser.add_argument("--spec", action="append", metavar="SPEC", default=[],
                        help="preset or YAML file; if repeated, they take turns and all are compared with the first "
                        "[mobo]")  # fmt: skip
    parser.add_argument("--ik", action="append", choices=["paper", "complete"], default=[],
                        help="inverse kinematics, over the specs'; may be repeated likewise")  # fmt: skip
    parser.add_argument("--attempts", type=int, default=200, help="of the exhaustive search; 0: leave it out [200]")
    parser.add_argument("--reference-poses", type=int, default=2, metavar="N",
                        help="poses a voxel to compare the reference engine on; 0: leave it out [2]")  # fmt: skip
    parser.add_argument("--torque", action="store_true",
                        help="compare the torques with those of blind restarts, the mean of 8 start seeds")  # fmt: skip
    parser.add_argument("--rows", action="store_true", help="print a row an arm, too")
    parser.add_argument("--json", action="store_true", help="print JSON, with all of it")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Measure and print."""
    from mobo_core.bench.evaluation import Wanted, bench_evaluate
    from mobo_core.commands.progress import bar

    specs = _specs(args)
    most = min(spec.poses_per_voxel for spec in specs.values())
    if not 0 <= args.attempts <= 1001:
        raise InputError(str(args.attempts), where="--attempts", expected="0 to 1001")
    if not 0 <= args.reference_poses <= most:
        raise InputError(str(args.reference_poses), where="--reference-poses", expected=f"0 to the spec's {most}")
    arms = _arms(args)
    with bar("measuring") as progress:
        found = bench_evaluate(arms, specs, Wanted(args.attempts, args.reference_poses, args.torque), progress)
    if args.json:
        first, *others = found
        print(json.dumps({**first, "others": others}))
        return 0
    if args.rows:
        for bench in found:
            print_rows(bench)
    print_groups(found)
    return 0


def _specs(args: argparse.Namespace) -> dict[str, EvaluationSpec]:
    from mobo_core.evaluation import load_spec, with_ik

    specs: dict[str, EvaluationSpec] = {}
    for given in args.spec or ["mobo"]:
        spec, name = load_spec(given), Path(given).stem
        name = given if any(label.split()[0] == name for label in specs) else name
        specs |= {f"{name} {ik}": with_ik(spec, ik) for ik in args.ik} if args.ik else {name: spec}
    return specs


def _arms(args: argparse.Namespace) -> list[Arm]:
    from mobo_core.bench.groups import DEFAULT_GROUPS, Arm, arms_of, arms_of_group, sample_of_study
    from mobo_core.commands.reading import read_lean_argument

    if args.sample is not None and not args.bag:
        raise InputError("without a bag", where="--sample", expected="--from BAG")
    given = [_design(text) for text in args.design]
    groups = args.group if args.group or given or args.bag else DEFAULT_GROUPS
    arms = [arm for name in dict.fromkeys(groups) for arm in arms_of_group(name)]
    if args.bag:
        study = read_lean_argument(args.bag)
        sample = 32 if args.sample is None else args.sample
        arms += arms_of("sampled", sample_of_study(study, sample, args.seed))
    return arms + [Arm.of("given", design) for design in given]


def _design(text: str) -> Design:
    from mobo_core.design import Design

    name, _, lengths = text.partition(":")
    try:
        numbers = tuple(float(word) for word in lengths.split(","))
    except ValueError:
        raise InputError(repr(text), where="--design", expected="NAME:l1,l2,… such as RPY:0.2,0.2,0.2") from None
    return Design(name, numbers)
