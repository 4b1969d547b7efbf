"""One optimizer and some evaluators on this host, each with its namespace and parameters from launch arguments.

For machines with ROS 2 Jazzy installed: `ros2 launch mobo study.launch.py study_name:=first evaluators:=4`.
Not run in mobo's CI, whose ROS 2 comes as Python wheels without `launch`.
"""

from __future__ import annotations

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, EmitEvent, OpaqueFunction, RegisterEventHandler
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

# name: (default, description); an empty one leaves the node's own default.
_OPTIMIZER = {
    "study_name": ("study", "name of the study"),
    "n_trials": ("1000", "trials the bag shall hold in all"),
    "n_joints": ("6", "joints of an arm"),
    "sampler": ("tpe", "tpe, paper or random"),
    "seed": ("0", "of the sampler"),
    "in_flight": ("", "trials asked before the first of them is told"),
    "spec": ("paper", "a preset or a YAML file"),
    "bag": ("", "folder of the bag; empty: bags/<study_name>"),
    "resume": ("true", "continue the bag if it exists"),
}
_EVALUATOR = {
    "workers": ("1", "candidates each evaluator evaluates at a time"),
    "threads": ("1", "threads of each worker"),
}
_HERE = {
    "evaluators": ("2", "evaluator nodes to start"),
    "namespace": ("", "of all nodes; one study to a namespace"),
}
# Parameters that are text, whatever they look like.
_TEXT = ("study_name", "sampler", "spec", "bag")


def _value(name: str, text: str) -> ParameterValue | bool | int:
    if name in _TEXT:
        return ParameterValue(text, value_type=str)
    return text.lower() == "true" if name == "resume" else int(text)


def _nodes(context: LaunchContext) -> list[Node | RegisterEventHandler]:
    given = {name: LaunchConfiguration(name).perform(context) for name in {**_OPTIMIZER, **_EVALUATOR, **_HERE}}

    def node(executable: str, name: str, parameters: dict[str, tuple[str, str]]) -> Node:
        values = {key: _value(key, given[key]) for key in parameters if given[key]}
        return Node(
            package="mobo", executable=executable, name=name, namespace=given["namespace"], output="screen",
            parameters=[values],
        )  # fmt: skip

    optimizer = node("optimizer", "optimizer", _OPTIMIZER)
    evaluators = [node("evaluator", f"evaluator_{i}", _EVALUATOR) for i in range(int(given["evaluators"]))]
    # The study is over when the optimizer is.
    over = OnProcessExit(target_action=optimizer, on_exit=[EmitEvent(event=Shutdown(reason="the optimizer ended"))])
    return [optimizer, *evaluators, RegisterEventHandler(over)]


def generate_launch_description() -> LaunchDescription:
    """Return what `ros2 launch` starts."""
    arguments = {**_OPTIMIZER, **_EVALUATOR, **_HERE}
    return LaunchDescription(
        [
            *(DeclareLaunchArgument(name, default_value=value, description=text)
              for name, (value, text) in arguments.items()),
            OpaqueFunction(function=_nodes),
        ]
    )  # fmt: skip
