"""What of a pose's orientation counts: all of it, all but the roll about the tool's z axis, or nothing. Compiled.

Where not all of it counts, the error of orientation is that of the z axis alone (twice the sine of half the angle
between the tool's and the pose's, along the axis that turns one to the other), or none; and the angular part of the
Jacobian is projected likewise. So the step spends nothing on what is free.
"""

from __future__ import annotations

import numpy as np

from mobo_core.evaluation.kernel import compiled

FULL, FREE_ROLL, NONE = 0, 1, 2
# By their names in a spec.
ORIENTATIONS = {"full": FULL, "free_roll": FREE_ROLL, "none": NONE}


@compiled
def aim(orientation, target_r, aimed):
    """Write a matrix into ``aimed`` (3, 3), and return a number: with them, starts are compared with a pose.

    The number minus the sum over the products of the matrix's entries with those of a sample's rotation is
    4 sin^2(angle / 2), the angle being that between the orientations, or between the z axes, or 0.
    """
    for r in range(3):
        for c in range(3):
            aimed[r, c] = target_r[r, c] if orientation == 0 else 0.0
        if orientation == 1:
            aimed[r, 2] = 2.0 * target_r[r, 2]
    return np.float32(3.0) if orientation == 0 else np.float32(2.0) if orientation == 1 else np.float32(0.0)
