"""Arms on the command line: ``--joints YPPYPY --lengths 0.05,0.2,…``."""

from __future__ import annotations

import argparse
import sys

from mobo_core.design import SPACES, Design, DesignSpace, load_space, to_urdf
from mobo_core.design.joints import joint_letters, yaw_rule
from mobo_core.errors import InputError


def add_arm_arguments(parser: argparse.ArgumentParser) -> None:
    """Add --joints, --lengths, --total and --space."""
    parser.add_argument("--joints", help=f"joint order in {joint_letters()}, such as YPPYPY")
    parser.add_argument("--lengths", help="link lengths in m, comma-separated, one a joint")
    parser.add_argument("--total", type=float, help="m, what the lengths must add up to [the space's: 0.6]")
    parser.add_argument("--space", help=f"preset ({', '.join(SPACES)}) or YAML file: masses, radius, limits [paper]")


def design_space(args: argparse.Namespace, n_joints: int) -> DesignSpace:
    """Return the space that the arguments name, for so many joints."""
    over = {"n_joints": n_joints} | ({} if args.total is None else {"total_length": args.total})
    return load_space(args.space, over) if args.space else DesignSpace.of(over, where="space")


def parse_lengths(text: str) -> tuple[float, ...]:
    """Return the lengths, in m, that comma-separated numbers give.

    Raises:
        InputError: they are none.
    """
    try:
        return tuple(float(word) for word in text.split(","))
    except ValueError:
        raise InputError(repr(text), where="--lengths", expected="numbers in m, such as 0.1,0.2,0.3") from None


def arm_design(args: argparse.Namespace) -> tuple[Design, DesignSpace]:
    """Return the arm that --joints and --lengths describe.

    Raises:
        InputError: one is missing, or they do not fit.
    """
    if not args.joints or args.lengths is None:
        raise InputError("no arm given", where="arguments", expected="URDF_FILE, or --joints and --lengths")
    lengths = parse_lengths(args.lengths)
    joints = Design(args.joints.upper(), lengths).sampled_joints  # letters and lengths, before the space
    space = design_space(args, len(lengths))
    design = space.arm(joints, lengths)
    space.total_of(design)
    if design.joints != design.sampled_joints:
        rule = yaw_rule(design.sampled_joints)
        print(f"note: {design.sampled_joints} is built as {design.joints}: {rule}", file=sys.stderr)
    return design, space


def arm_urdf(args: argparse.Namespace) -> str:
    """Return the URDF of :func:`arm_design`."""
    return to_urdf(*arm_design(args))


def refuse_arm(args: argparse.Namespace, source: str) -> None:
    """Raise InputError if an argument of an arm is given beside ``source``, which has the arm already."""
    for name in ("joints", "lengths", "total", "space"):
        if getattr(args, name) is not None:
            expected = "one arm: a file, a bag, or --joints and --lengths"
            raise InputError(f"both {source} and --{name}", where="arguments", expected=expected)
