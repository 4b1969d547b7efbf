"""Random arms, of kinds that no search has chosen: any order, any lengths, wide joint ranges too."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from mobo_core.bench.groups import Arm, DesignList, Listed, Part
from mobo_core.bench.measure import ExhaustiveSearch
from mobo_core.design import Design, DesignSpace
from mobo_core.design.joints import effective_orders
from mobo_core.evaluation.spec import EvaluationSpec

# Joints and joint limit in rad of each kind.
KINDS = tuple((n, limit) for n in (6, 7) for limit in (0.75 * math.pi, 1.5 * math.pi))
# Poses that an arm has to reach.
LEAST_REACHED = 100
# Share of the links that are zero.
ZERO = 0.25
RULE = (
    f"orders uniform over those that can be built, each link zero with probability {ZERO:g}, the others' lengths "
    f"Dirichlet (all 1), scaled to the space's total; arms that an exhaustive search reaches {LEAST_REACHED} poses with"
)


def draws(space: DesignSpace, seed: int) -> Iterator[Design]:
    """Yield random arms of a space, one of fixed joint number and limit, without end.

    The order is uniform over those that can be built. Each link is zero with probability ZERO; the other lengths are
    Dirichlet with all parameters 1, scaled to the total. ``max_length`` binds none of them.
    """
    orders = list(effective_orders(space.n_joints, space.joint_types))
    kind = [space.n_joints, round(1000 * float(np.max(space.joint_limit)))]
    number = 0
    while True:
        rng = np.random.default_rng([seed, *kind, number])
        number += 1
        order = orders[rng.integers(len(orders))]
        shares = np.zeros(space.n_joints)
        while not shares.any():
            shares = rng.exponential(size=space.n_joints) * (rng.random(space.n_joints) >= ZERO)
        yield Design(order, tuple((space.total_ends[1] * shares / shares.sum()).tolist()))


def draw_random(
    spec: EvaluationSpec,
    count: int,
    seed: int,
    progress: Callable[[int, int], None] = lambda done, total: None,
    search: ExhaustiveSearch | None = None,
) -> DesignList:
    """Return the first ``count`` draws of each kind that reach LEAST_REACHED poses by an exhaustive search."""
    search = search or ExhaustiveSearch()
    parts: list[Part] = []
    for n, limit in KINDS:
        space = DesignSpace(n_joints=n, joint_limit=limit)
        found: list[Listed] = []
        for number, design in enumerate(draws(space, seed)):
            reached = search.reached(Arm.of("random", design, space).urdf, spec)
            if np.count_nonzero(reached) >= LEAST_REACHED:
                found.append(Listed.of_design(design, number))
                progress(len(parts) * count + len(found), len(KINDS) * count)
            if len(found) == count:
                break
        parts.append(Part(space=space, designs=tuple(found)))
    return DesignList(source=f"{count} of each kind, seed {seed}: {RULE}", parts=tuple(parts))
