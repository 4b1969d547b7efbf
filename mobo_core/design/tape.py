"""Open numbers: they write down on a tape what is done to them, so that the same can be done to others later."""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any, NamedTuple

Operation = Callable[[Any, Any], Any]


class Step(NamedTuple):
    """One thing done to numbers: ``operation`` of two places, kept in ``target`` or, a condition, as ``expected``."""

    operation: Operation
    a: int
    b: int
    target: int
    expected: bool | None
    name: str


class Tape:
    """The numbers met on one way through a macro, by place, and what was done to them."""

    def __init__(self, inputs: tuple[float, ...]) -> None:
        self.values: list[Any] = list(inputs)
        self.steps: list[Step] = []

    def place(self, value: Any) -> int:
        """Return the place of a number; one that is not open gets one."""
        if isinstance(value, Open):
            return value.place
        self.values.append(value)
        return len(self.values) - 1

    def number(self, name: str, a: Any, b: Any) -> Open:
        """Return what the operation of this name gives, and write it down."""
        i, j = self.place(a), self.place(b)
        target = self.place(OPERATIONS[name](self.values[i], self.values[j]))
        self.steps.append(Step(OPERATIONS[name], i, j, target, None, name))
        return Open(self, target)

    def condition(self, name: str, a: Any, b: Any) -> bool:
        """Return whether the condition of this name holds, and write down that it does or not."""
        i, j = self.place(a), self.place(b)
        result = bool(OPERATIONS[name](self.values[i], self.values[j]))
        self.steps.append(Step(OPERATIONS[name], i, j, -1, result, name))
        return result

    def play(self, inputs: tuple[float, ...]) -> list[Any] | None:
        """Return the values for other inputs, or None if a condition turns out otherwise."""
        values = self.values.copy()
        values[: len(inputs)] = inputs
        for operation, a, b, target, expected, _ in self.steps:
            result = operation(values[a], values[b])
            if expected is None:
                values[target] = result
            elif bool(result) is not expected:
                return None
        return values


class Open:
    """A number that writes down on its tape what is done to it; anything but operators is a TypeError."""

    __slots__ = ("place", "tape")
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, tape: Tape, place: int) -> None:
        self.tape, self.place = tape, place

    def __str__(self) -> str:
        return f"\ue000{self.place}\ue001"

    __repr__ = __str__

    def __bool__(self) -> bool:
        return self.tape.condition("bool", self, None)


def _define(name: str, *, condition: bool = False) -> None:
    def forward(self: Open, other: Any) -> Any:
        if not isinstance(other, (Open, int, float)):
            return NotImplemented
        return (self.tape.condition if condition else self.tape.number)(name, self, other)

    def backward(self: Open, other: Any) -> Any:
        return self.tape.number(name, other, self) if isinstance(other, (int, float)) else NotImplemented

    setattr(Open, f"__{name}__", forward)
    if not condition:
        setattr(Open, f"__r{name}__", backward)


def _define_unary(name: str) -> None:
    setattr(Open, f"__{name}__", lambda self: self.tape.number(name, self, None))


_BINARY = ("add", "sub", "mul", "truediv", "floordiv", "mod", "pow")
_CONDITIONS = ("lt", "le", "gt", "ge", "eq", "ne")
_UNARY: dict[str, Operation] = {
    "neg": lambda a, _: -a, "pos": lambda a, _: +a, "abs": lambda a, _: abs(a), "bool": lambda a, _: bool(a)
}  # fmt: skip
# By the name that stands in a template.
OPERATIONS: dict[str, Operation] = {name: getattr(operator, name) for name in (*_BINARY, *_CONDITIONS)} | _UNARY
for _name in _BINARY:
    _define(_name)
for _name in _CONDITIONS:
    _define(_name, condition=True)
for _name in ("neg", "pos", "abs"):
    _define_unary(_name)
