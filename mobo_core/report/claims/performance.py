"""C2, C6, C7, C10 to C13: the best arms of prefixes by reach and torque."""

from __future__ import annotations

import numpy as np

from mobo_core.report.claims.claim import Claim, Pair, missing, named_best, paper_prefixes
from mobo_core.report.claims.evidence import Arm, Array, Evidence
from mobo_core.report.claims.noise import compared, named
from mobo_core.report.claims.verdict import Number, Part

LOW_TORQUE = 0.85  # of the best YPPY's torque, at most
HIGH_REACH = 0.85  # of PRRY's reach, at least
SAME_TORQUE = 0.05
ALIKE = 0.05  # spread of best reach
MUCH = 0.10  # spread of best reach above which structures differ much


def _best(evidence: Evidence, *prefixes: str) -> list[tuple[Evidence, Arm]]:
    return [(evidence, evidence.prefixes[prefix].best) for prefix in prefixes]


def _highest(evidence: Evidence) -> Part:
    """Return whether PRRY reaches most: more than any other prefix that was searched, its mirror twin's left out.

    A prefix hardly searched counts if what was found of it is better all the same.
    """
    n = evidence.n_joints
    name = f"PRRY reaches most, {n} joints"
    if (part := missing(name, evidence, "PRRY")) is not None:
        return part
    rivals = [of for prefix, of in evidence.prefixes.items() if prefix not in ("PRRY", evidence.twin("PRRY"))]
    if not any(of.known for of in rivals):
        return Part(name, unsure=tuple(of.prefix for of in rivals))
    rival = max(rivals, key=lambda of: (of.best.reach, -of.best.torque))
    arms = _best(evidence, "PRRY", rival.prefix)
    numbers: dict[str, Number] = named(arms)
    numbers["hardly searched"] = sum(not of.known for of in rivals)
    return compared(name, arms, lambda r, t: (r[0] - r[1]) / r[1], least=evidence.step / max(arms[1][1].reach, 1e-9),
                    raised_by=[(evidence, "PRRY")], numbers=numbers)  # fmt: skip


def _low_torque(evidence: Evidence) -> list[Part]:
    """Return whether PRRY's torque is low: for as much reach as YPPY's best arm has, and for each voxel reached.

    A torque adds up over the voxels reached, so arms of different reach do not compare by it as it stands.
    """
    name = f"for as much reach PRRY takes at most {LOW_TORQUE} of YPPY's torque, {evidence.n_joints} joints"
    each = f"PRRY takes less torque than YPPY for each voxel reached, {evidence.n_joints} joints"
    if (part := missing(name, evidence, "PRRY", "YPPY")) is not None:
        return [part]
    searched = [(evidence, "PRRY"), (evidence, "YPPY")]
    (prry, yppy) = _best(evidence, "PRRY", "YPPY")
    per_voxel = compared(each, [prry, yppy], lambda r, t: 1 - (t[0] / r[0]) / (t[1] / r[1]),
                         raised_by=searched, lowered_by=searched)  # fmt: skip
    as_far = [arm for arm in evidence.prefixes["PRRY"].arms if arm.reach >= yppy[1].reach]
    if not as_far:
        return [Part(name, unsure=evidence.unknown(["PRRY"])), per_voxel]
    lightest = (evidence, min(as_far, key=lambda arm: arm.torque))
    return [compared(name, [lightest, yppy], lambda r, t: LOW_TORQUE - t[0] / t[1],
                     raised_by=searched, lowered_by=searched), per_voxel]  # fmt: skip


def _c2(pair: Pair) -> list[Part]:
    return [part for n in (6, 7) for part in (_highest(pair.of(n)), *_low_torque(pair.of(n)))]


def _c6(pair: Pair) -> list[Part]:
    six = pair.of(6)
    parts = []
    reach = f"YPPY reaches {HIGH_REACH} of PRRY's or more"
    torque = "for each voxel reached YPPY takes more torque than any but YPP chains"
    if (part := missing(reach, six, "YPPY", "PRRY")) is not None:
        parts.append(part)
    else:
        parts.append(
            compared(reach, _best(six, "YPPY", "PRRY"), lambda r, t: r[0] / r[1] - HIGH_REACH,
                     least=six.step / max(six.prefixes["PRRY"].best.reach, 1e-9),
                     raised_by=[(six, "YPPY")], lowered_by=[(six, "PRRY")])
        )  # fmt: skip
    others = [of.prefix for of, _ in named_best(six, paper_prefixes(six)) if of.known and of.prefix[:3] != "YPP"]
    if "YPPY" not in six.prefixes or not others:
        return [*parts, Part(torque, unsure=six.unknown(paper_prefixes(six)))]
    searched = [(six, "YPPY")]
    return [*parts, compared(torque, _best(six, "YPPY", *others),
                             lambda r, t: (t[0] / r[0]) / (t[1:] / r[1:]).max(axis=0) - 1,
                             raised_by=searched, lowered_by=searched)]  # fmt: skip


def _c7(pair: Pair) -> list[Part]:
    six = pair.of(6)
    name = "YPPP reaches less than YPPY"
    if (part := missing(name, six, "YPPP", "YPPY")) is not None:
        return [part]
    return [compared(name, _best(six, "YPPP", "YPPY"), lambda r, t: (r[1] - r[0]) / r[1],
                     least=six.step / max(six.prefixes["YPPY"].best.reach, 1e-9),
                     raised_by=[(six, "YPPY")], lowered_by=[(six, "YPPP")])]  # fmt: skip


def _more(what: str, of: tuple[Evidence, Arm], than: tuple[Evidence, Arm]) -> Part:
    """Return whether an arm of 7 joints has more reach or torque than one of 6."""
    (seven, arm), (six, other) = of, than
    searched = [(seven, arm.joints[:4])], [(six, other.joints[:4])]
    if what == "reach":
        return compared("more reach than PRRY of 6 joints", [of, than], lambda r, t: (r[0] - r[1]) / r[1],
                        least=six.step / max(other.reach, 1e-9),
                        raised_by=searched[0], lowered_by=searched[1])  # fmt: skip
    return compared("more torque than PRRY of 6 joints", [of, than], lambda r, t: t[0] / t[1] - 1,
                    raised_by=[*searched[0], *searched[1]], lowered_by=[*searched[0], *searched[1]])  # fmt: skip


def _c10(pair: Pair) -> list[Part]:
    six, seven = pair.of(6), pair.of(7)
    name = "torque of 7-joint YPRR that of 6-joint PRRY"
    if pair.apart:
        return [Part(name, numbers={"not compared": pair.apart[0]})]
    if (part := missing(name, six, "PRRY") or missing(name, seven, "YPRR")) is not None:
        return [part]
    of, than = _best(seven, "YPRR")[0], _best(six, "PRRY")[0]
    searched = [(six, "PRRY"), (seven, "YPRR")]
    same = compared(name, [of, than], lambda r, t: SAME_TORQUE - np.abs(t[0] / t[1] - 1),
                    raised_by=searched, lowered_by=searched)  # fmt: skip
    return [same, _more("reach", of, than)]


def _c11(pair: Pair) -> list[Part]:
    six, seven = pair.of(6), pair.of(7)
    name = "7-joint PRRY against 6-joint PRRY"
    if pair.apart:
        return [Part(name, numbers={"not compared": pair.apart[0]})]
    if (part := missing(name, six, "PRRY") or missing(name, seven, "PRRY")) is not None:
        return [part]
    of, than = _best(seven, "PRRY")[0], _best(six, "PRRY")[0]
    return [_more("reach", of, than), _more("torque", of, than)]


def _spread(reach: Array) -> Array:
    spread: Array = (reach.max(axis=0) - reach.min(axis=0)) / reach.max(axis=0)
    return spread


def _c12(pair: Pair) -> list[Part]:
    seven = pair.of(7)
    names = ("YPPP", "YPPY", "YPYP")
    if (part := missing("YPPP, YPPY and YPYP alike", seven, *names)) is not None:
        return [part]
    arms, searched = _best(seven, *names), [(seven, name) for name in names]
    least = seven.step / max(max(arm.reach for _, arm in arms), 1e-9)
    return [
        compared("YPPP, YPPY and YPYP reach alike", arms, lambda r, t: ALIKE - _spread(r), least=least,
                 raised_by=searched, lowered_by=searched),
        compared("YPYP takes the least torque for each voxel reached", arms,
                 lambda r, t: (t[:2] / r[:2]).min(axis=0) / (t[2] / r[2]) - 1,
                 raised_by=searched, lowered_by=searched),
    ]  # fmt: skip


def _c13(pair: Pair) -> list[Part]:
    return [_differ(pair.of(6), much=True), _differ(pair.of(7), much=False)]


def _differ(evidence: Evidence, *, much: bool) -> Part:
    """Return whether the named prefixes that were searched differ in best reach by more than a tenth, or less."""
    n = evidence.n_joints
    name = f"best reach of structures differs by {'more' if much else 'less'} than a tenth, {n} joints"
    known = [of for of, _ in named_best(evidence, paper_prefixes(evidence)) if of.known]
    if len(known) < 3:
        return Part(name, unsure=evidence.unknown(paper_prefixes(evidence)))
    arms = [(evidence, of.best) for of in known]
    sign = 1.0 if much else -1.0
    least = evidence.step / max(arm.reach for _, arm in arms)
    numbers: dict[str, Number] = {f"{of.prefix} reach": of.best.reach for of in known}
    left_out = evidence.unknown(paper_prefixes(evidence))
    numbers["left out, hardly searched"] = " ".join(left_out)
    numbers["spread"] = float(_spread(np.array([[arm.reach] for _, arm in arms]))[0])
    return compared(name, arms, lambda r, t: sign * (_spread(r) - MUCH), least=least, numbers=numbers)


CLAIMS = (
    Claim("C2", "PRRY has the highest reach and low torque, of 6 and of 7 joints", (6, 7), _c2),
    Claim("C6", "YPPY feels gravity most, and reaches far", (6,), _c6),
    Claim("C7", "YPPP reaches relatively little (its simple kinematics are not checked)", (6,), _c7),
    Claim("C10", "7-joint YPRR is 6-joint PRRY on a yaw: the same torque, more reach", (6, 7), _c10),
    Claim("C11", "7-joint PRRY has more reach and more torque than 6-joint PRRY", (6, 7), _c11),
    Claim("C12", "7-joint YPPP, YPPY and YPYP are alike, YPYP with the least torque", (7,), _c12),
    Claim("C13", "Structures differ much at 6 joints, little at 7", (6, 7), _c13),
)
