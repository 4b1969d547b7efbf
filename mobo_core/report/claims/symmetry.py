"""C3 to C5: PRRY and its mirror image, and where arms are strong."""

from __future__ import annotations

import re

import numpy as np

from mobo_core.design import Design, to_urdf
from mobo_core.errors import MoboError
from mobo_core.report.claims.claim import Claim, Pair, missing
from mobo_core.report.claims.evidence import Arm, Array, Evidence, Flags, Indices, Maps
from mobo_core.report.claims.noise import RESAMPLES, compared, interval_of, judged, student
from mobo_core.report.claims.verdict import Number, Part
from mobo_core.search.mirror import swapped

ALIKE = 0.05  # of reach, and of torque
_SEEDS = 8
_MOST_POSES = 2_000_000  # evaluated for one claim, three arms of each seed; two seeds in any case
FAR, NEAR = 0.3, 0.3  # m
_MOST_ARMS = 20


def _c3(pair: Pair) -> list[Part]:
    six = pair.of(6)
    if six.fair:
        return _best_alike(six)
    name = "PRRY with Roll and Pitch exchanged is worth the same"
    if (part := missing(name, six, "PRRY")) is not None:
        return [part]
    arm = six.prefixes["PRRY"].best
    try:
        own = to_urdf(six.space.arm(arm.joints, arm.lengths), six.space)
        built = to_urdf(six.space.arm(swapped(arm.joints), arm.lengths), six.space)
        values = _values(six, [own, exchanged(own), built])  # (arms, seeds, 2)
    except MoboError as error:
        return [Part(name, numbers={"arm": arm.joints, "not evaluated": str(error)})]
    base, other, _ = values
    numbers: dict[str, Number] = {"seeds": len(base)}
    rule_order = Design(swapped(arm.joints), arm.lengths).joints
    labels = (arm.joints, f"{swapped(arm.joints)} (exchanged)", f"{rule_order} (by the Yaw rule)")
    for label, found in zip(labels, values, strict=True):
        numbers |= {f"{label} reach": float(found[:, 0].mean()), f"{label} torque": float(found[:, 1].mean())}
    return [
        _alike(f"{name}: {what}", other[:, k], base[:, k], numbers) for k, what in enumerate(("reach", "torque"))
    ]


def _values(evidence: Evidence, urdfs: list[str]) -> Array:
    from mobo_core.evaluation.evaluate import evaluate

    spec = evidence.spec
    seeds = min(max(_MOST_POSES // (len(urdfs) * spec.n_voxels * spec.poses_per_voxel), 2), _SEEDS)
    found = np.empty((len(urdfs), seeds, 2))
    for i, urdf in enumerate(urdfs):
        for k in range(seeds):
            result = evaluate(urdf, spec.model_copy(update={"seed": (spec.seed + k) % 2**63}))
            found[i, k] = result.reach, result.torque
    return found


def _alike(name: str, values: Array, others: Array, numbers: dict[str, Number]) -> Part:
    """Return whether two arms differ by less than a twentieth, by the spread over seeds of the poses."""
    scale = max(float(others.mean()), 1e-9)
    differences = (values - others) / scale
    n = len(differences)
    middle = float(differences.mean())
    half = student(n - 1) * float(differences.std(ddof=1)) / n**0.5
    least = 0.0 if abs(middle) < half else abs(middle) - half
    interval = (ALIKE - abs(middle) - half, ALIKE - least)
    return judged(name, ALIKE - abs(middle), interval, numbers=numbers)


def exchanged(urdf: str) -> str:
    """Return the description of an arm with its rolls as pitches, and the other way round; no Yaw rule is applied.

    That is the arm turned by 90 degrees about z, as the limits are the same either way.
    """

    def turned(match: re.Match[str]) -> str:
        x, y, z = match.group(1).split()
        return f'<axis xyz="{y} {x} {z}"'

    return re.sub(r'<axis xyz="([^"]*)"', turned, urdf)


def _best_alike(six: Evidence) -> list[Part]:
    """Return whether the best arms of RPPY and PRRY differ by less than a twentieth."""
    name = "the best RPPY is worth the best PRRY"
    if (part := missing(name, six, "RPPY", "PRRY")) is not None:
        return [part]
    arms = [(six, six.prefixes[prefix].best) for prefix in ("RPPY", "PRRY")]
    searched = [(six, "RPPY"), (six, "PRRY")]
    least = six.step / max(arms[1][1].reach, 1e-9)
    return [
        compared(f"{name}: reach", arms, lambda r, t: ALIKE - np.abs(r[0] / r[1] - 1), least=least,
                 raised_by=searched, lowered_by=searched),
    ]  # fmt: skip


def _c4(pair: Pair) -> list[Part]:
    six = pair.of(6)
    return [_low_along(six, "PRRY", 1), _low_along(six, "RPPY", 0)]


def _low_along(evidence: Evidence, prefix: str, axis: int) -> Part:
    """Return whether a prefix's torque is lower along one horizontal axis (0: x, 1: y) than along the other."""
    name = f"{prefix}'s torque is less near the {'xy'[axis]} axis"
    if (part := missing(name, evidence, prefix)) is not None:
        return part
    own, other = _mirrored_voxels(evidence, axis)
    top = evidence.prefixes[prefix].top(most=_MOST_ARMS)
    found = [maps for arm in top if (maps := evidence.maps(arm)) is not None]
    if not found or not len(own):
        return Part(name)
    reach, torque = (np.array([maps[k] for maps in found]) for k in (0, 1))
    both = (reach[:, own] > 0) & (reach[:, other] > 0)  # (arms, pairs)
    near, across = torque[:, own] * both, torque[:, other] * both
    if not both.any():
        return Part(name)

    poses = evidence.spec.poses_per_voxel
    deviation = np.array([maps[2] for maps in found])
    variance = deviation**2 / np.maximum(reach * poses, 1.0)
    sums = np.array([(across).sum(axis=1), near.sum(axis=1)])  # (2, arms)
    errors = np.sqrt([(variance[:, which] * both).sum(axis=1) for which in (other, own)])
    chance, n = np.random.default_rng(0), len(found)
    weights = chance.multinomial(n, np.full(n, 1 / n), RESAMPLES)  # (RESAMPLES, arms)
    drawn = sums[:, None] + errors[:, None] * chance.standard_normal((2, RESAMPLES, n))
    far, close = (drawn * weights).sum(axis=2)
    values = far / np.maximum(close, 1e-9) - 1
    value, count = float(sums[0].sum() / sums[1].sum() - 1), both.sum()
    numbers: dict[str, Number] = {
        f"N m near {'xy'[axis]}": float(near.sum() / count), f"N m near {'xy'[1 - axis]}": float(across.sum() / count),
        "arms": n, "pairs of voxels": both.shape[1],
    }  # fmt: skip
    return judged(name, value, interval_of(values, value), numbers=numbers)


def _mirrored_voxels(evidence: Evidence, axis: int) -> tuple[Indices, Indices]:
    """Return voxels along an axis, 0.3 m or more from the middle, and those that they are mirrored to by x = y."""
    centres, half = evidence.spec.voxel_centres(), 0.5 * evidence.spec.voxel_size + 1e-9
    places = {tuple(np.round(centre, 6)): i for i, centre in enumerate(centres)}
    chosen = np.flatnonzero((np.abs(centres[:, 1 - axis]) <= half) & (np.abs(centres[:, axis]) >= FAR - 1e-9))
    pairs = [(int(i), places.get(tuple(np.round(centres[i][[1, 0, 2]], 6)))) for i in chosen]
    kept = [(i, j) for i, j in pairs if j is not None]
    own, other = np.array(kept, int).reshape(-1, 2).T
    return own, other


def _c5(pair: Pair) -> list[Part]:
    six = pair.of(6)
    name = "RPYP reaches less than PRRY near the body"
    if (part := missing(name, six, "RPYP", "PRRY")) is not None:
        return [part]
    arms = [six.prefixes[prefix].best for prefix in ("RPYP", "PRRY")]
    maps = [six.maps(arm) for arm in arms]
    near = np.linalg.norm(six.spec.voxel_centres(), axis=1) <= NEAR + 1e-9
    if not near.any() or any(of is None for of in maps):
        return [Part(name)]
    return [_near_part(six, name, arms, [of for of in maps if of is not None], near)]


def _near_part(six: Evidence, name: str, arms: list[Arm], maps: list[Maps], near: Flags) -> Part:
    p = np.array([of[0] for of in maps])
    inside = p[:, near]
    n, poses = inside.shape[1], six.spec.poses_per_voxel
    chance = np.random.default_rng(0)
    errors = np.sqrt((inside * (1 - inside)).sum(axis=1) / poses)
    sums = np.maximum(inside.sum(axis=1) + errors * chance.standard_normal((RESAMPLES, 2)), 1e-9)
    rpyp, prry = inside.mean(axis=1)
    value = float((prry - rpyp) / max(prry, 1e-9))
    numbers: dict[str, Number] = {"voxels near": n}
    for arm, of in zip(arms, p, strict=True):
        numbers |= {f"{arm.joints} near": float(of[near].mean()), f"{arm.joints} elsewhere": float(of[~near].mean())}
    return judged(name, value, interval_of(1 - sums[:, 0] / sums[:, 1], value),
                  raised_by=[(six, "PRRY")], lowered_by=[(six, "RPYP")], numbers=numbers)  # fmt: skip


CLAIMS = (
    Claim("C3", "RPPY is PRRY by the symmetry of x and y", (6,), _c3, evaluates=True),
    Claim("C4", "PRRY has low torque near the y axis, RPPY near the x axis", (6,), _c4),
    Claim("C5", "RPYP reaches little near the body", (6,), _c5),
)
