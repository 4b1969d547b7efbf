"""A node's parameters, read from the fields of its options: for descriptors, --help, launch files and tables."""

from __future__ import annotations

import math
from dataclasses import dataclass

from pydantic.fields import FieldInfo

from mobo_core.errors import InputError
from mobo_core.settings import Listed, Settings

Value = bool | int | float | str

_KINDS = {bool: "true or false", int: "a whole number", float: "a number", str: "text"}


@dataclass(frozen=True)
class Parameter:
    """A parameter of a node: its default fixes its type; a number lies between ``low`` and ``high``."""

    name: str
    default: Value
    description: str
    low: float = -math.inf
    high: float = math.inf

    @property
    def shown_default(self) -> str:
        """The default as people write it."""
        if isinstance(self.default, bool):
            return str(self.default).lower()
        return f"{self.default:g}" if isinstance(self.default, float) else str(self.default)

    @property
    def is_bounded(self) -> bool:
        """Whether it has both bounds."""
        return math.isfinite(self.low) and math.isfinite(self.high)

    def refusal(self, given: object) -> InputError:
        """Return the error to raise for a value that does not fit."""
        between = f" from {_shown(self.low)} to {_shown(self.high)}" if self.is_bounded else ""
        return InputError(repr(given), where=f"parameter {self.name}", expected=_KINDS[type(self.default)] + between)


def _shown(bound: float) -> str:
    """Return a bound as people read it: all of its digits, unless it is the largest that a parameter can be."""
    return "2^63 - 1" if bound == 2**63 - 1 else f"{bound:.15g}" if isinstance(bound, float) else str(bound)


def parameters(options: type[Settings]) -> tuple[Parameter, ...]:
    """Return the parameters that set the fields of ``options``, in their order."""
    return tuple(_parameter(name, field) for name, field in options.model_fields.items())


def _parameter(name: str, field: FieldInfo) -> Parameter:
    low, high, text = -math.inf, math.inf, field.description or ""
    for bound in field.metadata:
        low = getattr(bound, "ge", low)
        high = getattr(bound, "le", high)
        if hasattr(bound, "lt"):  # of whole numbers alone
            high = bound.lt - 1
        if isinstance(bound, Listed):
            text = f"{bound.names()}; {text}" if text else bound.names()
    default = field.get_default(call_default_factory=True, validated_data={})
    return Parameter(name, default, text, low, high)


def help_text(executable: str, summary: str, options: type[Settings], examples: list[str]) -> str:
    """Return what a node's --help prints."""
    listed = parameters(options)
    width = max(len(p.name) for p in listed)
    lines = [f"usage: ros2 run mobo {executable} --ros-args -p NAME:=VALUE ...", "", summary, "", "parameters:"]
    lines += [f"  {p.name:{width}}  {p.description} [{p.shown_default}]" for p in listed]
    lines += ["", "examples:", *(f"  ros2 run mobo {executable} {example}".rstrip() for example in examples)]
    return "\n".join(lines)
