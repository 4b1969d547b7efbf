"""An arm that exists, by numbers: axes, offsets, limits, masses where they are known; and as URDF."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from mobo_core.arms.rigid import Placement, Triple, rotation
from mobo_core.design import DesignSpace
from mobo_core.design.numbers import middle, of_joint
from mobo_core.evaluation.urdf_xml import text

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Order:
    """A joint order, and how far the arm is from it.

    Attributes:
        joints: in our letters, as built.
        q: (n,) rad, the straightened posture.
        skew: rad, the farthest that an axis is off x, y or z there.
        offset: m, the farthest that a joint's origin or the tip is off the vertical through the first joint.
        lengths: m, heights from joint to joint and to the tip, none below 0; the idealised twin's but for scale.
    """

    joints: str
    q: Triple
    skew: float
    offset: float
    lengths: Triple

    def twin(self, total: float) -> tuple[float, ...]:
        """Return the lengths of the twin of ``total`` m: the same joints straight above each other."""
        whole = math.fsum(self.lengths)
        return tuple(total * length / whole for length in self.lengths)


@dataclass(frozen=True)
class ArmJoint:
    """A joint that turns: its frame in that of the joint before, its axis there, and its limits in rad."""

    placed: Placement
    axis: Triple
    lower: float
    upper: float


@dataclass(frozen=True, eq=False)
class RealArm:
    """An arm of the catalogue.

    Attributes:
        name, maker: of the arm.
        joints: from the base.
        tip: the end of the arm in the last joint's frame.
        bodies: kg and centre (3,) m of what each joint carries, in its frame; none if no source says.
        source: package, version, path, and where that has it from.
        licence: of the source.
        order: its joints in our letters.
        paper: what the paper calls it, if it names it.
    """

    name: str
    maker: str
    joints: tuple[ArmJoint, ...]
    tip: Placement
    bodies: tuple[tuple[float, Triple], ...] | None
    source: dict[str, str]
    licence: str
    order: Order | None = None
    paper: str = ""

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.joints)

    @property
    def estimated(self) -> tuple[str, ...]:
        """Names of what no source says."""
        return ("shapes",) if self.bodies is not None else ("masses", "shapes")

    @property
    def segments(self) -> tuple[float, ...]:
        """M, from each joint's origin to the next one's, the last to the tip."""
        ends = [*(joint.placed for joint in self.joints[1:]), self.tip]
        return tuple(math.hypot(*end.xyz) for end in ends)

    @property
    def length(self) -> float:
        """M, height of the straightened arm above its first joint; the sum of its segments if it has no order yet.

        Where along its axis a joint's frame was put does not change the height, but it does the segments.
        """
        return math.fsum(self.segments if self.order is None else self.order.lengths)

    def frames(self, q: Array) -> tuple[Array, Array, Array]:
        """Return axes (n, 3), origins (n + 1, 3) in m, and the tip's rotation (3, 3), at ``q`` in rad.

        The last origin is the tip. The first joint's origin is that of the base frame: what is below it is left out.
        """
        turned, at = np.eye(3), np.zeros(3)
        axes, origins = [], []
        for i, joint in enumerate(self.joints):
            at = at + turned @ np.array(joint.placed.xyz) if i else at
            turned = turned @ joint.placed.matrix
            axes.append(turned @ np.array(joint.axis))
            origins.append(at)
            turned = turned @ rotation(np.array(joint.axis), float(q[i]))
        origins.append(at + turned @ np.array(self.tip.xyz))
        return np.array(axes), np.array(origins), turned @ self.tip.matrix

    def urdf(
        self, total: float | None = None, space: DesignSpace | None = None, added: Mapping[int, float] | None = None
    ) -> str:
        """Return the arm as URDF, its first joint at the base's origin.

        Args:
            total: m, what :attr:`length` is scaled to; as it is if None.
            space: masses and radius of its links; None: as the source has them, else those of the default space,
                scaled with the arm as solid bodies are.
            added: joint (from 0) -> kg more than that, or less, at its origin; what is left is above 0.
        """
        scale = 1.0 if total is None else total / self.length
        using = space or DesignSpace()
        bodies = self._carried(scale, space)
        for number, more in (added or {}).items():
            mass, com = bodies[number]
            bodies[number] = mass + more, tuple(mass * c / (mass + more) for c in com)
        radius = of_joint(using.link_radius, 0) * self._grown(scale, space)
        lines = [f"<robot name={quoteattr(self.name)}>", '<link name="base_link"/>']
        ends = [*(joint.placed.xyz for joint in self.joints[1:]), self.tip.xyz]
        for i, ((mass, com), end) in enumerate(zip(bodies, ends, strict=True), start=1):
            lines.append(f'<link name="link_{i}">{_inertial(mass, com)}{_tube(end, scale, radius)}</link>')
        lines.append('<link name="tool"/>')
        for i, joint in enumerate(self.joints):
            xyz = tuple(scale * v for v in joint.placed.xyz) if i else (0.0, 0.0, 0.0)
            parent = f"link_{i}" if i else "base_link"
            lines.append(
                f'<joint name="joint_{i + 1}" type="revolute"><parent link="{parent}"/><child link="link_{i + 1}"/>'
                f'<origin xyz="{text(xyz)}" rpy="{text(joint.placed.rpy)}"/><axis xyz="{text(joint.axis)}"/>'
                f'<limit lower="{joint.lower!r}" upper="{joint.upper!r}"/></joint>'
            )
        xyz = tuple(scale * v for v in self.tip.xyz)
        lines.append(
            f'<joint name="tip" type="fixed"><parent link="link_{self.n}"/><child link="tool"/>'
            f'<origin xyz="{text(xyz)}" rpy="{text(self.tip.rpy)}"/></joint></robot>'
        )
        return "\n".join(lines)

    def masses(self, total: float | None = None, space: DesignSpace | None = None) -> tuple[float, ...]:
        """Return kg that each joint carries, of the arm as :meth:`urdf` writes it."""
        scale = 1.0 if total is None else total / self.length
        return tuple(mass for mass, _ in self._carried(scale, space))

    def _grown(self, scale: float, space: DesignSpace | None) -> float:
        """Return how much larger than an arm of the design space its links and motors are."""
        return scale * self.length / middle(DesignSpace().total_length) if space is None else 1.0

    def _carried(self, scale: float, space: DesignSpace | None) -> list[tuple[float, Triple]]:
        if self.bodies is not None and space is None:
            return [(mass * scale**3, tuple(scale * c for c in com)) for mass, com in self.bodies]
        return self._bodies(space or DesignSpace(), scale, self._grown(scale, space))

    def _bodies(self, space: DesignSpace, scale: float, grown: float) -> list[tuple[float, Triple]]:
        """Return the masses of a design space: a motor at each joint's origin, and links half-way along."""
        ends = [*(joint.placed.xyz for joint in self.joints[1:]), self.tip.xyz]
        found = []
        for i, (end, segment) in enumerate(zip(ends, self.segments, strict=True)):
            radius, density, motor = (
                of_joint(value, 0 if len(ends) != space.n_joints else i)
                for value in (space.link_radius, space.link_density, space.motor_mass)
            )
            link = math.pi * (radius * grown) ** 2 * density * scale * segment
            mass = link + motor * grown**3
            share = 0.5 * scale * link / mass if mass > 0 else 0.0
            found.append((mass, tuple(share * e for e in end)))
        return found


def _inertial(mass: float, com: Triple) -> str:
    if mass <= 0:
        return ""
    moments = '<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>'
    return f'<inertial><origin xyz="{text(com)}" rpy="0 0 0"/><mass value="{mass!r}"/>{moments}</inertial>'


def _tube(end: Triple, scale: float, radius: float) -> str:
    """Return the collision shape from a joint's origin to ``end``, if that is elsewhere."""
    length = math.hypot(*end)
    if length <= 1e-6:
        return ""
    x, y, z = end
    xyz, rpy = tuple(0.5 * scale * v for v in end), (0.0, math.atan2(math.hypot(x, y), z), math.atan2(y, x))
    size = f'radius="{radius!r}" length="{scale * length!r}"'
    place = f'<origin xyz="{text(xyz)}" rpy="{text(rpy)}"/>'
    return f"<collision>{place}<geometry><cylinder {size}/></geometry></collision>"
