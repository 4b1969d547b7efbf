"""An arm of a file on the command line: ``URDF --tip LINK --set joint=0.1 --package-dir FOLDER …``."""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from mobo_core.errors import InputError

if TYPE_CHECKING:
    from mobo_core.arms.read import ReadArm
    from mobo_core.arms.real import RealArm

_LEAST_HEIGHT = 1e-3  # m


def add_file_arguments(parser: argparse.ArgumentParser) -> None:
    """Add what says how a robot's file is to be read."""
    group = parser.add_argument_group("a robot's file")
    group.add_argument("--tip", default="", metavar="LINK", help="link that has to reach; guessed where it is plain")
    group.add_argument(
        "--set", action="append", default=[], metavar="JOINT=VALUE", dest="held",
        help="hold a joint there, rad (or 90deg) or m; those beside the way to the tip are held nearest zero",
    )  # fmt: skip
    group.add_argument(
        "--package-dir", action="append", default=[], metavar="FOLDER", dest="package_dirs",
        help="where package:// is looked for, beside the file's own folder and those above it",
    )  # fmt: skip
    group.add_argument("--srdf", default="", metavar="FILE", help="which links may touch (disable_collisions)")
    group.add_argument(
        "--pairs", choices=["rest", "adjacent"], default="rest",
        help="without --srdf, which links may touch: those that do with all joints nearest zero, or neighbours [rest]",
    )  # fmt: skip
    group.add_argument(
        "--slide-radius", type=float, default=None, metavar="M",
        help="m, of the pinion that drives a joint which slides: its force counts as torque at it [0.05]",
    )  # fmt: skip
    group.add_argument(
        "--xacro", action="append", default=[], metavar="NAME:=VALUE", help="argument of a xacro file"
    )  # fmt: skip


def read_file_argument(args: argparse.Namespace, path: str, *, quiet: bool = False, shapes: bool = True) -> ReadArm:
    """Read the arm of a file as the arguments say; say on standard error what was assumed.

    Raises:
        InputError: see :func:`mobo_core.arms.read.read_arm`.
    """
    from mobo_core.arms.read import read_arm
    from mobo_core.commands.progress import bar
    from mobo_core.evaluation.urdf import SLIDE_RADIUS

    radius = SLIDE_RADIUS if args.slide_radius is None else args.slide_radius
    if not 0 < radius <= 1e3:
        raise InputError(f"{radius:g}", where="--slide-radius", expected="m, above 0, at most 1000")
    held, xacro = held_joints(args.held), dict(_split(each, ":=", "--xacro") for each in args.xacro)
    with bar("fitting capsules", quiet=quiet) as progress:
        try:
            arm = read_arm(
                path, args.tip, held=held, package_dirs=args.package_dirs, srdf=args.srdf, pairs=args.pairs,
                slide_radius=radius, xacro=xacro, shapes=shapes, progress=progress,
            )  # fmt: skip
        except InputError as error:
            raise error.at(path) from None
    for note in arm.notes:
        print(f"note: {note}", file=sys.stderr)
    return arm


def is_file(arm: str) -> bool:
    """Return whether an argument is the path of a robot's file, and not a name of the catalogue."""
    path = Path(arm)
    return path.exists() or path.suffix.lower() in (".urdf", ".xacro", ".xml") or "/" in arm


def named_arm(args: argparse.Namespace, arm: str, *, quiet: bool = False) -> RealArm:
    """Return the arm that a file or a name of the catalogue gives, with its order.

    Raises:
        InputError: neither, or one that has no height.
    """
    from mobo_core.arms.catalogue import find_arm
    from mobo_core.commands.reading import notice

    if not is_file(arm):
        refuse_file_arguments(args, "an arm of the catalogue", tip=True)
        return find_arm(arm)
    from mobo_core.arms.straight import arm_of_chain, name_of_file
    from mobo_core.evaluation.chain import chain_from_urdf

    read = read_file_argument(args, arm, quiet=quiet, shapes=False)
    chain = chain_from_urdf(read.urdf, read.tip)
    with notice(f"straightening {arm}"):
        found = arm_of_chain(chain, name_of_file(arm), arm)
    if found.length < _LEAST_HEIGHT:
        what = f"{found.length:g} m high above its first joint, straightened"
        raise InputError(what, where=arm, expected="an arm that can be scaled by its height")
    return found


def refuse_file_arguments(args: argparse.Namespace, source: str, *, tip: bool = False) -> None:
    """Raise InputError if an argument of a robot's file (``tip``: or --tip) is given with ``source``, which is none."""
    given = {"--set": args.held, "--package-dir": args.package_dirs, "--srdf": args.srdf, "--xacro": args.xacro}
    given |= {"--pairs": args.pairs != "rest", "--slide-radius": args.slide_radius is not None}
    given |= {"--tip": tip and args.tip}
    for name, value in given.items():
        if value:
            raise InputError(f"{name} for {source}", where="arguments", expected=f"{name} with a robot's file alone")


def held_joints(texts: list[str]) -> dict[str, float]:
    """Return joint -> value of ``JOINT=VALUE``; degrees as ``90deg``."""
    held = {}
    for each in texts:
        name, value = _split(each, "=", "--set")
        degrees = value.endswith("deg")
        try:
            number = float(value.removesuffix("deg"))
        except ValueError:
            number = math.nan
        if not math.isfinite(number):
            raise InputError(repr(each), where="--set", expected="JOINT=VALUE, rad, m or such as 90deg")
        held[name] = math.radians(number) if degrees else number
    return held


def _split(text: str, mark: str, where: str) -> tuple[str, str]:
    name, found, value = text.partition(mark)
    if not name or not found:
        raise InputError(repr(text), where=where, expected=f"NAME{mark}VALUE")
    return name, value
