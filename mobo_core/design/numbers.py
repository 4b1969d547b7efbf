"""Settings that are a number or several: one for each joint, or the ends of a range."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from pydantic import GetCoreSchemaHandler
from pydantic_core import CoreSchema, core_schema

# One number, or one for each joint, or the two ends of a range.
Several = float | tuple[float, ...]
# One number, or for each joint a number or the two ends of a range.
Ranges = float | tuple[Several, ...]
Given = tuple[float | None, ...]


@dataclass(frozen=True)
class Numbers:
    """Checks a field that people write as a number or a list of numbers, by ``Annotated``.

    Attributes:
        low, high: bounds of each number.
        above: whether ``low`` itself is refused.
        many: what a list is: one number for each ``joint``, the ends of a ``range``, or for each joint a number or
            nothing (``given``), or a number or the ends of a range (``ranges``).
        angle: whether each may be text such as ``135deg``; a number is in rad.
        unit: for people.
    """

    low: float
    high: float
    above: bool = False
    many: Literal["joint", "range", "given", "ranges"] = "joint"
    angle: bool = False
    unit: str = ""

    def __get_pydantic_core_schema__(self, source: object, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Have pydantic call :meth:`check`."""
        return core_schema.no_info_plain_validator_function(self.check)

    def check(self, value: object) -> Several | Given | Ranges:
        """Return the number, or the numbers as a tuple.

        Raises:
            ValueError: says what was expected.
        """
        if self.many == "given":
            if value is None:
                return ()
            if not isinstance(value, list | tuple):
                raise ValueError("a list, for each joint a length in m or null")
            return tuple(None if each is None else self._one(each) for each in value)
        if not isinstance(value, list | tuple):
            return self._one(value)
        if self.many == "ranges":
            return tuple(self._range(each) if isinstance(each, list | tuple) else self._one(each) for each in value)
        return self._range(value) if self.many == "range" else tuple(self._one(each) for each in value)

    def _range(self, value: list[object] | tuple[object, ...]) -> tuple[float, ...]:
        numbers = tuple(self._one(each) for each in value)
        if not (len(numbers) == 2 and numbers[0] < numbers[1]):
            raise ValueError("a number, or a range [low, high] with low < high")
        return numbers

    def _one(self, value: object) -> float:
        number = self._read(value)
        if not math.isfinite(number):
            raise ValueError("a finite number")
        if number < self.low or (self.above and number == self.low):
            raise ValueError(f"greater than {'' if self.above else 'or equal to '}{self.low:g}")
        if number > self.high:
            degrees = self.angle and "deg" not in str(value) and number <= math.degrees(self.high)
            hint = f" rad; degrees are written {number:g}deg" if degrees else ""
            raise ValueError(f"less than or equal to {self.high:.6g}{hint}")
        return number

    def _read(self, value: object) -> float:
        expected = "a number in rad, or text such as 135deg" if self.angle else "a valid number"
        if isinstance(value, bool) or not isinstance(value, int | float | str):
            raise ValueError(expected)
        unit: Callable[[float], float] = float
        if isinstance(value, str) and self.angle:
            value = value.strip().removesuffix("rad")
            if value.endswith("deg"):
                value, unit = value.removesuffix("deg"), math.radians
        try:
            return unit(float(value))
        except (ValueError, OverflowError):
            raise ValueError(expected) from None


def ends(value: Several) -> tuple[float, float]:
    """Return the ends of a range; of a number twice the same."""
    return (value[0], value[1]) if isinstance(value, tuple) else (value, value)


def of_joint(value: Several, index: int) -> float:
    """Return the number of one joint, ``index`` from 0."""
    return value[index] if isinstance(value, tuple) else value


def middle(value: Several) -> float:
    """Return the number, or the middle of the range."""
    low, high = ends(value)
    return low if low == high else 0.5 * (low + high)


def text_of(value: Several) -> str:
    """Return the number or range for people: ``0.6``, or ``0.4 to 0.8``."""
    return " to ".join(f"{each:g}" for each in dict.fromkeys(ends(value)))
