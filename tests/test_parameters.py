"""Parameters of the nodes: the fields of their options in other words."""

from __future__ import annotations

import runpy
import sys
import types
from pathlib import Path
from typing import Any

import pytest

from mobo_core.coordination.options import EvaluatorOptions, OptimizerOptions, ReplayOptions, StudyOptions
from mobo_core.coordination.parameters import Parameter, help_text, parameters
from mobo_core.design import DesignSpace
from mobo_core.errors import InputError
from mobo_core.evaluation import load_spec
from mobo_core.search.study import StudySettings
from mobo_core.settings import Settings

LAUNCH_FILE = Path(__file__).parent.parent / "ros_pkgs/mobo/launch/study.launch.py"
ALL = (OptimizerOptions, EvaluatorOptions, StudyOptions, ReplayOptions)


def by_name(options: type[Settings]) -> dict[str, Parameter]:
    return {parameter.name: parameter for parameter in parameters(options)}


@pytest.mark.parametrize("options", ALL)
def test_each_has_a_text_and_a_default_within_its_bounds(options: type[Settings]) -> None:
    """And one of the four types that ROS has a word for."""
    for parameter in parameters(options):
        assert parameter.description
        assert type(parameter.default) in (bool, int, float, str)
        if isinstance(parameter.default, int | float) and not isinstance(parameter.default, bool):
            assert parameter.is_bounded and parameter.low <= parameter.default <= parameter.high


@pytest.mark.parametrize("options", ALL)
def test_options_take_the_bounds_and_nothing_beyond(options: type[Settings]) -> None:
    """What ROS is told of a range is what the options accept, to the last whole number."""
    for parameter in parameters(options):
        if not parameter.is_bounded:
            continue
        for value in (parameter.low, parameter.high):
            assert getattr(options.of({parameter.name: value}), parameter.name) == value
        for value in (parameter.low - 1, parameter.high + 1):
            with pytest.raises(InputError, match=f"{parameter.name} = "):
                options.of({parameter.name: value})


@pytest.mark.parametrize(
    ("settings", "names"),
    [(StudySettings, ("sampler", "n_startup_trials", "seed", "in_flight")), (DesignSpace, ("n_joints", "lengths"))],
)
def test_settings_of_a_study_are_taken_over(settings: type[Settings], names: tuple[str, ...]) -> None:
    """Default, bounds and text of a study's settings are not said twice, but for which sampler is the default."""
    here, there = by_name(OptimizerOptions), by_name(settings)
    for name in names:
        its = there[name]
        default = "structured" if name == "sampler" else its.default
        assert (here[name].default, here[name].low, here[name].high) == (default, its.low, its.high)
        assert here[name].description.startswith(its.description)


def test_defaults_make_the_default_settings() -> None:
    """An optimizer told nothing runs the study that StudySettings() is, but with the spec `mobo` and `structured`."""
    assert OptimizerOptions().settings() == StudySettings(spec=load_spec("mobo"), sampler="structured")
    assert StudySettings().sampler == "tpe"  # of bags that do not say
    assert OptimizerOptions().folder == Path("bags/study")


@pytest.mark.parametrize(
    ("given", "in_flight", "lengths"),
    [
        ({"sampler": "paper"}, 1, "sequential"),
        ({"sampler": "paper", "lengths": "fractions"}, 1, "fractions"),
        ({"sampler": "paper", "in_flight": 4}, 4, "sequential"),
        ({"sampler": "tpe"}, 8, "fractions"),
    ],
)
def test_a_sampler_brings_what_was_not_named(given: dict[str, object], in_flight: int, lengths: str) -> None:
    """sampler:=paper means the paper's search, but for what is named otherwise."""
    settings = OptimizerOptions.of(given).settings()
    assert (settings.in_flight, settings.space.lengths) == (in_flight, lengths)


def test_named_joints_win_over_the_space_file(tmp_path: Path) -> None:
    """What the file says holds where nothing is named."""
    (tmp_path / "space.yaml").write_text("{n_joints: 7, lengths: sequential}")
    space = {"space": str(tmp_path / "space.yaml")}
    assert OptimizerOptions.of(space).settings().space.n_joints == 7
    assert OptimizerOptions.of({**space, "n_joints": 5}).settings().space.n_joints == 5


@pytest.mark.parametrize("name", ["", "a/b", ".hidden", "a\nb"])
def test_name_of_a_study_is_plain(name: str) -> None:
    """It becomes a folder's name and is printed."""
    with pytest.raises(InputError, match="study_name = .* a plain name"):
        OptimizerOptions.of({"study_name": name})


def test_help_lists_each_with_its_default() -> None:
    """Line by line, the default in brackets."""
    shown = help_text("study", "Run.", StudyOptions, ["--ros-args"]).splitlines()
    for parameter in parameters(StudyOptions):
        (line,) = [line for line in shown if line.split()[:1] == [parameter.name]]
        assert line.endswith(f"{parameter.description} [{parameter.shown_default}]")
    assert "resume" in by_name(StudyOptions) and "[false]" in "\n".join(shown)


class _Recorded:
    """Any class of launch: keeps what it is made with."""

    def __init__(self, *positional: Any, **named: Any) -> None:
        self.positional, self.named = positional, named


@pytest.fixture
def launch(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """The launch file's functions, run on a stand-in for the package launch."""
    names = {
        "launch": ("LaunchContext", "LaunchDescription"),
        "launch.actions": ("DeclareLaunchArgument", "EmitEvent", "OpaqueFunction", "RegisterEventHandler"),
        "launch.event_handlers": ("OnProcessExit",),
        "launch.events": ("Shutdown",),
        "launch.substitutions": ("LaunchConfiguration",),
        "launch_ros": (),
        "launch_ros.actions": ("Node",),
        "launch_ros.parameter_descriptions": ("ParameterValue",),
    }
    for module, classes in names.items():
        made = types.ModuleType(module)
        for name in classes:
            setattr(made, name, type(name, (_Recorded,), {}))
        monkeypatch.setitem(sys.modules, module, made)
    configuration = sys.modules["launch.substitutions"].LaunchConfiguration  # type: ignore[attr-defined]
    configuration.perform = lambda self, context: context[self.positional[0]]
    return runpy.run_path(str(LAUNCH_FILE))


def test_launch_file_has_the_parameters_of_a_study(launch: dict[str, Any]) -> None:
    """Its arguments are the study node's parameters and a namespace; what is given reaches the right nodes, typed."""
    *arguments, nodes = launch["generate_launch_description"]().positional[0]
    defaults = {argument.positional[0]: argument.named["default_value"] for argument in arguments}
    assert list(defaults) == [*by_name(StudyOptions), "namespace"]
    for argument in arguments[:-1]:
        assert by_name(StudyOptions)[argument.positional[0]].description in argument.named["description"]
    given = defaults | {"evaluators": "2", "workers": "3", "resume": "true", "lease_s": "5", "study_name": "7"}
    optimizer, *evaluators, _ = nodes.named["function"](given)
    (values,) = optimizer.named["parameters"]
    assert {name: (value.positional[0], value.named["value_type"]) for name, value in values.items()} == {
        "study_name": ("7", str), "resume": ("true", bool), "lease_s": ("5", float),
    }  # fmt: skip
    assert [list(node.named["parameters"][0]) for node in evaluators] == [["workers"], ["workers"]]


def test_descriptors_carry_bounds_and_text() -> None:
    """What `ros2 param describe` shows."""
    ros = pytest.importorskip("mobo.parameters")
    for parameter in parameters(StudyOptions):
        told = ros.descriptor(parameter)
        assert told.description == parameter.description and told.read_only
        ranges = [*told.integer_range, *told.floating_point_range]
        assert [(r.from_value, r.to_value) for r in ranges] == (
            [(parameter.low, parameter.high)] if parameter.is_bounded else []
        )
