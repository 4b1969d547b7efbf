"""C8, C14: where the joints of good arms sit."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from mobo_core.report.claims.claim import Claim, Pair, paper_prefixes
from mobo_core.report.claims.evidence import Arm, Array, Evidence, Indices
from mobo_core.report.claims.noise import RESAMPLES, interval_of, judged
from mobo_core.report.claims.verdict import Number, Part

OFTEN = 0.5
GOOD = 0.8  # of the best reach, at least: what counts as a top design of its prefix
MAJOR = 0.2  # of the arm's length, at least: a link of its proportions
BOTH = 0.1  # share that each of two ways of dividing the arm has at least
_FEWEST = 3


def places(arm: Arm) -> Array:
    """Return where the joints sit, from 0 at the base to 1 at the tool."""
    lengths = np.array(arm.lengths)
    found: Array = np.concatenate([[0.0], np.cumsum(lengths[:-1])]) / max(lengths.sum(), 1e-12)
    return found


def two_one_three(arm: Arm) -> bool:
    """Return whether an arm has two joints in its first third, one Roll or Pitch in the second, three in the last."""
    thirds = np.minimum((3 * places(arm)).astype(int), 2)
    middle = [letter for letter, third in zip(arm.joints, thirds, strict=False) if third == 1]
    return np.bincount(thirds, minlength=3).tolist() == [2, 1, 3] and middle[0] in "RP"


def _c8(pair: Pair) -> list[Part]:
    six = pair.of(6)
    name = "most of the top arms of each prefix: 2 joints at the shoulder, 1 at the elbow, 3 at the wrist"
    known = [six.prefixes[p] for p in paper_prefixes(six) if p in six.prefixes and six.prefixes[p].known]
    if not known:
        return [Part(name, unsure=six.unknown(paper_prefixes(six)))]
    having = [np.array([two_one_three(arm) for arm in _whole(six, of.top())], float) for of in known]
    having = [flags for flags in having if len(flags)]
    if not having:
        return [Part(name)]
    chance = np.random.default_rng(0)
    values = []
    for _ in range(RESAMPLES):  # other arms; the prefixes are the paper's, and no sample
        values.append(np.mean([chance.choice(flags, len(flags)).mean() for flags in having]) - OFTEN)
    value = float(np.mean([flags.mean() for flags in having])) - OFTEN
    numbers: dict[str, Number] = {f"{of.prefix} share": float(f.mean()) for of, f in zip(known, having, strict=False)}
    numbers["share of all arms"] = float(np.mean([two_one_three(arm) for arm in _whole(six, six.arms)]))
    numbers["left out, hardly searched"] = " ".join(six.unknown(paper_prefixes(six)))
    return [judged(name, value, interval_of(np.array(values), value), numbers=numbers)]


def _whole(evidence: Evidence, arms: Sequence[Arm]) -> list[Arm]:
    """Return the arms that have a length for each joint: a bag may claim anything."""
    n = evidence.n_joints
    return [arm for arm in arms if len(arm.lengths) == len(arm.joints) == n and sum(arm.lengths) > 0]


def _c14(pair: Pair) -> list[Part]:
    six, seven = pair.of(6), pair.of(7)
    return [_more_varied(six, seven), _two_ways(seven)]


def _tops(evidence: Evidence) -> list[list[Arm]]:
    """Return, of each prefix that was searched and reaches far, its top arms."""
    least = GOOD * evidence.best.reach
    of = [members for members in evidence.prefixes.values() if members.known and members.best.reach >= least]
    return [arms for members in of if (arms := _whole(evidence, members.top()))]


def apart(a: Arm, b: Arm) -> float:
    """Return how far apart the joints of two arms of as many joints sit, a mean share of the arm's length."""
    return float(np.abs(places(a) - places(b)).mean())


def _more_varied(six: Evidence, seven: Evidence) -> Part:
    """Return whether best arms of different prefixes differ more in their proportions at 7 joints than at 6."""
    name = "proportions differ more between structures at 7 joints than at 6"
    tops = [_tops(of) for of in (six, seven)]
    numbers: dict[str, Number] = {f"structures of {n} joints": len(of) for n, of in zip((6, 7), tops, strict=True)}
    if min(map(len, tops)) < _FEWEST:
        return Part(name, numbers=numbers)
    tables = [np.array([[apart(a[0], b[0]) for b in of] for a in of]) for of in tops]

    def spread(table: Array, chosen: Indices) -> float:
        part = table[np.ix_(chosen, chosen)]
        pairs = chosen[:, None] != chosen
        return float(part[pairs].mean()) if pairs.any() else 0.0

    found = [spread(table, np.arange(len(table))) for table in tables]
    chance = np.random.default_rng(0)
    values = np.array([
        [spread(table, chance.integers(0, len(table), len(table))) for table in tables] for _ in range(RESAMPLES)
    ])  # fmt: skip
    numbers |= {"mean difference at 6": found[0], "mean difference at 7": found[1]}
    scale = max(found[0], 1e-9)
    value = (found[1] - found[0]) / scale
    drawn = (values[:, 1] - values[:, 0]) / scale
    return judged(name, value, interval_of(drawn, value), numbers=numbers)


def _two_ways(seven: Evidence) -> Part:
    """Return whether top arms of 7 joints are divided 1:1 and 1:1:1, each of them a tenth of the arms or more."""
    name = "7-joint arms are divided 1:1 and 1:1:1"
    tops = _tops(seven)
    if len(tops) < _FEWEST:
        return Part(name, numbers={"structures of 7 joints": len(tops)})
    shares = np.array([[_major(arms).get(count, 0) / len(arms) for count in (2, 3)] for arms in tops])
    chance = np.random.default_rng(0)
    drawn = shares[chance.integers(0, len(shares), (RESAMPLES, len(shares)))].mean(axis=1)  # (RESAMPLES, 2)
    two, three = shares.mean(axis=0).tolist()
    value = min(two, three) - BOTH
    numbers: dict[str, Number] = {"share 1:1": two, "share 1:1:1": three, "structures": len(tops)}
    return judged(name, value, interval_of(drawn.min(axis=1) - BOTH, value), numbers=numbers)


def _major(arms: Sequence[Arm]) -> Counter[int]:
    """Return how many arms have how many links of a fifth of the arm or more."""
    return Counter(sum(length >= MAJOR * sum(arm.lengths) for length in arm.lengths) for arm in arms)


CLAIMS = (
    Claim("C8", "High reach puts 2 joints at the shoulder, 1 Roll or Pitch at the elbow, 3 at the wrist", (6,), _c8),
    Claim("C14", "Proportions of links are alike at 6 joints, and vary (1:1, 1:1:1) at 7", (6, 7), _c14),
)
