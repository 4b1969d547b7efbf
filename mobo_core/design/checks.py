"""Whether the settings of a design space fit together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from mobo_core.design.joints import JOINTS
from mobo_core.design.lengths import ROUNDING, Links, text_of
from mobo_core.design.numbers import Several, ends, of_joint
from mobo_core.errors import InputError


def check_letters(name: str, letters: str) -> None:
    """Raise ValueError unless they are distinct letters of joint types."""
    if not letters or len(set(letters)) != len(letters) or any(letter not in JOINTS for letter in letters):
        raise ValueError(f"{name} to be distinct letters of {''.join(JOINTS)}")


def check_counts(n_joints: int, lists: Mapping[str, object]) -> None:
    """Raise ValueError unless each setting that is a list has one entry for each joint."""
    for name, value in lists.items():
        if isinstance(value, tuple) and value and len(value) != n_joints:
            raise ValueError(f"{name} to have {n_joints} entries, one a joint, not {len(value)}")


def check_bounds(least: float, longest: float, zero_lengths: str) -> None:
    """Raise ValueError if the shortest link is longer than the longest, or nothing keeps a link from zero."""
    if least > longest:
        raise ValueError(f"min_length {least:g} m to be at most max_length, {longest:g} m")
    if zero_lengths != "allowed" and least == 0.0:
        raise ValueError(f"a min_length above 0 for zero_lengths: {zero_lengths}")


def check_motors(n_joints: int, radius: Several, length: Several) -> None:
    """Raise ValueError if a motor has a length but no radius, or a body of no length."""
    for i in range(n_joints):
        if of_joint(length, i) > 0.0 and of_joint(radius, i) == 0.0:
            raise ValueError(f"a motor_radius above 0 for a motor_length of {of_joint(length, i):g} m")


def check_total(links: Links, total: Several) -> None:
    """Raise ValueError, naming the bound that bites, unless the links can add up to all of ``total``, in m."""
    low, high = ends(total)
    possible = links.totals
    if any(a - ROUNDING <= low and high <= b + ROUNDING for a, b in possible):
        return
    least, most = possible[0][0], possible[-1][1]
    free = sum(length is None for length in links.fixed)
    fixed = sum(length for length in links.fixed if length is not None)
    more = f" and {fixed:g} m of fixed_lengths" if free < len(links.fixed) else ""
    if not free:
        raise ValueError(f"total_length to be the sum of fixed_lengths, {fixed:.9g} m")
    if high > most + ROUNDING:
        links_of = f"{_links(free)} of max_length {links.longest:g} m"
        raise ValueError(f"total_length of at most {most:.9g} m: {links_of}{more}")
    if low < least - ROUNDING:
        never_zero = sum(length is None and not zero for length, zero in zip(links.fixed, links.zero, strict=True))
        links_of = f"{_links(never_zero)} of min_length {links.least:g} m"
        raise ValueError(f"total_length of at least {least:.9g} m: {links_of}{more}")
    expected = f"{text_of(possible)} m, with {_links(free)} of {links.least:g} to {links.longest:g} m{more}"
    raise ValueError(f"total_length within {expected}")


def _links(n: int) -> str:
    return f"{n} link{'s' * (n != 1)}"


def check_letters_of(sampled: str, places: Sequence[str]) -> None:
    """Raise InputError unless each place has a joint that may be drawn there."""
    if len(sampled) != len(places):
        raise InputError(f"{len(sampled)} joints", where="joints", expected=f"{len(places)}")
    for i, (letter, letters) in enumerate(zip(sampled, places, strict=True), start=1):
        if letter not in letters:
            at = "" if len(set(places)) == 1 else f" at place {i}"
            raise InputError(f"joint {letter!r}{at}", where="joints", expected=f"letters of {letters}")


def check_in(name: str, value: float, allowed: Several, rounding: float) -> float:
    """Return ``value``, put to the nearest end of a range that it misses by rounding.

    Raises:
        InputError: it misses it by more.
    """
    low, high = ends(allowed)
    if not low - rounding <= value <= high + rounding:
        wanted = f"{low:.9g}" if low == high else f"{low:.9g} to {high:.9g}"
        raise InputError(f"{name} is {value:.9g}", where=name, expected=wanted)
    return min(max(value, low), high)
