"""``mobo arms``: arms that exist, from a catalogue with sources or from files, and what they are worth."""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path

from mobo_core.commands import arms_place
from mobo_core.commands.arm_values import arm_dict
from mobo_core.commands.parsing import Verbs
from mobo_core.commands.real_arm import add_file_arguments, named_arm, refuse_file_arguments


def add(verbs: Verbs) -> None:
    """Add the verb's parser."""
    parser = verbs.add_parser(
        "arms",
        help="real arms: a catalogue with sources, what they are worth, where they stand",
        description="Real arms with joint axes, offsets and limits, each with its source; what none says is\n"
        "estimated, and marked so.",
        epilog="examples:\n"
        "  mobo arms list\n"
        "  mobo arms show UR5\n"
        "  mobo arms evaluate Panda 'xArm 6'\n"
        "  mobo arms evaluate -o build/arms        # all of them, with a page\n"
        "  mobo arms place my.urdf                 # where an arm stands in the atlas",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    kinds = parser.add_subparsers(dest="kind", metavar="KIND", required=True)
    _add_list(kinds)
    _add_show(kinds)
    _add_evaluate(kinds)
    arms_place.add(kinds)


def _add_list(kinds: Verbs) -> None:
    parser = kinds.add_parser(
        "list",
        help="all arms, a line each",
        description="List the arms: joint order in mobo's letters, length above the first joint, how far the\n"
        "straightened arm is off the vertical and its axes off right angles, whether its masses are known.",
        epilog="examples:\n  mobo arms list\n  mobo arms list --joints YPPYPY\n  mobo arms list --json",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--joints", default="", metavar="ORDER", help="those whose order begins so")
    parser.add_argument("--json", action="store_true", help="everything, as JSON")
    parser.set_defaults(run=run_list)


def _add_show(kinds: Verbs) -> None:
    parser = kinds.add_parser(
        "show",
        help="one arm: joints, limits, source; its URDF",
        description="Show an arm of the catalogue, or write it as URDF.",
        epilog="examples:\n  mobo arms show iiwa14\n  mobo arms show iiwa14 --urdf iiwa14.urdf",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("name", metavar="NAME", help="as `mobo arms list` prints it")
    parser.add_argument("--urdf", metavar="FILE", help="write it as URDF, with tubes between its joints")
    parser.add_argument("--json", action="store_true", help="as JSON")
    parser.set_defaults(run=run_show)


def _add_evaluate(kinds: Verbs) -> None:
    parser = kinds.add_parser(
        "evaluate",
        help="reach and torque of arms: as they are, scaled, and idealised",
        description="Evaluate arms three times: as they are (own), in a workspace as much larger as they are longer\n"
        "than an arm of the design space; scaled to its total length with its masses, offsets and limits\n"
        "kept (scaled); and the joint order with the ratio of lengths alone, in the design space (twin).\n\n"
        "A spec's floor and boxes grow with the workspace of the first (own); tool and payload do not,\n"
        "and with given poses nothing does: they, and what stands around them, are places in m.",
        epilog="examples:\n"
        "  mobo arms evaluate Panda --json\n"
        "  mobo arms evaluate my.urdf --tip tool0\n"
        "  mobo arms evaluate -o build/arms",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "names", nargs="*", metavar="ARM", help="names that `mobo arms list` prints, or robots' files [all names]"
    )  # fmt: skip
    parser.add_argument("--spec", help="preset (paper, paper_fine, mobo) or YAML file [mobo]")
    parser.add_argument("-o", "--output", metavar="DIR", help="write index.html, with all drawn, and arms.json")
    parser.add_argument("--json", action="store_true", help="print everything as JSON")
    add_file_arguments(parser)
    parser.set_defaults(run=run_evaluate)


def run_list(args: argparse.Namespace) -> int:
    """Print the catalogue."""
    from mobo_core.arms.catalogue import MISSING, catalogue

    arms = [arm for arm in catalogue() if arm.order and arm.order.joints.startswith(args.joints.upper())]
    if args.json:
        print(json.dumps({"arms": [arm_dict(arm) for arm in arms], "missing": list(MISSING)}))
        return 0
    print(f"{'arm':20} {'maker':18} {'joints':8} {'length':>7} {'off':>6} {'skew':>5}  masses")
    for arm in arms:
        assert arm.order is not None
        known = "estimated" if "masses" in arm.estimated else "source"
        skew = f"{math.degrees(arm.order.skew):4.0f}°"
        print(
            f"{arm.name:20} {arm.maker:18} {arm.order.joints:8} {arm.length:5.2f} m {1e3 * arm.order.offset:3.0f} mm "
            f"{skew:>5}  {known}"
        )
    print(f"{len(arms)} arms. Named by the paper, and in no source: {', '.join(MISSING)}.")
    return 0


def run_show(args: argparse.Namespace) -> int:
    """Print one arm, or write its URDF."""
    from mobo_core.arms.catalogue import find_arm
    from mobo_core.outputs import write_whole

    arm = find_arm(args.name)
    if args.urdf:
        write_whole(Path(args.urdf), arm.urdf())
        print(args.urdf)
        return 0
    if args.json:
        print(json.dumps(arm_dict(arm)))
        return 0
    order = arm.order
    assert order is not None
    print(f"arm      {arm.maker} {arm.name}" + (f", in the paper {arm.paper}" if arm.paper else ""))
    print(f"joints   {order.joints}, {arm.length:.3f} m above the first joint, straightened")
    print(f"lengths  {', '.join(f'{length:.3f}' for length in order.lengths)} m up, straightened")
    print(f"off      {order.offset:.3f} m off the vertical, axes {math.degrees(order.skew):.1f}° off right angles")
    for i, (joint, q) in enumerate(zip(arm.joints, order.q, strict=True), start=1):
        limits = f"{math.degrees(joint.lower):7.1f}° to {math.degrees(joint.upper):6.1f}°"
        print(f"joint {i}  {limits}, straightened at {math.degrees(q):6.1f}°")
    masses = "estimated" if arm.bodies is None else ", ".join(f"{mass:.2f}" for mass, _ in arm.bodies) + " kg"
    print(f"masses   {masses}")
    print(f"source   {', '.join(f'{name} {value}' for name, value in arm.source.items())}; {arm.licence}")
    return 0


def run_evaluate(args: argparse.Namespace) -> int:
    """Evaluate arms; print them, and write the page."""
    from mobo_core.arms.catalogue import MISSING, catalogue
    from mobo_core.arms.worth import worth
    from mobo_core.commands.progress import bar
    from mobo_core.evaluation import DEFAULT_PRESET, load_spec
    from mobo_core.outputs import make_folder, write_whole
    from mobo_core.report.page.gallery import gallery_page

    spec = load_spec(args.spec or DEFAULT_PRESET)
    if not args.names:
        refuse_file_arguments(args, "the catalogue", tip=True)
    arms = [named_arm(args, name, quiet=args.json) for name in args.names] or list(catalogue())
    if args.output:
        make_folder(Path(args.output))
    found = []
    with bar("evaluating arms", quiet=args.json) as progress:
        for i, arm in enumerate(arms):
            found.append((arm, worth(arm, spec)))
            progress(i + 1, len(arms))
    rows = [arm_dict(arm) | {"worth": each.to_dict()} for arm, each in found]
    text = json.dumps({"spec": spec.to_dict(), "arms": rows})
    if args.json:
        print(text)
    else:
        print(f"{'arm':20} {'joints':8} {'own':>12} {'scaled':>12} {'twin':>12}   reach / torque in N m")
        for arm, each in found:
            cells = " ".join(f"{result.reach:5.1f} /{result.torque:5.0f}" for result in vars(each).values())
            print(f"{arm.name:20} {arm.order.joints if arm.order else '':8} {cells}")
    if args.output:
        write_whole(Path(args.output) / "arms.json", text)
        page = Path(args.output) / "index.html"
        write_whole(page, gallery_page(found, spec.n_voxels, MISSING))
        if not args.json:
            print(f"{len(found)} arms: {page}")
    return 0
