"""How much is attempted to reach a pose, by the rules of ``ik_mode: complete`` from number 2 on."""

from __future__ import annotations

import numpy as np

from mobo_core.evaluation.kernel.arguments import Effort

# Rules 2, fitted to attempts of 40 designs that a 6-DOF study met and of 32 random arms: the fewest iterations at which
# one reachable pose in 1,000 is missed.
RULES_2 = Effort(
    given_up=np.array((6.0, 2.0, 1.0, 0.5, 0.1, 0.06, 0.03, 0.01)),
    slow=np.array((5.0, 1.5, 0.5, 0.3, 0.06, 0.03, 0.02, 0.01)),
    slow_share=np.array((0.75, 1.8, 0.75, 0.9, 0.3, 0.3, 0.3, 0.3)),
    evidence=np.array((16.2, 1.19, 0.451, 0.236, 0.0472, 0.0035)),
    worth=np.array((2, 5, 8, 12, 18, 34)),
    most_worth=62,
    near_starts=20,
    patience=3,
    blind=2,
    blind_iterations=0,
    most_collided=62,
    most_reached=62,
)
# Rules 3, of seven joints or more: poses nearly reached are worth many more attempts, those whose solutions were in
# collision too, others fewer; and twice as many blind attempts, which leave less of the bias of chosen starts.
# docs/evaluation.md says by which arms the numbers were chosen.
_PATIENT = RULES_2._replace(
    given_up=0.8 * RULES_2.given_up,
    slow=0.8 * RULES_2.slow,
    evidence=np.array((16.2, 1.19, 0.451, 0.236, 0.0472, 0.0035, 0.0012)),
    worth=np.array((2, 4, 6, 8, 12, 28, 90)),
    most_worth=300,
    most_collided=300,
    patience=2,
    blind=4,
)


def effort(rules: int, joints: int, iterations: int) -> Effort:
    """Return what rules 2 or 3 ask for an arm of so many joints, with attempts of up to ``iterations``."""
    chosen = RULES_2 if rules == 2 or joints <= 6 else _PATIENT
    return chosen._replace(blind_iterations=iterations)
