"""How many attempts a pose is worth, and which to give up, by an ``Effort``. Compiled."""

from __future__ import annotations

import numpy as np

from mobo_core.evaluation.kernel import compiled

# A joint that turns this far (rad) holds every angle: it moves without limits, and is brought between them at the end.
TURN = 6.283185307179586


@compiled
def worth_of(error, evidence, worth, most):
    """Return how many attempts a pose is worth whose least error so far is ``error``, at most ``most``."""
    for i in range(evidence.shape[0]):
        if error > evidence[i]:
            return worth[i]
    return most


@compiled
def hopes_of(effort, iterations, enough):
    """Return the errors (3, iterations + 1) above which an attempt so old is given up: see ``Effort``.

    An error below ``enough`` is never given up, and none before the first iteration.
    """
    hopes = np.full((3, iterations + 1), np.inf)
    for age in range(1, iterations + 1):
        i = min(age, effort.given_up.shape[0]) - 1
        hopes[0, age], hopes[1, age] = max(effort.given_up[i], enough), max(effort.slow[i], enough)
        hopes[2, age] = effort.slow_share[i]
    return hopes


@compiled
def bring_between_limits(q, lower, upper, slide):
    """Turn joints of more than a full turn, by full turns, to the angle nearest to the middle of their limits.

    Those that slide (``slide`` above 0) are between them already.
    """
    for k in range(q.shape[0]):
        if upper[k] - lower[k] >= TURN and slide[k] == 0.0:
            middle = 0.5 * (lower[k] + upper[k])
            while q[k] > middle + 0.5 * TURN:
                q[k] -= TURN
            while q[k] < middle - 0.5 * TURN:
                q[k] += TURN
            q[k] = min(max(q[k], lower[k]), upper[k])
