"""What RViz and Foxglove show of a study: the best arm, and its reach and torque as coloured voxels."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import Point
from rclpy.node import Node
from std_msgs.msg import ColorRGBA, String
from visualization_msgs.msg import Marker, MarkerArray

from mobo.runtime import STATUS_QOS
from mobo_core.evaluation.spec import EvaluationSpec

# N m: the ends of the paper's colour scale, green to red.
TORQUE_GREEN, TORQUE_RED = 3.0, 10.0


class BestArm:
    """Publishes an arm, latched, on ``robot_description`` and ``voxels`` below ``prefix``."""

    def __init__(self, node: Node, prefix: str = "") -> None:
        self._clock = node.get_clock()
        self._description = node.create_publisher(String, prefix + "robot_description", STATUS_QOS)
        self._voxels = node.create_publisher(MarkerArray, prefix + "voxels", STATUS_QOS)
        self._shown: Any = None

    def show(self, evaluation: Any, urdf: str, spec: EvaluationSpec) -> None:
        """Publish the arm that this evaluation belongs to, unless it is shown already."""
        if evaluation is self._shown:
            return
        self._shown = evaluation
        self._description.publish(String(data=urdf))
        reach = [1.0 - float(share) for share in evaluation.voxel_reach]
        span = TORQUE_RED - TORQUE_GREEN
        torque = [min(max((float(t) - TORQUE_GREEN) / span, 0.0), 1.0) for t in evaluation.voxel_torque]
        reached = [share > 0 for share in evaluation.voxel_reach]
        centres = spec.voxel_centres()
        side = spec.workspace_max[0] - spec.workspace_min[0]
        markers = [
            self._cubes("reach", centres, reach, [True] * len(reach), spec.voxel_size, 0.0),
            # Beside the arm, so that both maps can be seen at once.
            self._cubes("torque", centres, torque, reached, spec.voxel_size, 1.5 * side),
        ]
        self._voxels.publish(MarkerArray(markers=markers))

    def _cubes(
        self, name: str, centres: Any, redness: list[float], shown: list[bool], size: float, offset_y: float
    ) -> Marker:
        marker = Marker(ns=name, id=0, type=Marker.CUBE_LIST, action=Marker.ADD)
        marker.header.frame_id = "base_link"
        marker.header.stamp = self._clock.now().to_msg()
        marker.pose.position.y = offset_y
        marker.pose.orientation.w = 1.0
        marker.scale.x = marker.scale.y = marker.scale.z = 0.4 * size
        for centre, red, show in zip(centres, redness, shown, strict=True):
            if show:
                marker.points.append(Point(x=float(centre[0]), y=float(centre[1]), z=float(centre[2])))
                marker.colors.append(ColorRGBA(r=red, g=1.0 - red, b=0.0, a=0.7))
        return marker
