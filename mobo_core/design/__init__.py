"""What an arm is: its joints and link lengths, the space of such arms, and their description as URDF."""

from mobo_core.design.description import to_urdf
from mobo_core.design.design import Design, effective_joints
from mobo_core.design.space import DesignSpace

__all__ = ["Design", "DesignSpace", "effective_joints", "to_urdf"]
