"""One optimizer and some evaluators on this host, each with its namespace and parameters from launch arguments.

For machines with ROS 2 Jazzy installed: `ros2 launch mobo study.launch.py study_name:=first evaluators:=4`.
All parameters of the study node are arguments; those not given keep the nodes' own defaults. mobo's CI, whose ROS 2
comes as Python wheels without `launch`, runs it against a stand-in for that.
"""

from __future__ import annotations

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, EmitEvent, OpaqueFunction, RegisterEventHandler
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from mobo_core.coordination.options import EvaluatorOptions, OptimizerOptions, StudyOptions
from mobo_core.coordination.parameters import Parameter, parameters
from mobo_core.settings import Settings

_ARGUMENTS = {parameter.name: parameter for parameter in parameters(StudyOptions)}
# These have no default of the nodes' own here: each evaluator would take all cores.
_SHOWN = ("evaluators", "workers")


def _default(parameter: Parameter) -> str:
    return parameter.shown_default if parameter.name in _SHOWN else ""


def _nodes(context: LaunchContext) -> list[Node | RegisterEventHandler]:
    def text(name: str) -> str:
        return LaunchConfiguration(name).perform(context)

    def node(options: type[Settings], executable: str, name: str) -> Node:
        values = {
            field: ParameterValue(text(field), value_type=type(_ARGUMENTS[field].default))
            for field in options.model_fields
            if text(field)
        }
        return Node(
            package="mobo", executable=executable, name=name, namespace=text("namespace"), output="screen",
            parameters=[values],
        )  # fmt: skip

    optimizer = node(OptimizerOptions, "optimizer", "optimizer")
    evaluators = [node(EvaluatorOptions, "evaluator", f"evaluator_{i}") for i in range(int(text("evaluators")))]
    # The study is over when the optimizer is.
    over = OnProcessExit(target_action=optimizer, on_exit=[EmitEvent(event=Shutdown(reason="the optimizer ended"))])
    return [optimizer, *evaluators, RegisterEventHandler(over)]


def generate_launch_description() -> LaunchDescription:
    """Return what `ros2 launch` starts."""
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(
                    p.name, default_value=_default(p), description=f"{p.description} [{p.shown_default}]"
                )
                for p in _ARGUMENTS.values()
            ),
            DeclareLaunchArgument("namespace", default_value="", description="of all nodes; one study to a namespace"),
            OpaqueFunction(function=_nodes),
        ]
    )
