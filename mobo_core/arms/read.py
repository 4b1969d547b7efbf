"""An arm from its file as it is found, made into the plain URDF that is evaluated and sent.

The plain URDF holds the links on the way to the tip and the joints between them, as they were, to the bit. All that
hangs on a link beside the way is part of it: its mass, and its collision shapes as capsules (cylinders that evaluations
take with half balls beyond their ends). So no evaluator ever reads a mesh.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

from mobo_core.arms.collision import Capsules, Fitted, fit_links
from mobo_core.arms.held import held_at, homes_of
from mobo_core.arms.packages import Packages, read_description
from mobo_core.arms.plain_urdf import plain_urdf
from mobo_core.arms.rigid import Placement
from mobo_core.arms.robot import Joint, Robot, read_robot
from mobo_core.arms.srdf import Pairs, read_srdf
from mobo_core.arms.tips import find_tip
from mobo_core.errors import InputError
from mobo_core.evaluation.capsules import listed_pairs
from mobo_core.evaluation.chain import chain_from_urdf, rest_pairs
from mobo_core.evaluation.urdf import SLIDE_RADIUS, check_urdf
from mobo_core.evaluation.urdf_xml import parse

PairRule = Literal["rest", "adjacent"]


@dataclass(frozen=True)
class ReadArm:
    """An arm made plain.

    Attributes:
        urdf: what is evaluated.
        tip: link that has to reach.
        notes: what was assumed or guessed, a line each.
        held: joints beside the way, or on it but set, and where they are held (rad or m).
        fitted: link -> its capsules.
    """

    urdf: str
    tip: str
    notes: tuple[str, ...] = ()
    held: Mapping[str, float] = field(default_factory=dict)
    fitted: Mapping[str, Fitted] = field(default_factory=dict)

    @property
    def capsules(self) -> Capsules:
        """How many capsules there are, and how much larger than the shapes they stand for."""
        return Capsules.of(self.fitted)


def read_arm(
    path: str | Path,
    tip: str = "",
    *,
    held: Mapping[str, float] | None = None,
    package_dirs: Sequence[str] = (),
    srdf: str = "",
    pairs: PairRule = "rest",
    slide_radius: float = SLIDE_RADIUS,
    xacro: Mapping[str, str] | None = None,
    shapes: bool = True,
    progress: Callable[[int, int], None] | None = None,
) -> ReadArm:
    """Read an arm from a URDF or xacro file.

    Args:
        path: the file.
        tip: link that has to reach; where it is plain which one, it need not be named.
        held: joints and where to hold them, rad or m; others beside the way to the tip are held nearest zero within
            their limits, mimic joints where their leader takes them. One on the way that is set does not move.
        package_dirs: folders with packages, beyond the file's own folder and those above it.
        srdf: file that says which links may touch.
        pairs: without it, which pairs of links may touch: those that do with all joints nearest zero (``rest``), or
            neighbours (``adjacent``).
        slide_radius: m, of the pinion that drives a joint which slides, where the file does not say: by it forces
            count as torques.
        xacro: arguments of a xacro file.
        shapes: whether collision shapes are wanted; without them no mesh is read.
        progress: called with (links done, links in all) while capsules are fitted.

    Raises:
        InputError: the file, or one that it names, is missing or no good; no such tip or joint, or several as likely.
    """
    packages = Packages(Path(path), package_dirs)
    robot = read_robot(parse(read_description(str(path), packages, xacro or {})))
    found = find_tip(robot, tip)
    way = robot.path(found)
    at = held_at(robot, way, held or {})
    moving = [joint for joint in way if joint.moves and joint.name not in at]
    _check_way(robot, found, moving)
    for joint in moving:
        if joint.kind == "prismatic" and joint.slide is None:
            robot.joints[joint.child] = replace(joint, slide=slide_radius)
            what = f"its force counts as torque at a pinion of {slide_radius:g} m"
            robot.notes.append(f"joint {joint.name!r} slides: {what}")
    way = robot.path(found)
    homes = homes_of(robot, [robot.root, *(joint.child for joint in way)], at)
    fitted = fit_links(robot, [link for link in robot.links if link in homes] if shapes else [], packages, progress)
    apart = None
    if srdf:
        apart = read_srdf(srdf, robot.links)
    elif pairs == "adjacent":
        apart = _neighbours(way, at, homes, list(fitted))
    urdf = plain_urdf(robot, way, at, homes, fitted, apart)
    if apart is not None:
        touching = sorted(" and ".join(sorted(pair)) for pair in _touching(urdf, found))
        if touching:
            what = "with all joints nearest zero, links that must not touch do"
            robot.notes.append(f"{what}: {', '.join(touching[:4])}")
    elif any(each.fitted for each in fitted.values()):
        # By whole links: several capsules of one are no finer than its neighbours' fit.
        urdf = plain_urdf(robot, way, at, homes, fitted, _touching(urdf, found))
    return ReadArm(urdf, found, tuple(robot.notes), at, fitted)


def _touching(urdf: str, tip: str) -> Pairs:
    """Return the links, of those that may collide, that touch with all joints nearest zero."""
    chain, checked = chain_from_urdf(urdf, tip), check_urdf(urdf)
    apart = {(int(i), int(j)) for i, j in rest_pairs(chain)}
    names = [shape.name for shape in checked.shapes]
    looked_at = listed_pairs(chain.capsule_joint, names, set()) if checked.apart is None else chain.pairs
    return {frozenset((names[i], names[j])) for i, j in looked_at.tolist() if (i, j) not in apart}


def _check_way(robot: Robot, tip: str, moving: list[Joint]) -> None:
    if not moving:
        what = f"no joint that moves between {robot.root!r} and {tip!r}"
        raise InputError(what, where="urdf", expected="one or more")
    for joint in moving:
        where = f"urdf joint {joint.name!r}"
        if joint.leader:
            raise InputError("follows another joint", where=where, expected="no <mimic> on the way, or --set")
        if joint.lower >= joint.upper:
            expected = f'<limit lower="…" upper="…"/> in m, or --set {joint.name}=0'
            raise InputError("slides, and has no limits", where=where, expected=expected)


def _neighbours(
    way: list[Joint], at: Mapping[str, float], homes: Mapping[str, tuple[str, Placement]], links: list[str]
) -> Pairs:
    """Return the pairs of ``links`` with at most one joint that moves between them."""
    number = {way[0].parent: 0}
    for joint in way:
        number[joint.child] = number[joint.parent] + (joint.moves and joint.name not in at)
    carried = {link: number[homes[link][0]] for link in links}
    return {frozenset((a, b)) for a in links for b in links if a != b and abs(carried[a] - carried[b]) <= 1}
