"""What an atlas answers: the arms that meet a wish, the best first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mobo_core.atlas.atlas import Atlas
from mobo_core.errors import InputError

# Arms that reach less of the voxels are of no use, unless they are asked for.
FLOOR_SHARE = 0.1


@dataclass(frozen=True)
class Wish:
    """What is wanted of an arm.

    Attributes:
        orders: joint orders; (): any.
        without: letters of joints that it must not have.
        reach_at_least: voxels; None: a tenth of them.
        at_most: value -> the largest that may be.
        least: value to have least of, or "".
        near: m, lengths to be near to; (): none.
    """

    orders: Sequence[str] = ()
    without: str = ""
    reach_at_least: float | None = None
    at_most: Mapping[str, float] = field(default_factory=dict)
    least: str = ""
    near: Sequence[float] = ()


def answer(atlas: Atlas, wish: Wish) -> NDArray[np.int64]:
    """Return the rows that meet a wish: the nearest first, or those with least of what is wanted, or by falling reach.

    Raises:
        InputError: a value, an order or lengths that the atlas has none of.
    """
    values = atlas.values
    for name in (*wish.at_most, *filter(None, [wish.least])):
        if name not in values:
            raise InputError(repr(name), where="value", expected=" or ".join(values))
    known = set(atlas.joints)
    for order in wish.orders:
        if order not in known:
            raise InputError(f"no arm of {order!r:.30}", where="--order", expected=_like(order, known))
    n = atlas.lengths.shape[1]
    if wish.near and len(wish.near) != n:
        raise InputError(f"{len(wish.near)} lengths", where="--near", expected=f"{n}")
    floor = FLOOR_SHARE * atlas.about.n_voxels if wish.reach_at_least is None else wish.reach_at_least
    good = values["reach"] >= floor
    for name, most in wish.at_most.items():
        good &= values[name] <= most
    fitting = {
        joints for joints in known if (not wish.orders or joints in wish.orders) and not set(joints) & set(wish.without)
    }
    good &= np.array([joints in fitting for joints in atlas.joints], bool)
    keys = [np.arange(len(atlas)), values["torque"], -values["reach"]]
    if wish.least:
        keys.append(values[wish.least])
    if wish.near:
        keys.append(distances(atlas, wish.near))
    ranked = np.lexsort(keys)
    return ranked[good[ranked]]


def distances(atlas: Atlas, lengths: Sequence[float]) -> NDArray[np.float64]:
    """Return how far each arm's lengths are from some, m: the root of the sum of the squares."""
    squares: NDArray[np.float64] = np.square(atlas.lengths - np.asarray(lengths)).sum(axis=1)
    return np.sqrt(squares)


def _like(order: str, known: set[str]) -> str:
    import difflib

    close = difflib.get_close_matches(order, sorted(known), n=3, cutoff=0.0)
    return f"one of the atlas's {len(known)} orders, such as {', '.join(close)}" if close else "an atlas with arms"
