"""The options of a node as ROS parameters: declared with the fields' bounds and texts, read back checked."""

from __future__ import annotations

from typing import TypeVar

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.exceptions import ParameterException
from rclpy.node import Node

from mobo_core.coordination.arguments import OF_ROS, nearest
from mobo_core.coordination.parameters import Parameter, Value, parameters
from mobo_core.errors import InputError
from mobo_core.settings import Settings

Options = TypeVar("Options", bound=Settings)


def descriptor(parameter: Parameter) -> ParameterDescriptor:
    """Return what ROS is told of a parameter; it then refuses values out of range."""
    described = ParameterDescriptor(description=parameter.description, read_only=True)
    low, high = parameter.low, parameter.high
    if parameter.is_bounded and isinstance(parameter.default, float):
        described.floating_point_range = [FloatingPointRange(from_value=float(low), to_value=float(high))]
    elif parameter.is_bounded:
        described.integer_range = [IntegerRange(from_value=int(low), to_value=int(high), step=1)]
    return described


def declare(node: Node, options: type[Options]) -> Options:
    """Declare a node's parameters; return their values, those set from outside as its ``model_fields_set``.

    Raises:
        InputError: an unknown name, a value of another type or out of range.
    """
    given = node._parameter_overrides  # rclpy offers no public way to see those not declared
    known = {parameter.name: parameter for parameter in parameters(options)}
    for name in sorted(given):
        if name not in known and not name.startswith(OF_ROS):
            expected = nearest(name, known) or ", ".join(sorted(known))
            raise InputError(f"unknown parameter {name!r}", where=node.get_name(), expected=expected)
    set_outside = known.keys() & given.keys()
    values = {name: _declared(node, parameter) for name, parameter in known.items()}
    return options.of({name: values[name] for name in set_outside}, where="parameters")


def _declared(node: Node, p: Parameter) -> Value:
    try:
        value: Value = node.declare_parameter(p.name, p.default, descriptor(p)).value
        return value
    except (ParameterException, TypeError, ValueError):
        given = node._parameter_overrides[p.name].value
        if isinstance(p.default, float) and isinstance(given, int) and p.low <= given <= p.high:
            # `-p rate:=2` is an integer to ROS; people mean 2.0.
            node._parameter_overrides.pop(p.name)
            node.declare_parameter(p.name, float(given), descriptor(p))
            return float(given)
        raise p.refusal(given) from None
