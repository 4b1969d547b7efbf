"""Arms, and libraries to hold them against, for the tests of evaluation."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

from mobo_core.design import Design, DesignSpace, to_urdf
from mobo_core.evaluation import EvaluationSpec
from mobo_core.evaluation.chain import Array, Chain
from mobo_core.evaluation.kernel.configuration import forward, gravity_torque

LENGTHS = {
    "PRRYPY": (0.06, 0.27, 0.16, 0.11, 0.0, 0.0),
    "YPPYPY": (0.05, 0.25, 0.2, 0.05, 0.0, 0.05),
    "RPYPRP": (0.0, 0.3, 0.1, 0.1, 0.05, 0.05),
    "YPYPYPR": (0.1, 0.1, 0.15, 0.1, 0.1, 0.0, 0.05),
}


def arm(joints: str, lengths: tuple[float, ...] = (), **space: Any) -> str:
    """Return the URDF of a design of 0.6 m."""
    return to_urdf(Design(joints, lengths or LENGTHS[joints]), DesignSpace(**space))


def small_spec(**values: Any) -> EvaluationSpec:
    """Return a spec of 12 voxels with 10 poses each, all around the base; ``values`` over it."""
    box = {"workspace_min": (-0.45, -0.3, 0.0), "workspace_max": (0.45, 0.3, 0.6), "voxel_size": 0.3}
    return EvaluationSpec.of({**box, "poses_per_voxel": 10, **values})


def _body(name: str, mass: float, com: str, shape: str = "") -> str:
    collision = f"<collision>{shape}</collision>" if shape else ""
    inertia = '<inertia ixx="0.02" ixy="0.001" ixz="0" iyy="0.03" iyz="-0.002" izz="0.01"/>'
    return (
        f'<link name="{name}"><inertial><origin xyz="{com}" rpy="0.1 0 0"/><mass value="{mass}"/>{inertia}'
        f"</inertial>{collision}</link>"
    )


def _joint(name: str, kind: str, ends: tuple[str, str], xyz: str, rpy: str, rest: str = "") -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{ends[0]}"/><child link="{ends[1]}"/>'
        f'<origin xyz="{xyz}" rpy="{rpy}"/>{rest}</joint>'
    )


def _turning(lower: float, upper: float, axis: str = "0 0 1") -> str:
    return f'<axis xyz="{axis}"/><limit lower="{lower}" upper="{upper}" effort="87" velocity="2"/>'


def _cylinder(xyz: str, rpy: str, length: float, radius: float = 0.05) -> str:
    return f'<origin xyz="{xyz}" rpy="{rpy}"/><geometry><cylinder radius="{radius}" length="{length}"/></geometry>'


# The kinematics of a Panda with its hand: seven revolute joints, of which the fourth cannot be at zero,
# then two fingers that slide. Masses are rounded, link shapes coarse.
HANDED_ARM = "\n".join(
    [
        '<robot name="handed">',
        _body("base", 2.9, "-0.04 0 0.06"),
        _body("link1", 4.9, "0 -0.02 -0.05", _cylinder("0 0 -0.19", "0 0 0", 0.28)),
        _body("link2", 0.6, "0 -0.07 0.01"),
        _body("link3", 3.2, "0.03 0.04 -0.07", _cylinder("0 0 -0.145", "0 0 0", 0.15)),
        _body("link4", 3.6, "-0.05 0.1 0.03"),
        _body("link5", 1.2, "-0.01 0.04 -0.04", _cylinder("0 0 -0.26", "0 0 0", 0.1)),
        _body("link6", 1.7, "0.06 -0.01 -0.01", _cylinder("0 0 -0.03", "0 0 0", 0.08)),
        _body("link7", 0.7, "0.01 0 0.08"),
        '<link name="link8"/>',
        _body("hand", 0.7, "-0.01 0 0.03", _cylinder("0 0 0.04", "1.5707963267948966 0 0", 0.1, 0.04)),
        _body("left_finger", 0.015, "0 0.01 0.03"),
        _body("right_finger", 0.015, "0 -0.01 0.03"),
        '<link name="tcp"/>',
        _joint("joint1", "revolute", ("base", "link1"), "0 0 0.333", "0 0 0", _turning(-2.9, 2.9)),
        _joint("joint2", "revolute", ("link1", "link2"), "0 0 0", "-1.57079632679 0 0", _turning(-1.8, 1.8)),
        _joint("joint3", "revolute", ("link2", "link3"), "0 -0.316 0", "1.57079632679 0 0", _turning(-2.9, 2.9)),
        _joint("joint4", "revolute", ("link3", "link4"), "0.0825 0 0", "1.57079632679 0 0", _turning(-3.1, -0.1)),
        _joint("joint5", "revolute", ("link4", "link5"), "-0.0825 0.384 0", "-1.57079632679 0 0", _turning(-2.9, 2.9)),
        _joint("joint6", "revolute", ("link5", "link6"), "0 0 0", "1.57079632679 0 0", _turning(0.0, 3.8)),
        _joint("joint7", "revolute", ("link6", "link7"), "0.088 0 0", "1.57079632679 0 0", _turning(-2.9, 2.9)),
        _joint("joint8", "fixed", ("link7", "link8"), "0 0 0.107", "0 0 0"),
        _joint("hand_joint", "fixed", ("link8", "hand"), "0 0 0", "0 0 -0.785398163397"),
        _joint("finger1", "prismatic", ("hand", "left_finger"), "0 0 0.0584", "0 0 0", _turning(0.01, 0.04, "0 1 0")),
        _joint("finger2", "prismatic", ("hand", "right_finger"), "0 0 0.0584", "0 0 0", _turning(0.01, 0.04, "0 -1 0")),
        _joint("tcp_joint", "fixed", ("hand", "tcp"), "0 0 0.1034", "0 0 0"),
        "</robot>",
    ]
)


def random_arm(seed: int, n: int = 6, slides: tuple[int, ...] = ()) -> str:
    """Return an arm with oblique axes and turned frames, a fixed joint, a continuous one, and a side branch.

    Joints ``slides``, from 1, slide instead.
    """
    rng = np.random.default_rng(seed)

    def triple(size: float) -> str:
        return " ".join(repr(float(v)) for v in rng.uniform(-size, size, 3))

    def unit() -> str:
        axis = rng.normal(size=3)
        return " ".join(repr(float(v)) for v in axis / np.linalg.norm(axis))

    parts = [_body("link0", 1.0, triple(0.1))]
    for i in range(1, n + 1):
        limits = _turning(-2.0 - 0.1 * i, 2.5, unit()) if i != 3 else f'<axis xyz="{unit()}"/>'
        kind = "revolute" if i != 3 else "continuous"
        if i in slides:
            kind = "prismatic"
            limits = _turning(-0.1 * i, 0.3, unit()) + f'<slide radius="{0.02 * i}"/>'
        shape = _cylinder(triple(0.1), triple(3.0), float(rng.uniform(0.02, 0.1)), 0.02)
        parts.append(_body(f"link{i}", float(rng.uniform(0.2, 2.0)), triple(0.1), shape))
        parts.append(_joint(f"turn{i}", kind, (f"link{i - 1}", f"link{i}"), triple(0.15), triple(3.0), limits))
    parts.append(_body("flange", 0.3, triple(0.05)))
    parts.append(_joint("bolt", "fixed", (f"link{n}", "flange"), triple(0.1), triple(3.0)))
    parts.append(_body("arm2", 0.8, triple(0.2)))
    parts.append(_joint("swing", "revolute", ("link2", "arm2"), triple(0.1), triple(3.0), _turning(0.3, 1.0, unit())))
    return '<robot name="random">' + "".join(parts) + "</robot>"


class KernelView:
    """What the kernel computes at a configuration, with the work arrays that it wants."""

    def __init__(self, chain: Chain, q: Array) -> None:
        n = chain.n
        self.axes, self.origins, self.rotations = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3, 3))
        self.tip = np.empty((4, 3))
        self._chain = chain
        forward(
            chain.placement_r, chain.placement_p, chain.tip_r, chain.tip_p, chain.slide, np.asarray(q, float),
            self.axes, self.origins, self.rotations, self.tip,
        )  # fmt: skip

    def torque(self, gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)) -> Array:
        """Return the joint torques that hold the arm, shape (n,)."""
        torque = np.empty(self._chain.n)
        chain = self._chain
        norm = gravity_torque(
            chain.mass, chain.com, chain.slide, np.array(gravity), self.axes, self.origins, self.rotations, torque
        )  # fmt: skip
        assert norm == float(np.sqrt(sum(t * t for t in torque[::-1])))
        return torque


class WholeRobot:
    """Pinocchio's model of a URDF as it stands, with every joint in it."""

    def __init__(self, urdf: str) -> None:
        self.model = pin.buildModelFromXML(urdf)
        self.data = self.model.createData()

    def configuration(self, joints: tuple[str, ...], q: Array) -> Array:
        """Return the configuration with ``joints`` at ``q``, and all others nearest zero within their limits."""
        full = pin.neutral(self.model)
        for i in range(1, self.model.njoints):
            joint, name = self.model.joints[i], self.model.names[i]
            at = joint.idx_q
            if name not in joints:
                full[at] = np.clip(0.0, self.model.lowerPositionLimit[at], self.model.upperPositionLimit[at])
            elif joint.nq == 2:
                angle = q[joints.index(name)]
                full[at : at + 2] = np.cos(angle), np.sin(angle)
            else:
                full[at] = q[joints.index(name)]
        return full

    def columns(self, joints: tuple[str, ...]) -> list[int]:
        """Return where the velocities of ``joints`` stand."""
        return [self.model.joints[self.model.getJointId(name)].idx_v for name in joints]

    def tip(self, joints: tuple[str, ...], q: Array, tip: str) -> Any:
        """Return the pose of the link ``tip``."""
        pin.framesForwardKinematics(self.model, self.data, self.configuration(joints, q))
        return self.data.oMf[self.model.getFrameId(tip, pin.BODY)]

    def torque(self, joints: tuple[str, ...], q: Array) -> Array:
        """Return the torques of ``joints`` against gravity (0, 0, -9.81)."""
        whole = pin.computeGeneralizedGravity(self.model, self.data, self.configuration(joints, q))
        return whole[self.columns(joints)]
