"""C1, C9, C18: who is on the front."""

from __future__ import annotations

from collections import Counter

import numpy as np

from mobo_core.arms.catalogue import known_arms
from mobo_core.report.claims.claim import Claim, Pair, missing, paper_prefixes
from mobo_core.report.claims.evidence import Arm, Array, Evidence
from mobo_core.report.claims.noise import compared, draws, interval_of, judged, named
from mobo_core.report.claims.verdict import Number, Part
from mobo_core.report.prefixes import PREFIX_LENGTH
from mobo_core.report.table import REACH_FLOOR_SHARE
from mobo_core.search.front import aims_of, pareto_front

_BLOCKS = 20
_RESAMPLES = 400
_FRONTS = 100  # drawn with other poses
_NEAR = 150  # arms that may be on the front with other poses


def stands_out(evidence: Evidence, prefix: str, *, on: bool) -> Part:
    """Return whether a prefix has an arm on the front above the reach floor (``on``), or its best arm is off it.

    Off, it is the arm of the highest reach that counts, as the paper shows those. The margin is how far the arm (on:
    that which stands out most) is from being dominated by any arm of other prefixes (the mirror twin's left out), the
    additive epsilon indicator (Zitzler et al., IEEE T-EC 7(2), 2003): the lesser of the differences in reach and in
    torque, as shares of those of the best arm of all.
    """
    name = f"{prefix} {'on' if on else 'off'} the front"
    if (part := missing(name, evidence, prefix)) is not None:
        return part
    members, apart = evidence.prefixes[prefix], {prefix, evidence.twin(prefix)}
    floor = REACH_FLOOR_SHARE * evidence.spec.n_voxels
    own = [arm for arm in evidence.front_of(members.arms) if arm.reach >= floor] if on else []
    own = own or [members.best]
    rest = evidence.front_of([arm for arm in evidence.arms if arm.joints[:PREFIX_LENGTH] not in apart])
    if not rest or not evidence.searched:
        return Part(name, unsure=evidence.unknown(paper_prefixes(evidence)))
    best = evidence.best
    scale_r, scale_t = max(best.reach, 1e-9), max(best.torque, 1e-9)

    def gap(x_r: Array, x_t: Array, y_r: Array, y_t: Array) -> Array:
        """Return by how much y is better than x in both."""
        better: Array = np.minimum((y_r - x_r) / scale_r, (x_t - y_t) / scale_t)
        return better

    x, y = (np.array([[arm.reach, arm.torque] for arm in arms]) for arms in (own, rest))
    gaps = gap(x[:, :1], x[:, 1:], y[:, 0], y[:, 1])
    i = int(gaps.max(axis=1).argmin())
    pair = [(evidence, own[i]), (evidence, rest[int(gaps[i].argmax())])]
    sign = -1.0 if on else 1.0
    searched = [(evidence, prefix)]
    return compared(
        name, pair, lambda r, t: sign * gap(r[0], t[0], r[1], t[1]),
        raised_by=searched if on else (), lowered_by=() if on else searched,
        numbers=named(pair[:1]) | {"against": pair[1][1].joints},
    )  # fmt: skip


def _c1(pair: Pair) -> list[Part]:
    six = pair.of(6)
    on = [stands_out(six, prefix, on=True) for prefix in ("PRRY", "RPYP", "YPRY")]
    return on + [stands_out(six, prefix, on=False) for prefix in ("YPPY", "YPPP")]


def _c9(pair: Pair) -> list[Part]:
    seven = pair.of(7)
    parts = [] if seven.fair else [_frequency(seven)]
    parts += [stands_out(seven, prefix, on=True) for prefix in ("PRRY", "YPRR")]
    return parts + [stands_out(seven, prefix, on=False) for prefix in ("YPPP", "YPPY", "YPYP")]


def _frequency(seven: Evidence) -> Part:
    """Return whether most of the prefixes that the paper names are among as many that were sampled most."""
    name, names = "named prefixes sampled most", paper_prefixes(seven)
    if not seven.searched:
        return Part(name, unsure=seven.unknown(names))
    prefixes = [arm.joints[:PREFIX_LENGTH] for arm in seven.arms]
    blocks = [Counter(prefixes[i::_BLOCKS]) for i in range(_BLOCKS)]
    every = [sum(blocks, Counter())]
    chance = np.random.default_rng(0)
    for drawn in chance.integers(0, _BLOCKS, (_RESAMPLES, _BLOCKS)):
        every.append(sum((blocks[k] for k in drawn), Counter()))
    shares = [_share_of_most(counts, names) - 0.5 for counts in every]
    numbers: dict[str, Number] = {f"{name} trials": every[0][name] for name in names}
    most = sorted(every[0], key=lambda prefix: (-every[0][prefix], prefix))[: len(names)]
    return judged(name, shares[0], interval_of(np.array(shares), shares[0]),
                  numbers=numbers | {"sampled most": " ".join(most)})  # fmt: skip


def _share_of_most(counts: Counter[str], names: list[str]) -> float:
    most = sorted(counts, key=lambda prefix: (-counts[prefix], prefix))[: len(names)]
    return len(set(most) & set(names)) / len(names)


def _c18(pair: Pair) -> list[Part]:
    return [_strangers(pair.of(6)), _strangers(pair.of(7))]


def _strangers(evidence: Evidence) -> Part:
    """Return whether more than half of the orders on the front are of no known arm, also if poses are drawn anew."""
    name = f"more than half of the front's orders are of no known arm, {evidence.n_joints} joints"
    near = _near(evidence)
    if not near or not evidence.searched:
        return Part(name, unsure=evidence.unknown(paper_prefixes(evidence)))
    orders = list(dict.fromkeys(arm.joints for arm in evidence.front))
    strange = [order for order in orders if not known_arms(order)]
    reach, torque = draws([(evidence, arm) for arm in near])
    aims = aims_of(("reach", "torque"), evidence.spec)
    values = np.array([
        _share_strange([near[i] for i in pareto_front(drawn.tolist(), aims)])
        for drawn in np.moveaxis(np.array([reach, torque]), (0, 1, 2), (2, 1, 0))[:_FRONTS]
    ])  # fmt: skip
    numbers: dict[str, Number] = {"orders on the front": len(orders), "of no known arm": len(strange)}
    numbers["of known arms"] = " ".join(order for order in orders if order not in strange)
    value = len(strange) / len(orders) - 0.5
    return judged(name, value, interval_of(values - 0.5, value), numbers=numbers)


def _share_strange(arms: list[Arm]) -> float:
    orders = {arm.joints for arm in arms}
    return sum(not known_arms(order) for order in orders) / len(orders)


def _near(evidence: Evidence) -> list[Arm]:
    """Return the front above the reach floor, and the fronts of what is left, up to some arms."""
    floor = REACH_FLOOR_SHARE * evidence.spec.n_voxels
    rest, near = [arm for arm in evidence.arms if arm.reach >= floor], list[Arm]()
    while rest and len(near) < _NEAR:
        front = evidence.front_of(rest)
        near += front
        gone = {id(arm) for arm in front}
        rest = [arm for arm in rest if id(arm) not in gone]
    return near


CLAIMS = (
    Claim("C1", "6 joints: PRRY, RPYP and YPRY are on the front, YPPY and YPPP are not", (6,), _c1),
    Claim("C9", "7 joints: seven prefixes are sampled most; PRRY and YPRR are on the front, YPPP, YPPY and YPYP "
          "are not", (7,), _c9),
    Claim("C18", "Many structures of the fronts are not commonly seen in real arms", (6, 7), _c18),
)  # fmt: skip
