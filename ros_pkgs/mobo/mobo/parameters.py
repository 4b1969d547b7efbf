"""The parameters of the nodes, in one place: declared from here, printed by --help, listed in the README."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.exceptions import ParameterException
from rclpy.node import Node

from mobo_core.errors import InputError


@dataclass(frozen=True)
class Parameter:
    """A parameter of a node: its default fixes its type; ``low`` and ``high`` bound a number."""

    name: str
    default: Any
    description: str
    low: float = -math.inf
    high: float = math.inf

    def descriptor(self) -> ParameterDescriptor:
        """Return what ROS is told of the parameter; it then refuses values out of range."""
        described = ParameterDescriptor(description=self.description, read_only=True)
        if math.isfinite(self.low) and math.isfinite(self.high):
            if isinstance(self.default, float):
                bounds = FloatingPointRange(from_value=float(self.low), to_value=float(self.high))
                described.floating_point_range = [bounds]
            else:
                described.integer_range = [IntegerRange(from_value=int(self.low), to_value=int(self.high), step=1)]
        return described


_MANY = 2**31 - 1
_LONG_S = 1e6

OPTIMIZER = (
    Parameter("study_name", "study", "name of the study"),
    Parameter("n_trials", 1000, "trials the bag shall hold in all", 1, _MANY),
    Parameter("n_startup_trials", 100, "random trials before the sampler's model takes over", 1, _MANY),
    Parameter("n_joints", 6, "joints of an arm; wins over the space file", 1, 12),
    Parameter("space", "", "YAML file of the design space; empty: the paper's"),
    Parameter("lengths", "fractions", "how link lengths are drawn: fractions or sequential (the paper's)"),
    Parameter(
        "sampler",
        "tpe",
        "tpe, tpe_univariate, paper (sequential), nsga2, como or random; paper, como: one in flight unless set",
    ),
    Parameter("seed", 0, "of the sampler only; that of targets and IK starts is the spec's", 0, 2**63 - 1),
    Parameter("in_flight", 8, "trials asked before the first of them is told; part of the study's function", 1, 10000),
    Parameter("spec", "paper", "what is asked of an arm: a preset (paper, paper_fine, mobo) or a YAML file"),
    Parameter("bag", "", "folder of the bag; empty: bags/<study_name>"),
    Parameter("resume", False, "continue the bag if it exists; without it an existing bag is refused"),
    Parameter("lease_s", 10.0, "s, after which a candidate no heartbeat names goes to another evaluator", 0.5, _LONG_S),
    Parameter("max_attempts", 3, "failed evaluations after which a trial is told as failed", 1, 1000),
    Parameter("evaluation_timeout_s", 600.0, "s, longest evaluation", 1.0, _LONG_S),
)

_EVALUATION = (
    Parameter("threads", 1, "threads of each worker", 1, 1024),
    Parameter("engine", "kernel", "kernel, reference (slow, the oracle) or simulated (sleeps, invents values)"),
    Parameter("simulated_s", 0.1, "s of sleep in a simulated evaluation", 0.0, _LONG_S),
    Parameter("memory_mb", 0, "MB of data each worker may hold; 0: no limit", 0, 2**31 - 1),
)

EVALUATOR = (
    Parameter("workers", os.cpu_count() or 1, "candidates evaluated at a time, a process each", 1, 1024),
    *_EVALUATION,
    Parameter("evaluation_timeout_s", 600.0, "s, after which a worker is replaced", 1.0, _LONG_S),
)

STUDY = (
    *OPTIMIZER,
    Parameter("evaluators", 2, "evaluator nodes to start on this host", 1, 1000),
    Parameter("workers", max(1, (os.cpu_count() or 1) // 2), "workers of each evaluator", 1, 1024),
    *_EVALUATION,
)

REPLAY = (
    Parameter("bag", "", "folder of the bag, or one of its .mcap files"),
    Parameter("rate", 1.0, "times the recorded speed; 0: as fast as possible", 0.0, 1e6),
)


def overrides(node: Node) -> set[str]:
    """Return the names of the parameters set from outside."""
    return set(node._parameter_overrides)  # rclpy offers no public way to see those not declared


def declare(node: Node, parameters: tuple[Parameter, ...]) -> dict[str, Any]:
    """Declare the parameters and return their values.

    Raises:
        InputError: an unknown name, a value of another type or out of range.
    """
    known = {p.name for p in parameters}
    for name in sorted(overrides(node)):
        if name not in known and name != "use_sim_time" and not name.startswith(("qos_overrides.", "start_type")):
            raise InputError(f"unknown parameter {name!r}", where=node.get_name(), expected=", ".join(sorted(known)))
    values = {}
    for p in parameters:
        try:
            values[p.name] = node.declare_parameter(p.name, p.default, p.descriptor()).value
        except (ParameterException, TypeError, ValueError):
            given = node._parameter_overrides[p.name].value
            if isinstance(p.default, float) and isinstance(given, int) and p.low <= given <= p.high:
                # `-p rate:=2` is an integer to ROS; people mean 2.0.
                node._parameter_overrides.pop(p.name)
                values[p.name] = node.declare_parameter(p.name, float(given), p.descriptor()).value
                continue
            kind = {bool: "true or false", int: "a whole number", float: "a number", str: "text"}[type(p.default)]
            bounds = f" from {p.low:g} to {p.high:g}" if math.isfinite(p.low) else ""
            raise InputError(repr(given), where=f"parameter {p.name}", expected=kind + bounds) from None
    return values


def help_text(executable: str, summary: str, parameters: tuple[Parameter, ...], examples: list[str]) -> str:
    """Return what --help prints."""
    width = max(len(p.name) for p in parameters)
    lines = [f"usage: ros2 run mobo {executable} --ros-args -p NAME:=VALUE ...", "", summary, "", "parameters:"]
    for p in parameters:
        default = {True: "true", False: "false"}.get(p.default, p.default) if isinstance(p.default, bool) else p.default
        lines.append(f"  {p.name:{width}}  {p.description} [{default}]")
    lines += ["", "examples:", *(f"  ros2 run mobo {executable} {example}".rstrip() for example in examples)]
    return "\n".join(lines)
