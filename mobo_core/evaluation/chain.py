"""A serial chain as flat arrays, taken from a Pinocchio model of a checked URDF."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from mobo_core.errors import InputError
from mobo_core.evaluation.kernel.geometry import place_capsules, segment_distance_squared
from mobo_core.evaluation.kernel.posture import forward
from mobo_core.evaluation.urdf import CheckedUrdf, check_urdf
from mobo_core.jit.cache import interpreted

Array = np.ndarray[Any, np.dtype[Any]]

TOUCHING = 1e-9  # m; capsules this close in the zero posture may touch in any


@dataclass(frozen=True)
class Chain:
    """A serial arm of n turning joints. Joint frames are turned so that every joint axis is z.

    Attributes:
        placement_r, placement_p: (n, 3, 3), (n, 3) m; joint frame at angle zero in the joint frame before
            it, the first one in the base frame.
        tip_r, tip_p: (3, 3), (3,) m; the tip in the last joint frame.
        lower, upper: (n,) rad.
        mass, com: (n,) kg, (n, 3) m; what joint i carries up to the next joint, in its joint frame.
        reach_radius: m, farthest the tip can be from the first joint's origin.
        capsule_joint: (c,) joint that carries a capsule, -1 for the base.
        capsule_a, capsule_b: (c, 3) m, ends of its segment in that joint frame.
        capsule_radius: (c,) m.
        pairs: (k, 2) capsules that may collide: carried by different joints, and apart by more than
            TOUCHING in the posture nearest zero within the limits.
        joint_names: (n,) names.
        tip: name of the tip link.
        ignored_shapes: collision shapes that are neither cylinder nor sphere, left out.
        model: the Pinocchio model it was taken from, with these n joints.
        tip_frame: id of the tip's frame in that model.
    """

    placement_r: Array
    placement_p: Array
    tip_r: Array
    tip_p: Array
    lower: Array
    upper: Array
    mass: Array
    com: Array
    reach_radius: float
    capsule_joint: Array
    capsule_a: Array
    capsule_b: Array
    capsule_radius: Array
    pairs: Array
    joint_names: tuple[str, ...]
    tip: str
    ignored_shapes: int
    model: Any
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
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81),
) -> Chain:
    """Check a URDF and return the chain from its root to ``tip`` (by default its only leaf link).

    Joints beside the path are held at the angle nearest zero within their limits; their masses count.

    Raises:
        InputError: as :func:`mobo_core.evaluation.urdf.check_urdf`; or no such tip, several leaves and no
            tip named, no joint on the path, or one on it that does not turn.
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
        if kinds[joint] == "prismatic":
            expected = "revolute, continuous or fixed joints on the way to the tip"
            raise InputError("type 'prismatic'", where=f"urdf joint {joint!r}", expected=expected)
    try:
        model = pin.buildModelFromXML(checked.xml)
        rest = np.clip(0.0, model.lowerPositionLimit, model.upperPositionLimit)
        beside = [i for i in range(1, model.njoints) if model.names[i] not in moving]
        model = pin.buildReducedModel(model, beside, rest) if beside else model
    except (ValueError, RuntimeError) as error:
        raise InputError(f"Pinocchio refuses it ({error})", where="urdf", expected="a URDF robot") from None
    model.gravity.linear = np.array(gravity)
    tip_frame = model.getFrameId(tip, pin.BODY)
    if payload_kg > 0:
        last = model.nv
        at_tip = pin.Inertia(payload_kg, np.zeros(3), np.zeros((3, 3)))
        model.appendBodyToJoint(last, at_tip, model.frames[tip_frame].placement)
    return _flatten(model, tip_frame, tip, checked)


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


def _axis_frame(axis: list[float]) -> list[list[float]]:
    """Return a rotation whose z column is ``axis``; a signed permutation if the axis is one of x, y, z."""
    k = min(range(3), key=lambda i: abs(axis[i]))
    x = [(1.0 if i == k else 0.0) - axis[k] * axis[i] for i in range(3)]
    norm = math.sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])
    x = [v / norm for v in x]
    y = [axis[(i + 1) % 3] * x[(i + 2) % 3] - axis[(i + 2) % 3] * x[(i + 1) % 3] for i in range(3)]
    return [[x[i], y[i], axis[i]] for i in range(3)]


# Products of small matrices are written out: a BLAS may round differently from machine to machine.
def _times(a: Any, b: Any) -> list[list[float]]:
    return [[float(sum(a[i][k] * b[k][j] for k in range(3))) for j in range(3)] for i in range(3)]


def _turn(a: Any, v: Any) -> list[float]:
    return [float(a[i][0] * v[0] + a[i][1] * v[1] + a[i][2] * v[2]) for i in range(3)]


def _transposed(a: Any) -> list[list[float]]:
    return [[float(a[j][i]) for j in range(3)] for i in range(3)]


def _flatten(model: Any, tip_frame: int, tip: str, checked: CheckedUrdf) -> Chain:
    n = model.nv
    data = model.createData()
    pin.computeJointJacobians(model, data, np.zeros(n))
    frames = [_transposed(np.eye(3))]
    placement_r, placement_p, mass, com = [], [], [], []
    for i in range(1, n + 1):
        # Pinocchio gives the Jacobian of a single joint as a vector.
        own = np.reshape(pin.getJointJacobian(model, data, i, pin.LOCAL), (6, n))[3:, i - 1]
        frame = _axis_frame([float(v) for v in own])
        back = _transposed(frames[-1])
        placement = model.jointPlacements[i]
        placement_r.append(_times(_times(back, placement.rotation), frame))
        placement_p.append(_turn(back, placement.translation))
        frames.append(frame)
        inertia = model.inertias[i]
        mass.append(float(inertia.mass))
        com.append(_turn(_transposed(frame), inertia.lever) if inertia.mass > 0 else [0.0, 0.0, 0.0])
    last = _transposed(frames[n])
    tip_placement = model.frames[tip_frame].placement
    tip_p = _turn(last, tip_placement.translation)
    capsules = _capsules(model, checked, frames)
    chain = Chain(
        placement_r=np.array(placement_r),
        placement_p=np.array(placement_p),
        tip_r=np.array(_times(last, tip_placement.rotation)),
        tip_p=np.array(tip_p),
        lower=np.array(model.lowerPositionLimit),
        upper=np.array(model.upperPositionLimit),
        mass=np.array(mass),
        com=np.array(com),
        reach_radius=math.fsum(_norm(p) for p in [*placement_p[1:], tip_p]),
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
    object.__setattr__(chain, "pairs", _pairs(chain))
    return chain


def _norm(p: list[float]) -> float:
    return math.sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2])


def _capsules(model: Any, checked: CheckedUrdf, frames: list[Any]) -> list[tuple[int, list[float], list[float], float]]:
    capsules = []
    for shape in checked.shapes:
        frame = model.frames[model.getFrameId(shape.link, pin.BODY)]
        joint = int(frame.parentJoint)
        rotation = _times(frame.placement.rotation, pin.rpy.rpyToMatrix(*shape.rpy))
        centre = _turn(frame.placement.rotation, shape.xyz)
        back = _transposed(frames[joint])
        ends = []
        for sign in (-0.5, 0.5):
            along = [sign * shape.length * rotation[k][2] for k in range(3)]
            ends.append(_turn(back, [centre[k] + float(frame.placement.translation[k]) + along[k] for k in range(3)]))
        capsules.append((joint - 1, ends[0], ends[1], shape.radius))
    return capsules


def _pairs(chain: Chain) -> Array:
    n, count = chain.n, len(chain.capsule_radius)
    rest = np.clip(np.zeros(n), chain.lower, chain.upper)
    axes, origins, rotations = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3, 3))
    interpreted(forward)(
        chain.placement_r, chain.placement_p, chain.tip_r, chain.tip_p, rest, axes, origins, rotations, np.empty((4, 3))
    )
    ends = np.empty((count, 2, 3))
    interpreted(place_capsules)(chain.capsule_joint, chain.capsule_a, chain.capsule_b, origins, rotations, ends)
    pairs = []
    for i, j in itertools.combinations(range(count), 2):
        if chain.capsule_joint[i] == chain.capsule_joint[j]:
            continue
        squared = interpreted(segment_distance_squared)(ends[i, 0], ends[i, 1], ends[j, 0], ends[j, 1])
        if math.sqrt(squared) - chain.capsule_radius[i] - chain.capsule_radius[j] > TOUCHING:
            pairs.append((i, j))
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)
