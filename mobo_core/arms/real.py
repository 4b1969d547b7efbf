"""An arm that exists, by numbers: axes, offsets, limits, masses where they are known; and as URDF."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from xml.sax.saxutils import quoteattr

import numpy as np

from mobo_core.arms.arm_joint import ArmJoint, motor_place
from mobo_core.arms.links import Body, bodies_of, heavier, inertial_text, tube_text, tubes_of
from mobo_core.arms.rigid import Array, Placement, Triple
from mobo_core.design import DesignSpace
from mobo_core.design.numbers import middle, of_joint
from mobo_core.evaluation.urdf_xml import text


@dataclass(frozen=True)
class Order:
    """A joint order, and how far the arm is from it.

    Attributes:
        joints: in our letters, as built.
        q: (n,) rad, the straightened posture; of joints that slide m, the middle of their strokes.
        skew: rad, the farthest that an axis is off x, y or z there; that of a joint that slides, off z.
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
    def ends(self) -> tuple[Triple, ...]:
        """M, where the next joint's origin is in each joint's frame; the tip in the last one's."""
        return (*(joint.placed.xyz for joint in self.joints[1:]), self.tip.xyz)

    @property
    def segments(self) -> tuple[float, ...]:
        """M, from each joint's origin to the next one's, the last to the tip; slides in the middle of their strokes."""
        pairs = zip(self.joints, self.ends, strict=True)
        return tuple(math.hypot(*(joint.shift(joint.middle) + np.array(end))) for joint, end in pairs)

    @property
    def length(self) -> float:
        """M, height of the straightened arm above its first joint; the sum of its segments if it has no order yet.

        Where along its axis a joint's frame was put does not change the height, but it does the segments.
        """
        return math.fsum(self.segments if self.order is None else self.order.lengths)

    def frames(self, q: Array) -> tuple[Array, Array, Array]:
        """Return axes (n, 3), origins (n + 1, 3) in m, and the tip's rotation (3, 3), at ``q`` in rad or m.

        The last origin is the tip. The first joint's origin is that of the base frame: what is below it is left out.
        """
        turned, at = np.eye(3), np.zeros(3)
        axes, origins = [], []
        for i, joint in enumerate(self.joints):
            at = at + turned @ np.array(joint.placed.xyz) if i else at
            turned = turned @ joint.placed.matrix
            axes.append(turned @ np.array(joint.axis))
            origins.append(at)
            at = at + turned @ joint.shift(float(q[i]))
            turned = turned @ joint.rotation(float(q[i]))
        origins.append(at + turned @ np.array(self.tip.xyz))
        return np.array(axes), np.array(origins), turned @ self.tip.matrix

    def urdf(
        self, total: float | None = None, space: DesignSpace | None = None, added: Mapping[int, float] | None = None
    ) -> str:
        """Return the arm as URDF, its first joint at the base's origin.

        Args:
            total: m, what :attr:`length` is scaled to, strokes with it; as it is if None.
            space: masses and radius of its links, and pinions of its slides; None: as the source has them, else those
                of the default space, scaled with the arm as solid bodies are.
            added: joint (from 0) -> kg more than that, or less, where its motor is; what is left is above 0.
        """
        joints, ends, radius = self._sized(total, space)
        bodies = self._carried(total, space)
        for number, more in (added or {}).items():
            on, at = motor_place(joints, number)
            if on >= 0:
                bodies[on] = heavier(bodies[on], more, at)
        lines = [f"<robot name={quoteattr(self.name)}>", '<link name="base_link"/>']
        for i, (joint, body, end) in enumerate(zip(joints, bodies, ends, strict=True), start=1):
            tubes = "".join(tube_text(a, b, radius) for a, b in tubes_of(joint, end))
            lines.append(f'<link name="link_{i}">{inertial_text(body)}{tubes}</link>')
        lines.append('<link name="tool"/>')
        for i, joint in enumerate(joints):
            xyz = joint.placed.xyz if i else (0.0, 0.0, 0.0)
            kind, slide = ("prismatic", f'<slide radius="{joint.slide!r}"/>') if joint.slides else ("revolute", "")
            parent = f"link_{i}" if i else "base_link"
            lines.append(
                f'<joint name="joint_{i + 1}" type="{kind}"><parent link="{parent}"/><child link="link_{i + 1}"/>'
                f'<origin xyz="{text(xyz)}" rpy="{text(joint.placed.rpy)}"/><axis xyz="{text(joint.axis)}"/>'
                f'<limit lower="{joint.lower!r}" upper="{joint.upper!r}"/>{slide}</joint>'
            )
        lines.append(
            f'<joint name="tip" type="fixed"><parent link="link_{self.n}"/><child link="tool"/>'
            f'<origin xyz="{text(ends[-1])}" rpy="{text(self.tip.rpy)}"/></joint></robot>'
        )
        return "\n".join(lines)

    def masses(self, total: float | None = None, space: DesignSpace | None = None) -> tuple[float, ...]:
        """Return kg that each joint carries, of the arm as :meth:`urdf` writes it."""
        return tuple(mass for mass, _ in self._carried(total, space))

    def scale(self, total: float | None) -> float:
        """Return how much larger the arm is when its :attr:`length` is ``total`` m; 1 if None."""
        return 1.0 if total is None else total / self.length

    def _sized(
        self, total: float | None, space: DesignSpace | None
    ) -> tuple[tuple[ArmJoint, ...], tuple[Triple, ...], float]:
        """Return joints, ends and the links' radius (m) of the arm as large as it is wanted."""
        scale = self.scale(total)
        radii: list[float | None] = [None] * self.n
        if space is not None:
            radii = [of_joint(space.slide_radius, i if self.n == space.n_joints else 0) for i in range(self.n)]
        joints = tuple(joint.scaled(scale, radius) for joint, radius in zip(self.joints, radii, strict=True))
        ends = tuple(tuple(scale * v for v in end) for end in self.ends)
        return joints, ends, of_joint((space or DesignSpace()).link_radius, 0) * self._grown(scale, space)

    def _grown(self, scale: float, space: DesignSpace | None) -> float:
        """Return how much larger than an arm of the design space its links and motors are."""
        return scale * self.length / middle(DesignSpace().total_length) if space is None else 1.0

    def _carried(self, total: float | None, space: DesignSpace | None) -> list[Body]:
        scale = self.scale(total)
        if self.bodies is not None and space is None:
            return [(mass * scale**3, tuple(scale * c for c in com)) for mass, com in self.bodies]
        joints, ends, radius = self._sized(total, space)
        return bodies_of(joints, ends, space or DesignSpace(), radius, self._grown(scale, space))
