"""Checks the paper's claims on what there is."""

from __future__ import annotations

from collections.abc import Callable

from mobo_core.report.claims import fronts, joints, lengths, performance, symmetry, voxels
from mobo_core.report.claims.claim import Claim, Pair
from mobo_core.report.claims.verdict import Checked, Outcome

_GROUPS = (fronts, performance, symmetry, lengths, voxels, joints)
CLAIMS: tuple[Claim, ...] = tuple(
    sorted((claim for group in _GROUPS for claim in group.CLAIMS), key=lambda claim: int(claim.name[1:]))
)

Progress = Callable[[int, int], None]


def check_claims(
    pair: Pair,
    fair: Pair | None = None,
    progress: Progress = lambda done, total: None,
    *,
    evaluate: bool = True,
) -> list[Checked]:
    """Return the claims that speak of what there is, each checked, in their order.

    Args:
        pair: studies of 6 and 7 joints; claims on both need both.
        fair: an atlas of the same, for second verdicts.
        progress: called with (claims done, claims in all).
        evaluate: whether to check those that evaluate arms.
    """
    chosen = [claim for claim in CLAIMS if pair.has(claim.needs) and (evaluate or not claim.evaluates)]
    found = []
    for done, claim in enumerate(chosen):
        progress(done, len(chosen))
        second = Outcome(tuple(claim.check(fair))) if fair is not None and fair.has(claim.needs) else None
        found.append(Checked(claim.name, claim.text, Outcome(tuple(claim.check(pair))), second))
    progress(len(chosen), len(chosen))
    return found

