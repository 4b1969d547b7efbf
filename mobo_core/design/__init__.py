"""What an arm is: its joints and link lengths, the space of such arms, and their description as URDF."""

from mobo_core.design.description import to_urdf
from mobo_core.design.design import Design
from mobo_core.design.joints import JOINTS, JointType, effective_joints
from mobo_core.design.presets import SPACES, load_space
from mobo_core.design.space import DesignSpace

__all__ = [
    "JOINTS", "SPACES", "Design", "DesignSpace", "JointType", "effective_joints", "load_space", "to_urdf",
]  # fmt: skip
