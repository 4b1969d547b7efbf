"""Link lengths as text for people, which ``mobo evaluate --lengths`` takes as it stands."""

from __future__ import annotations

import math
from collections.abc import Sequence

# Digits after the point: of a tenth of a millimetre, and the most there are.
LEAST_DIGITS = 4
_MOST_DIGITS = 9
# m; within it, lengths add up to a total, see mobo_core.design.Design.check_total.
_SAME_TOTAL = 5e-7


def lengths_text(lengths: Sequence[float]) -> str:
    """Return lengths, in m, as ``0.0500,0.2502,…``: rounded so that they still add up to the arm's length.

    All have the same digits, four if that will do for the sum. What rounding each down leaves over goes, a unit each,
    to those it cut most from, so that each is within a unit of its last digit.
    """
    total = math.fsum(lengths)
    if not (all(length >= 0 for length in lengths) and total < 1e6):
        return ",".join(str(length) for length in lengths)  # a bag may claim anything
    for digits in range(LEAST_DIGITS, _MOST_DIGITS + 1):
        scale = 10**digits
        units = [math.floor(length * scale) for length in lengths]
        over = round(total * scale) - sum(units)
        if abs(round(total * scale) / scale - total) <= _SAME_TOTAL and 0 <= over <= len(units):
            break
    most_cut = sorted(range(len(units)), key=lambda i: (units[i] - lengths[i] * scale, i))
    for i in most_cut[: max(over, 0)]:
        units[i] += 1
    return ",".join(f"{unit / scale:.{digits}f}" for unit in units)
