"""The paper's colour scales of a voxel's reach and torque, from green to red."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray


class ColourScale(NamedTuple):
    """The values at a scale's two ends."""

    green: float
    red: float

    def redness(self, values: ArrayLike) -> NDArray[np.float64]:
        """Return how far towards red each value lies, from 0 to 1; what is beyond an end has its colour."""
        share = (np.asarray(values, np.float64) - self.green) / (self.red - self.green)
        return np.clip(share, 0.0, 1.0)


REACH_SCALE = ColourScale(1.0, 0.0)  # share of poses
TORQUE_SCALE = ColourScale(3.0, 10.0)  # N m
