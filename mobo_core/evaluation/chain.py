"""A serial chain as flat arrays, taken from a Pinocchio model of a checked URDF."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from mobo_core.errors import InputError
from mobo_core.evaluation.capsules import capsules_of, listed_pairs, separate_pairs
from mobo_core.evaluation.kernel.configuration import forward
from mobo_core.evaluation.kernel.geometry import place_capsules
from mobo_core.evaluation.matrices import Matrix, axis_frame, matmul, matvec, norm, rpy_matrix, transposed
from mobo_core.evaluation.spec import NOWHERE, EvaluationSpec, Vector
from mobo_core.evaluation.urdf import CheckedUrdf, check_urdf
from mobo_core.jit.cache import interpreted

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Chain:
    """A serial arm of n joints that turn or slide. Joint frames are turned so that every joint axis is z.

    Attributes:
        placement_r, placement_p: (n, 3, 3), (n, 3) m; joint frame at zero in the joint frame before
            it, the first one in the base frame.
        tip_r, tip_p: (3, 3), (3,) m; the tool in the last joint frame. It is at the tip where no tool is given.
        lower, upper: (n,) rad, or m.
        slide: (n,) m; 0 for a joint that turns, and for one that slides the radius of the pinion that drives it: its
            force counts as torque times this.
        mass, com: (n,) kg, (n, 3) m; what joint i carries up to the next joint, in its joint frame.
        reach_radius: m, farthest the tip can be from the first joint's origin.
        capsule_joint: (c,) joint that carries a capsule, -1 for the base.
        capsule_a, capsule_b: (c, 3) m, ends of its segment in that joint frame.
        capsule_radius: (c,) m.
        pairs: (k, 2) capsules that may collide: carried by different joints, and apart by more than
            TOUCHING in the configuration nearest zero within the limits; or as the URDF lists them.
        joint_names: (n,) names.
        tip: name of the tip link.
        ignored_shapes: collision shapes that are neither cylinder nor sphere nor mesh, left out.
        model: the Pinocchio model it was taken from, with these n joints.
        tip_frame: id of the tool's frame in that model.
    """

    placement_r: Array
    placement_p: Array
    tip_r: Array
    tip_p: Array
    lower: Array
    upper: Array
    slide: Array
    mass: Array
    com: Array
    reach_radius: float
    capsule_joint: NDArray[np.int64]
    capsule_a: Array
    capsule_b: Array
    capsule_radius: Array
    pairs: NDArray[np.int64]
    joint_names: tuple[str, ...]
    tip: str
    ignored_shapes: int
    model: pin.Model
    tip_frame: int

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.joint_names)


def chain_from_urdf(
    text: str | bytes,
    tip: str = "",
    *,
    payload_kg: float = 0.0,
    gravity: Vector = (0.0, 0.0, -9.81),
    payload_com: Vector = NOWHERE,
    tool_xyz: Vector = NOWHERE,
    tool_rpy: Vector = NOWHERE,
) -> Chain:
    """Check a URDF and return the chain from its root to ``tip`` (by default its only leaf link), and the tool there.

    Joints beside the path are held at the angle nearest zero within their limits; their masses count.
    Payload and tool are what the spec's fields of these names say.

    Raises:
        InputError: as :func:`mobo_core.evaluation.urdf.check_urdf`; or no such tip, several leaves and no
            tip named, no joint on the path, or one on it that follows another.
    """
    checked = check_urdf(text)
    tip = _tip(checked, tip)
    path = checked.path(tip)
    kinds = {joint: kind for _, joint, kind in checked.parents.values()}
    moving = [joint for joint in path if kinds[joint] != "fixed"]
    if not moving:
        raise InputError(f"no joint between {checked.root!r} and {tip!r}", where="urdf", expected="one or more")
    for joint in moving:
        if joint in checked.mimics:
            raise InputError("follows another joint", where=f"urdf joint {joint!r}", expected="no <mimic> on the way")
    try:
        model = pin.buildModelFromXML(checked.xml)
        rest = np.clip(0.0, model.lowerPositionLimit, model.upperPositionLimit)
        beside = [i for i, name in enumerate(model.names) if i and name not in moving]
        model = pin.buildReducedModel(model, beside, rest) if beside else model
    except (ValueError, RuntimeError) as error:
        raise InputError(f"Pinocchio refuses it ({error})", where="urdf", expected="a URDF robot") from None
    model.gravity.linear = np.array(gravity)
    tip_frame = model.getFrameId(tip, pin.BODY)
    if any((*tool_xyz, *tool_rpy)):
        tip_frame = _add_tool(model, tip_frame, tool_xyz, tool_rpy)
    if payload_kg > 0:
        last = model.nv
        load = pin.Inertia(payload_kg, np.array(payload_com), np.zeros((3, 3)))
        model.appendBodyToJoint(last, load, model.frames[tip_frame].placement)
    return _flatten(model, tip_frame, tip, checked)


def asked_chain(urdf: str | bytes, tip: str, spec: EvaluationSpec) -> Chain:
    """Return the chain of a URDF that a spec asks about: with its gravity, payload and tool.

    Raises:
        InputError: as :func:`chain_from_urdf`.
    """
    return chain_from_urdf(
        urdf, tip, payload_kg=spec.payload_kg, gravity=spec.gravity, payload_com=spec.payload_com,
        tool_xyz=spec.tool_xyz, tool_rpy=spec.tool_rpy,
    )  # fmt: skip


def _add_tool(model: pin.Model, tip_frame: int, xyz: Vector, rpy: Vector) -> int:
    """Add the tool's frame to a model, and return its id."""
    tip = model.frames[tip_frame]
    rotation = matmul(tip.placement.rotation, rpy_matrix(rpy))
    placed = pin.SE3(np.array(rotation), tip.placement.translation + np.array(matvec(tip.placement.rotation, xyz)))
    return int(model.addFrame(pin.Frame("mobo_tool", tip.parentJoint, tip_frame, placed, pin.OP_FRAME)))


def _tip(checked: CheckedUrdf, tip: str) -> str:
    if not tip:
        leaves = checked.leaves()
        if len(leaves) > 1:
            names = ", ".join(sorted(leaves)[:6])
            raise InputError(f"{len(leaves)} leaf links ({names})", where="urdf", expected="a tip link to be named")
        return leaves[0]
    if tip != checked.root and tip not in checked.parents:
        names = ", ".join(sorted(checked.leaves())[:6])
        raise InputError(f"no link {tip!r}", where="tip", expected=f"a link of the URDF, such as {names}")
    return tip


def _flatten(model: pin.Model, tip_frame: int, tip: str, checked: CheckedUrdf) -> Chain:
    n = model.nv
    data = model.createData()
    pin.computeJointJacobians(model, data, np.zeros(n))
    frames = [transposed(np.eye(3))]
    placement_r, placement_p, mass, com = [], [], [], []
    slide = [checked.slides.get(name, 0.0) for name in tuple(model.names)[1:]]
    for i in range(1, n + 1):
        # Pinocchio gives the Jacobian of a single joint as a vector.
        column = np.reshape(pin.getJointJacobian(model, data, i, pin.LOCAL), (6, n))[:, i - 1]
        own = column[:3] if slide[i - 1] else column[3:]
        frame = axis_frame([float(v) for v in own])
        back = transposed(frames[-1])
        placement = model.jointPlacements[i]
        placement_r.append(matmul(matmul(back, placement.rotation), frame))
        placement_p.append(matvec(back, placement.translation))
        frames.append(frame)
        inertia = model.inertias[i]
        mass.append(float(inertia.mass))
        com.append(matvec(transposed(frame), inertia.lever) if inertia.mass > 0 else [0.0, 0.0, 0.0])
    last = transposed(frames[n])
    tip_placement = model.frames[tip_frame].placement
    tip_p = matvec(last, tip_placement.translation)
    capsules = capsules_of(model, checked, frames)
    chain = Chain(
        placement_r=np.array(placement_r),
        placement_p=np.array(placement_p),
        tip_r=np.array(matmul(last, tip_placement.rotation)),
        tip_p=np.array(tip_p),
        lower=np.array(model.lowerPositionLimit),
        upper=np.array(model.upperPositionLimit),
        slide=np.array(slide),
        mass=np.array(mass),
        com=np.array(com),
        reach_radius=_reach_radius(model, slide, placement_r, placement_p, tip_p),
        capsule_joint=np.array([c[0] for c in capsules], dtype=np.int64),
        capsule_a=np.array([c[1] for c in capsules]).reshape(-1, 3),
        capsule_b=np.array([c[2] for c in capsules]).reshape(-1, 3),
        capsule_radius=np.array([c[3] for c in capsules], dtype=np.float64),
        pairs=np.empty((0, 2), dtype=np.int64),
        joint_names=tuple(model.names)[1:],
        tip=tip,
        ignored_shapes=checked.ignored_shapes,
        model=model,
        tip_frame=tip_frame,
    )
    names = [shape.name for shape in checked.shapes]
    pairs = rest_pairs(chain) if checked.apart is None else listed_pairs(chain.capsule_joint, names, checked.apart)
    object.__setattr__(chain, "pairs", pairs)
    return chain


def _reach_radius(
    model: pin.Model,
    slide: Sequence[float],
    placement_r: Sequence[Matrix],
    placement_p: Sequence[list[float]],
    tip_p: list[float],
) -> float:
    """Return m, the farthest that the tip can be from where the first joint's origin is at zero."""
    ways = [0.0, *(norm(p) for p in [*placement_p[1:], tip_p])]  # of each joint's origin from that of the one before
    for i, (radius, r) in enumerate(zip(slide, placement_r, strict=True)):
        if radius:
            start = placement_p[i] if i else [0.0, 0.0, 0.0]
            ends = (float(model.lowerPositionLimit[i]), float(model.upperPositionLimit[i]))
            ways[i] = max(norm([start[k] + q * r[k][2] for k in range(3)]) for q in ends)
    return math.fsum(ways)


def rest_pairs(chain: Chain) -> NDArray[np.int64]:
    """Return the pairs (k, 2) of capsules that may collide where none are listed."""
    n = chain.n
    rest = np.clip(np.zeros(n), chain.lower, chain.upper)
    axes, origins, rotations = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3, 3))
    interpreted(forward)(
        chain.placement_r, chain.placement_p, chain.tip_r, chain.tip_p, chain.slide, rest, axes, origins, rotations,
        np.empty((4, 3)),
    )  # fmt: skip
    ends = np.empty((len(chain.capsule_radius), 2, 3))
    interpreted(place_capsules)(chain.capsule_joint, chain.capsule_a, chain.capsule_b, origins, rotations, ends)
    return separate_pairs(chain.capsule_joint, ends, chain.capsule_radius)
