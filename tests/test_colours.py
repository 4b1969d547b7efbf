"""Colours of voxels."""

from __future__ import annotations

import numpy as np
import pytest

from mobo_core.evaluation.colours import REACH_SCALE, TORQUE_SCALE, ColourScale


@pytest.mark.parametrize("scale", [REACH_SCALE, TORQUE_SCALE])
def test_redness_is_linear_between_the_ends_and_flat_beyond(scale: ColourScale) -> None:
    """0 at the green end, 1 at the red one, whichever of the two is larger."""
    span = scale.red - scale.green
    values = scale.green + span * np.array([-1.0, 0.0, 0.25, 0.5, 1.0, 2.0])
    assert scale.redness(values) == pytest.approx([0.0, 0.0, 0.25, 0.5, 1.0, 1.0])


def test_best_reach_is_green_and_high_torque_red() -> None:
    """The paper's scales: all poses reached, or 3 N m, are green; none, or 10 N m, red."""
    assert REACH_SCALE.redness([1.0, 0.0]).tolist() == [0.0, 1.0]
    assert TORQUE_SCALE.redness([3.0, 10.0]).tolist() == [0.0, 1.0]
