"""Which link of a robot is the one that has to reach, where nobody says."""

from __future__ import annotations

import re

from mobo_core.arms.robot import Robot
from mobo_core.errors import InputError

# What makers call the end of an arm, the plainest first.
_NAMES = (
    r"tcp$", r"tool0?$", r"tool_?frame$", r"(end_?effector|ee|eef|ee_link|link_eef|gripper_frame_link)$", r"flange$",
)  # fmt: skip


def find_tip(robot: Robot, tip: str) -> str:
    """Return ``tip`` if it is a link, or the one that is plainly meant if it is empty, with a note.

    Plainly meant is the only leaf; else, of those named like a tool (of all, if none is), the one that the most joints
    lead to, of those that no finger carries.

    Raises:
        InputError: no such link, or several are as likely.
    """
    leaves = robot.leaves()
    if tip:
        if tip not in robot.links:
            expected = f"a link of the URDF, such as {', '.join(sorted(leaves)[:6])}"
            raise InputError(f"no link {tip!r}", where="tip", expected=expected)
        return tip
    if len(leaves) == 1:
        return leaves[0]
    joints = {leaf: _turning(robot, leaf) for leaf in leaves}
    named = {leaf: rank for leaf in leaves for rank in [_rank(leaf)] if rank is not None and joints[leaf] > 0}
    likely = [leaf for leaf in named or leaves if joints[leaf] > 0]
    most = max((joints[leaf] for leaf in likely), default=0)
    likely = [leaf for leaf in likely if joints[leaf] == most]
    if named:
        plainest = min(named[leaf] for leaf in likely)
        likely = [leaf for leaf in likely if named[leaf] == plainest]
    if len(likely) == 1:
        robot.notes.append(f"tip {likely[0]!r}: a guess; --tip names another of {len(leaves)} leaf links")
        return likely[0]
    first = sorted(likely or leaves, key=lambda leaf: -joints[leaf])[:6]
    shown = ", ".join(f"{leaf} ({joints[leaf]})" for leaf in first)
    what = f"{len(leaves)} leaf links, among them, with the joints that lead there, {shown}"
    raise InputError(what, where="urdf", expected="a tip link to be named (--tip)")


def _rank(leaf: str) -> int | None:
    return next((i for i, name in enumerate(_NAMES) if re.search(name, leaf.lower())), None)


def _turning(robot: Robot, leaf: str) -> int:
    """Return how many joints lead to a leaf; -1 if one follows another, or the last one slides, as a finger does."""
    path = [joint for joint in robot.path(leaf) if joint.moves]
    if any(joint.leader for joint in path) or (path and path[-1].kind == "prismatic"):
        return -1
    return len(path)
