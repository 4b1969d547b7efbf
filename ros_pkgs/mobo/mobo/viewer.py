"""What RViz and Foxglove show of a study: the best arm, and its reach and torque as coloured voxels."""

from __future__ import annotations

import numpy as np
from geometry_msgs.msg import Point
from numpy.typing import NDArray
from rclpy.node import Node
from std_msgs.msg import ColorRGBA, String
from visualization_msgs.msg import Marker, MarkerArray

from mobo.runtime import STATUS_QOS
from mobo_core.evaluation.colours import REACH_SCALE, TORQUE_SCALE
from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.messages import Evaluation

Floats = NDArray[np.float64]


class BestArm:
    """Publishes an arm, latched, on ``robot_description`` and ``voxels`` below ``prefix``."""

    def __init__(self, node: Node, prefix: str = "") -> None:
        self._clock = node.get_clock()
        self._description = node.create_publisher(String, prefix + "robot_description", STATUS_QOS)
        self._voxels = node.create_publisher(MarkerArray, prefix + "voxels", STATUS_QOS)
        self._shown: Evaluation | None = None

    def show(self, evaluation: Evaluation, urdf: str, spec: EvaluationSpec) -> None:
        """Publish the arm that this evaluation belongs to, unless it is shown already."""
        if evaluation is self._shown:
            return
        self._shown = evaluation
        self._description.publish(String(data=urdf))
        reach = REACH_SCALE.redness(evaluation.voxel_reach)
        torque = TORQUE_SCALE.redness(evaluation.voxel_torque)
        reached = np.asarray(evaluation.voxel_reach) > 0.0
        centres = spec.voxel_centres()
        side = spec.workspace_max[0] - spec.workspace_min[0]
        markers = [
            self._cubes("reach", centres, reach, spec.voxel_size, 0.0),
            # Beside the arm, so that both maps can be seen at once.
            self._cubes("torque", centres[reached], torque[reached], spec.voxel_size, 1.5 * side),
        ]
        self._voxels.publish(MarkerArray(markers=markers))

    def _cubes(self, name: str, centres: Floats, redness: Floats, size: float, offset_y: float) -> Marker:
        marker = Marker(ns=name, id=0, type=Marker.CUBE_LIST, action=Marker.ADD)
        marker.header.frame_id = "base_link"
        marker.header.stamp = self._clock.now().to_msg()
        marker.pose.position.y = offset_y
        marker.pose.orientation.w = 1.0
        marker.scale.x = marker.scale.y = marker.scale.z = 0.4 * size
        marker.points = [Point(x=x, y=y, z=z) for x, y, z in centres.tolist()]
        marker.colors = [ColorRGBA(r=red, g=1.0 - red, b=0.0, a=0.7) for red in redness.tolist()]
        return marker
