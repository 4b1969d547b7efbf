"""What is found to be wrong."""

from __future__ import annotations

from typing import NamedTuple

from mobo_core.errors import visible


class Fault(NamedTuple):
    """Something in a bag that is not as it must be.

    Attributes:
        trial: its number, or -1 if no single one is at fault.
        field: what of it.
        text: what was found and what it should be.
    """

    trial: int
    field: str
    text: str

    def __str__(self) -> str:
        where = f"trial {self.trial}, " if self.trial >= 0 else ""
        return visible(f"{where}{self.field}: {self.text}")
