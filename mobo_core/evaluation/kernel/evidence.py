"""How many attempts a pose is worth, and which to give up: the rules of ``complete`` (rules 2). Compiled."""

from __future__ import annotations

import numpy as np

from mobo_core.evaluation.kernel import compiled

# What follows was fitted to attempts of 40 designs that a 6-DOF study met and of 32 random arms: the fewest
# iterations at which one reachable pose in 1,000 is missed. Errors are squared (m^2, by the weight, and rad^2).
# An attempt is given up if after 1, 2, … iterations its error is above this,
GIVEN_UP = np.array((6.0, 2.0, 1.0, 0.5, 0.1, 0.06, 0.03, 0.01))
# or above this and above that share of the error one iteration before.
SLOW = np.array((5.0, 1.5, 0.5, 0.3, 0.06, 0.03, 0.02, 0.01))
SLOW_SHARE = np.array((0.75, 1.8, 0.75, 0.9, 0.3, 0.3, 0.3, 0.3))
# A pose is worth so many attempts, where its least error (after one iteration at least) is not below
EVIDENCE = np.array((16.2, 1.19, 0.451, 0.236, 0.0472, 0.0035))
WORTH = np.array((2, 5, 8, 12, 18, 34))
# this; and so many, where it is, or where an attempt ended in self-collision.
MOST_WORTH = 62
# So many attempts start near the pose, the others blindly; those are judged as if PATIENCE iterations younger.
NEAR_STARTS, PATIENCE = 20, 3
# Attempts from blind starts once a pose is reached.
BLIND = 2
# A joint that turns this far (rad) holds every angle: it moves without limits, and is brought between them at the end.
TURN = 6.283185307179586


@compiled
def worth(error):
    """Return how many attempts a pose is worth whose least error so far is ``error``."""
    for i in range(len(EVIDENCE)):
        if error > EVIDENCE[i]:
            return WORTH[i]
    return MOST_WORTH


@compiled
def hopeless(iteration, error, before, enough):
    """Return whether to give up an attempt whose error now is ``error``, and was ``before`` an iteration ago.

    An error below ``enough`` is never hopeless.
    """
    if iteration < 1 or error <= enough:
        return False
    i = min(iteration, len(GIVEN_UP)) - 1
    return error > GIVEN_UP[i] or (error > SLOW[i] and error > SLOW_SHARE[i] * before)


@compiled
def bring_between_limits(q, lower, upper):
    """Turn joints of more than a full turn, by full turns, to the angle nearest to the middle of their limits."""
    for k in range(q.shape[0]):
        if upper[k] - lower[k] >= TURN:
            middle = 0.5 * (lower[k] + upper[k])
            while q[k] > middle + 0.5 * TURN:
                q[k] -= TURN
            while q[k] < middle - 0.5 * TURN:
                q[k] += TURN
            q[k] = min(max(q[k], lower[k]), upper[k])
