"""A URDF from anywhere, checked and boiled down to what an evaluation needs.

Pinocchio crashes on some malformed robots and accepts some impossible ones (mass -1, a zero axis). So it is not
given the text that came in, but a plain URDF written anew from the values checked here: links with their
inertials, and joints. Collision shapes are kept beside it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from xml.etree.ElementTree import Element
from xml.sax.saxutils import quoteattr

from mobo_core.errors import InputError
from mobo_core.evaluation.urdf_xml import numbers, parse, text, unique_names

MAX_BYTES = 1_000_000
MAX_JOINTS = 64
MAX_LINKS = 256
MAX_SHAPES = 300  # each pair of them is looked at
_REVOLUTE = ("revolute", "continuous")
_ANGLE_LIMIT = 1e3
# m, of the pinion that drives a joint which slides, where the URDF does not say.
SLIDE_RADIUS = 0.05


@dataclass(frozen=True)
class Shape:
    """A collision shape as a capsule: a segment along z, and a radius; placed in the frame of its link.

    Attributes:
        link: name of the link.
        name: of the shape, by which pairs are listed; the link's where it has none.
        xyz: metres, centre of the segment.
        rpy: rad, fixed-axis roll, pitch, yaw.
        length: metres, of the segment; 0 for a ball.
        radius: metres.
    """

    link: str
    name: str
    xyz: tuple[float, ...]
    rpy: tuple[float, ...]
    length: float
    radius: float


@dataclass
class CheckedUrdf:
    """A robot whose structure and numbers are sound.

    Attributes:
        xml: plain URDF with links, inertials and joints alone; continuous joints turn within one turn.
        root: name of the root link.
        parents: link -> (parent link, joint name, joint type) for all links but the root.
        shapes: collision cylinders and spheres.
        ignored_shapes: collision shapes of other kinds (such as boxes), which are left out.
        apart: pairs of names of shapes that do not collide, if they are listed: then all others may, however close.
        mimics: names of the joints that follow another one.
        slides: joints that slide -> radius of the pinion that drives each, m (``<slide radius="…"/>`` in the joint).
    """

    xml: str = ""
    root: str = ""
    parents: dict[str, tuple[str, str, str]] = field(default_factory=dict)
    shapes: list[Shape] = field(default_factory=list)
    ignored_shapes: int = 0
    apart: set[frozenset[str]] | None = None
    mimics: set[str] = field(default_factory=set)
    slides: dict[str, float] = field(default_factory=dict)

    def leaves(self) -> list[str]:
        """Return the links that are nobody's parent."""
        inner = {parent for parent, _, _ in self.parents.values()}
        return [link for link in (self.root, *self.parents) if link not in inner]

    def path(self, tip: str) -> list[str]:
        """Return the joint names from the root to ``tip``."""
        joints = []
        while tip != self.root:
            tip, joint, _ = self.parents[tip]
            joints.append(joint)
        return joints[::-1]


def check_urdf(urdf: str | bytes) -> CheckedUrdf:
    """Check a URDF and return what an evaluation needs of it.

    Raises:
        InputError: too large, not XML, with a DTD or entities, too deep, not one tree of links, or with a
            number that is not finite or impossible.
    """
    data = urdf.encode("utf-8", "surrogatepass") if isinstance(urdf, str) else urdf
    if len(data) > MAX_BYTES:
        raise InputError(f"{len(data)} bytes", where="urdf", expected=f"at most {MAX_BYTES} bytes")
    robot = parse(data)
    if robot.tag != "robot":
        raise InputError(f"root element <{robot.tag[:40]}>", where="urdf", expected="<robot>")
    links, joints = robot.findall("link"), robot.findall("joint")
    if not 2 <= len(links) <= MAX_LINKS:
        raise InputError(f"{len(links)} links", where="urdf", expected=f"2 to {MAX_LINKS}")
    if not 1 <= len(joints) <= MAX_JOINTS:
        raise InputError(f"{len(joints)} joints", where="urdf", expected=f"1 to {MAX_JOINTS}")
    checked = CheckedUrdf()
    plain = ['<robot name="checked">']
    names = unique_names(links, "link")
    unique_names(joints, "joint")
    for link in links:
        _link(link, plain, checked)
    for joint in joints:
        _joint(joint, plain, names, checked)
    _one_tree(names, checked)
    listed = robot.find("self_collision")
    if listed is not None:
        checked.apart = _listed(listed)
    checked.xml = "".join([*plain, "</robot>"])
    return checked


def _origin(source: Element, where: str) -> str:
    origin = source.find("origin")
    xyz = numbers(origin, "xyz", "0 0 0", where)
    rpy = numbers(origin, "rpy", "0 0 0", where)
    return f'<origin xyz="{text(xyz)}" rpy="{text(rpy)}"/>'


def _link(link: Element, plain: list[str], checked: CheckedUrdf) -> None:
    name = link.get("name", "")
    where = f"urdf link {name!r}"
    plain.append(f"<link name={quoteattr(name)}>")
    inertial = link.find("inertial")
    if inertial is not None:
        (mass,) = numbers(inertial.find("mass"), "value", "", where + " mass", 1)
        if mass <= 0:
            raise InputError(f"mass {mass:g} kg", where=where, expected="more than 0")
        plain.append(f'<inertial>{_origin(inertial, where + " inertial")}<mass value="{mass!r}"/><inertia')
        inertia = inertial.find("inertia")
        for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"):
            (moment,) = numbers(inertia, key, "0", where + " inertia", 1)
            plain.append(f' {key}="{moment!r}"')
        plain.append("/></inertial>")
    plain.append("</link>")
    for collision in link.findall("collision"):
        _shape(collision, name, checked)


def _shape(collision: Element, link: str, checked: CheckedUrdf) -> None:
    where = f"urdf link {link!r} collision"
    geometry = collision.find("geometry")
    if geometry is not None and geometry.find("mesh") is not None:
        expected = "spheres and cylinders; `mobo evaluate FILE` fits capsules to meshes"
        raise InputError("a mesh", where=where, expected=expected)
    cylinder = None if geometry is None else geometry.find("cylinder")
    sphere = None if geometry is None else geometry.find("sphere")
    if cylinder is None and sphere is None:
        checked.ignored_shapes += 1
        return
    (radius,) = numbers(cylinder if cylinder is not None else sphere, "radius", "", where, 1)
    (length,) = numbers(cylinder, "length", "", where, 1) if cylinder is not None else (0.0,)
    if radius <= 0 or length < 0:
        raise InputError(f"radius {radius:g}, length {length:g}", where=where, expected="radius > 0, length >= 0")
    origin = collision.find("origin")
    xyz, rpy = numbers(origin, "xyz", "0 0 0", where), numbers(origin, "rpy", "0 0 0", where)
    if len(checked.shapes) >= MAX_SHAPES:
        raise InputError(f"more than {MAX_SHAPES} collision shapes", where="urdf", expected=f"at most {MAX_SHAPES}")
    checked.shapes.append(Shape(link, collision.get("name", link), xyz, rpy, length, radius))


def _listed(listed: Element) -> set[frozenset[str]]:
    """Return the pairs of shapes that ``<self_collision>`` lists as never colliding, as an SRDF lists links."""
    pairs = listed.findall("disable_collisions")
    if len(pairs) > MAX_SHAPES * MAX_SHAPES:
        raise InputError(f"{len(pairs)} pairs", where="urdf self_collision", expected=f"at most {MAX_SHAPES**2}")
    return {frozenset((pair.get("link1", ""), pair.get("link2", ""))) for pair in pairs}


def _joint(joint: Element, plain: list[str], links: set[str], checked: CheckedUrdf) -> None:
    name, kind = joint.get("name", ""), joint.get("type", "")
    where = f"urdf joint {name!r}"
    if kind not in (*_REVOLUTE, "fixed", "prismatic"):
        raise InputError(f"type {kind[:40]!r}", where=where, expected="revolute, continuous, prismatic or fixed")
    ends = {}
    for end in ("parent", "child"):
        element = joint.find(end)
        ends[end] = "" if element is None else element.get("link", "")
        if ends[end] not in links:
            raise InputError(f"{end} link {ends[end][:40]!r} does not exist", where=where, expected="a link's name")
    if ends["child"] in checked.parents or ends["child"] == ends["parent"]:
        raise InputError(f"link {ends['child']!r} closes a loop", where=where, expected="one parent for every link")
    checked.parents[ends["child"]] = (ends["parent"], name, kind)
    plain.append(
        f'<joint name={quoteattr(name)} type="{"revolute" if kind == "continuous" else kind}">{_origin(joint, where)}'
        f"<parent link={quoteattr(ends['parent'])}/><child link={quoteattr(ends['child'])}/>"
    )
    if kind != "fixed":
        plain.append(_motion(joint, name, kind, where, checked))
    plain.append("</joint>")


def _motion(joint: Element, name: str, kind: str, where: str, checked: CheckedUrdf) -> str:
    """Return axis and limits of a joint that moves."""
    if joint.find("mimic") is not None:
        checked.mimics.add(name)
    if kind == "prismatic":
        checked.slides[name] = slide_radius(joint, where)
    axis = numbers(joint.find("axis"), "xyz", "1 0 0", where + " axis")
    if abs(math.sqrt(sum(a * a for a in axis)) - 1) > 1e-3:
        raise InputError(f"axis {text(axis)}", where=where, expected="a vector of length 1")
    lower, upper = -math.pi, math.pi
    if kind != "continuous":
        limit = joint.find("limit")
        if limit is None:
            raise InputError("no <limit>", where=where, expected='<limit lower="…" upper="…"/>')
        (lower,) = numbers(limit, "lower", "0", where + " limit", 1)
        (upper,) = numbers(limit, "upper", "0", where + " limit", 1)
        if lower >= upper or max(abs(lower), abs(upper)) > _ANGLE_LIMIT:
            what = f"lower {lower:g}, upper {upper:g}"
            raise InputError(what, where=where, expected=f"lower < upper, within {_ANGLE_LIMIT:g}")
    limit_text = f'<limit lower="{lower!r}" upper="{upper!r}" effort="1000" velocity="10"/>'
    return f'<axis xyz="{text(axis)}"/>{limit_text}'


def slide_radius(joint: Element, where: str) -> float:
    """Return m, the radius of the pinion that drives a joint which slides.

    Raises:
        InputError: it is not a number above 0.
    """
    (radius,) = numbers(joint.find("slide"), "radius", repr(SLIDE_RADIUS), where + " slide", 1)
    if not 0 < radius <= _ANGLE_LIMIT:
        raise InputError(f"radius {radius:g}", where=where + " slide", expected=f"above 0, at most {_ANGLE_LIMIT:g} m")
    return radius


def _one_tree(links: set[str], checked: CheckedUrdf) -> None:
    roots = sorted(links - checked.parents.keys())
    if len(roots) != 1:
        what = f"{len(roots)} root links" + (f" ({', '.join(roots[:3])})" if roots else ": the joints close a loop")
        raise InputError(what, where="urdf", expected="one tree of links")
    checked.root = roots[0]
    for link in checked.parents:
        seen = set()
        while link != checked.root:
            if link in seen:
                raise InputError(f"link {link!r} closes a loop", where="urdf", expected="one tree of links")
            seen.add(link)
            link = checked.parents[link][0]
