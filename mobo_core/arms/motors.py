"""Motors to choose from, as people list them in YAML."""

from __future__ import annotations

from typing import Self

from pydantic import Field, field_validator, model_validator

from mobo_core.settings import Settings

_MOST = 500


class Motor(Settings):
    """A motor with its gear."""

    name: str = Field(min_length=1, max_length=60, description="of the motor")
    torque: float = Field(gt=0, le=1e5, description="N m, what it holds at its output")
    mass: float = Field(ge=0, le=1e4, description="kg")
    source: str = Field("", max_length=300, description="where the numbers are from")
    unverified: tuple[str, ...] = Field((), description="which of torque and mass the source does not show")

    @field_validator("unverified")
    @classmethod
    def _numbers(cls, names: tuple[str, ...]) -> tuple[str, ...]:
        if not set(names) <= {"torque", "mass"}:
            raise ValueError("torque, mass or both")
        return names


class Motors(Settings):
    """Motors, and which one each joint has; where that is not said, each is given the lightest that holds."""

    motors: tuple[Motor, ...] = Field(min_length=1, max_length=_MOST, description="to choose from")
    joints: tuple[str, ...] = Field((), max_length=64, description="names of the joints' motors, from the base")

    @classmethod
    def of(cls, values: object, where: str = "") -> Self:
        """Check a mapping, or a list of motors; see :meth:`Settings.of`."""
        return super().of({"motors": values} if isinstance(values, list) else values, where)

    @model_validator(mode="after")
    def _known(self) -> Motors:
        names = [motor.name for motor in self.motors]
        if len(set(names)) < len(names):
            raise ValueError("motors of different names")
        for name in self.joints:
            if name not in names:
                raise ValueError(f"joints' motors of the list, not {name[:60]!r}")
        return self
