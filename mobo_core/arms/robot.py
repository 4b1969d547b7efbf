"""A robot's description as URDF has it, read with patience: what can be meant in one way only is taken so.

Numbers and names are checked as strictly as those of a candidate (:mod:`mobo_core.evaluation.urdf`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from xml.etree.ElementTree import Element

import numpy as np

from mobo_core.arms.rigid import Inertial, Placement, Triple
from mobo_core.errors import InputError
from mobo_core.evaluation.urdf import slide_radius
from mobo_core.evaluation.urdf_xml import numbers, text, unique_names

# Of a description as it is found; what is evaluated of it is smaller.
MAX_LINKS = 2000
_MOVING = ("revolute", "continuous", "prismatic")
_HELD = ("floating", "planar")
_ANGLE_LIMIT = 1e3


@dataclass(frozen=True)
class Solid:
    """A collision shape.

    Attributes:
        link: name of its link.
        kind: ``sphere``, ``cylinder``, ``capsule``, ``box`` or ``mesh``.
        placed: in the frame of the link.
        size: m; radius and length of a sphere (0), cylinder or capsule; x, y, z of a box; scale of a mesh.
        file: of a mesh, as written.
    """

    link: str
    kind: str
    placed: Placement
    size: Triple
    file: str = ""


@dataclass(frozen=True)
class Joint:
    """A joint; ``axis`` has length 1, limits are in rad or m; a mimic joint follows ``leader``.

    ``slide``: m, radius of the pinion that drives it, if it slides and the file says so.
    """

    name: str
    kind: str
    parent: str
    child: str
    placed: Placement
    axis: Triple = (1.0, 0.0, 0.0)
    lower: float = 0.0
    upper: float = 0.0
    leader: str = ""
    multiplier: float = 1.0
    offset: float = 0.0
    slide: float | None = None

    @property
    def moves(self) -> bool:
        """Whether it is not fixed."""
        return self.kind != "fixed"


@dataclass
class Robot:
    """A tree of links.

    Attributes:
        name: as the file has it.
        root: the link that has no parent.
        bodies: link -> its inertial; links without mass are not in it.
        links: names in the file's order.
        joints: child link -> the joint that carries it.
        solids: all collision shapes in the file's order.
        notes: what was assumed, a line each.
    """

    name: str = "robot"
    root: str = ""
    links: list[str] = field(default_factory=list)
    bodies: dict[str, tuple[Inertial, Placement]] = field(default_factory=dict)
    joints: dict[str, Joint] = field(default_factory=dict)
    solids: list[Solid] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def path(self, link: str) -> list[Joint]:
        """Return the joints from the root to ``link``."""
        found = []
        while link != self.root:
            found.append(self.joints[link])
            link = found[-1].parent
        return found[::-1]

    def leaves(self) -> list[str]:
        """Return the links that carry no other."""
        parents = {joint.parent for joint in self.joints.values()}
        return [link for link in self.links if link not in parents]


def read_robot(root: Element) -> Robot:
    """Return the robot that the root element of a URDF describes.

    Raises:
        InputError: it is none, is not one tree of links, or has a number that is not finite or impossible.
    """
    if root.tag in ("mujoco", "mujocoinclude"):
        expected = "URDF or xacro, such as PyPI's mjcf-urdf-simple-converter makes of it (docs/arms.md)"
        raise InputError("MJCF, MuJoCo's format, which is not read", where="robot", expected=expected)
    if root.tag != "robot":
        raise InputError(f"root element <{root.tag[:40]}>", where="urdf", expected="<robot>")
    links, joints = root.findall("link"), root.findall("joint")
    if not 2 <= len(links) <= MAX_LINKS or len(joints) > MAX_LINKS:
        what = f"{len(links)} links and {len(joints)} joints"
        raise InputError(what, where="urdf", expected=f"2 to {MAX_LINKS} links and a joint for each but the first")
    robot = Robot(name=root.get("name") or "robot")
    names = unique_names(links, "link")
    unique_names(joints, "joint")
    for link in links:
        _link(link, robot)
    for element in joints:
        joint = _joint(element, names, robot)
        if joint.child in robot.joints or joint.child == joint.parent:
            raise InputError(f"link {joint.child!r} closes a loop", where="urdf", expected="one tree of links")
        robot.joints[joint.child] = joint
    _one_tree(robot)
    return robot


def origin(source: Element, where: str) -> Placement:
    """Return the placement that an element's ``<origin>`` says."""
    found = source.find("origin")
    return Placement(numbers(found, "xyz", "0 0 0", where), numbers(found, "rpy", "0 0 0", where))


def _link(link: Element, robot: Robot) -> None:
    name = link.get("name", "")
    robot.links.append(name)
    where = f"urdf link {name!r}"
    inertial = link.find("inertial")
    if inertial is not None and inertial.find("mass") is not None:
        (mass,) = numbers(inertial.find("mass"), "value", "", where + " mass", 1)
        if mass < 0:
            raise InputError(f"mass {mass:g} kg", where=where, expected="0 or more")
        moment = {
            key: numbers(inertial.find("inertia"), key, "0", where + " inertia", 1)[0]
            for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        }
        moments = np.array([[moment["i" + "".join(sorted(row + column))] for column in "xyz"] for row in "xyz"])
        placed = origin(inertial, where + " inertial")
        if mass > 0:  # massless links are frames
            robot.bodies[name] = (Inertial(mass, np.zeros(3), moments), placed)
    for collision in link.findall("collision"):
        _solid(collision, name, robot)


def _solid(collision: Element, link: str, robot: Robot) -> None:
    where = f"urdf link {link!r} collision"
    geometry = collision.find("geometry")
    shapes = [] if geometry is None else [shape for shape in geometry if shape.tag in _SHAPES]
    if not shapes:
        robot.notes.append(f"link {link!r}: a collision shape of no known kind does not count")
        return
    shape = shapes[0]
    size = _SHAPES[shape.tag](shape, where)
    if shape.tag != "mesh" and min(size) < 0 or max(abs(v) for v in size) == 0:
        raise InputError(f"{shape.tag} of {text(size)} m", where=where, expected="sizes above 0")
    robot.solids.append(Solid(link, shape.tag, origin(collision, where), size, shape.get("filename", "")))


def _round_size(shape: Element, where: str) -> Triple:
    (radius,) = numbers(shape, "radius", "", where, 1)
    (length,) = numbers(shape, "length", "0" if shape.tag == "sphere" else "", where, 1)
    if radius <= 0:
        raise InputError(f"radius {radius:g}", where=where, expected="more than 0")
    return radius, length


def _box_size(shape: Element, where: str) -> Triple:
    return numbers(shape, "size", "", where)


def _mesh_scale(shape: Element, where: str) -> Triple:
    return numbers(shape, "scale", "1 1 1", where)


_SHAPES = {
    "sphere": _round_size, "cylinder": _round_size, "capsule": _round_size, "box": _box_size, "mesh": _mesh_scale,
}  # fmt: skip


def _joint(joint: Element, links: set[str], robot: Robot) -> Joint:
    name, kind = joint.get("name", ""), joint.get("type", "")
    where = f"urdf joint {name!r}"
    if kind not in (*_MOVING, *_HELD, "fixed"):
        expected = ", ".join((*_MOVING, *_HELD)) + " or fixed"
        raise InputError(f"type {kind[:40]!r}", where=where, expected=expected)
    ends = []
    for end in ("parent", "child"):
        element = joint.find(end)
        ends.append("" if element is None else element.get("link", ""))
        if ends[-1] not in links:
            raise InputError(f"{end} link {ends[-1][:40]!r} does not exist", where=where, expected="a link's name")
    placed = origin(joint, where)
    if kind in _HELD:
        robot.notes.append(f"joint {name!r} is {kind}: held where it is")
    if kind not in _MOVING:
        return Joint(name, "fixed", ends[0], ends[1], placed)
    lower, upper = _limits(joint, name, kind, where, robot)
    leader, multiplier, offset = "", 1.0, 0.0
    mimic = joint.find("mimic")
    if mimic is not None:
        leader = mimic.get("joint", "")
        (multiplier,) = numbers(mimic, "multiplier", "1", where + " mimic", 1)
        (offset,) = numbers(mimic, "offset", "0", where + " mimic", 1)
    axis = _axis(joint, where)
    slide = slide_radius(joint, where) if kind == "prismatic" and joint.find("slide") is not None else None
    return Joint(name, kind, ends[0], ends[1], placed, axis, lower, upper, leader, multiplier, offset, slide)


def _axis(joint: Element, where: str) -> Triple:
    axis = numbers(joint.find("axis"), "xyz", "1 0 0", where + " axis")
    length = math.sqrt(math.fsum(a * a for a in axis))
    if length == 0.0:
        raise InputError(f"axis {text(axis)}", where=where, expected="a direction")
    # One that an evaluation takes as it is stays as it is, to the bit.
    return axis if abs(length - 1.0) <= 1e-3 else tuple(a / length for a in axis)


def _limits(joint: Element, name: str, kind: str, where: str, robot: Robot) -> tuple[float, float]:
    if kind == "continuous":
        return -math.pi, math.pi
    limit = joint.find("limit")
    (lower,) = numbers(limit, "lower", "0", where + " limit", 1)
    (upper,) = numbers(limit, "upper", "0", where + " limit", 1)
    if lower > upper or max(abs(lower), abs(upper)) > _ANGLE_LIMIT:
        what = f"lower {lower:g}, upper {upper:g}"
        raise InputError(what, where=where, expected=f"lower < upper, within {_ANGLE_LIMIT:g}")
    if lower == upper and kind == "revolute":
        robot.notes.append(f"joint {name!r} has no limits: taken as -180 to 180 degrees")
        return -math.pi, math.pi
    return lower, upper


def _one_tree(robot: Robot) -> None:
    roots = [link for link in robot.links if link not in robot.joints]
    if len(roots) != 1:
        what = f"{len(roots)} root links" + (f" ({', '.join(roots[:3])})" if roots else ": the joints close a loop")
        raise InputError(what, where="urdf", expected="one tree of links")
    robot.root = roots[0]
    rooted = {robot.root}
    for link in robot.links:
        way = []
        while link not in rooted:
            if link in way:
                raise InputError(f"link {link!r} closes a loop", where="urdf", expected="one tree of links")
            way.append(link)
            link = robot.joints[link].parent
        rooted.update(way)
