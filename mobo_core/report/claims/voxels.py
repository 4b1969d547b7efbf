"""C15, C16: how reach and torque lie in the workspace, on finer voxels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mobo_core.design import to_urdf
from mobo_core.errors import MoboError
from mobo_core.evaluation.colours import TORQUE_SCALE
from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.report.claims.claim import Claim, Pair
from mobo_core.report.claims.evidence import Array, Evidence, Flags, by_reach
from mobo_core.report.claims.noise import RESAMPLES, interval_of, judged
from mobo_core.report.claims.verdict import Number, Part
from mobo_core.report.prefixes import PREFIX_LENGTH

ORDER = "YPPPYP"  # of the paper's figure of its objectives
FINE = 0.1  # m
# m; the paper does not say the lengths of its figure's arm. These stand in if a study hardly searched its prefix.
_LENGTHS = (0.05, 0.25, 0.2, 0.05, 0.0, 0.05)
_MOST_POSES = 2_000_000


@dataclass(frozen=True)
class Fine:
    """An arm on fine voxels: its numbers, what of them to tell, and each voxel's centre, reach and torque."""

    numbers: dict[str, Number]
    centres: Array
    reach: Array
    torque: Array
    within: float


def _fine(six: Evidence) -> Fine | Part:
    """Return a YPPPYP, the study's best, on voxels of 0.1 m, evaluated once; a part that says why not."""
    if (kept := six.memo.get("fine")) is None:
        kept = six.memo["fine"] = _evaluated(six)
    assert isinstance(kept, Fine | Part)
    return kept


def _evaluated(six: Evidence) -> Fine | Part:
    from mobo_core.evaluation.evaluate import evaluate

    arms = sorted((arm for arm in six.arms if arm.joints == ORDER), key=by_reach)
    lengths = arms[0].lengths if arms and not six.unknown([ORDER[:PREFIX_LENGTH]]) else _LENGTHS
    try:
        spec = EvaluationSpec.of({**six.spec.to_dict(), "voxel_size": FINE})
        if spec.n_voxels * spec.poses_per_voxel > _MOST_POSES:
            return Part("voxels of 0.1 m", numbers={"not evaluated": f"{spec.n_voxels} voxels are too many"})
        result = evaluate(to_urdf(six.space.arm(ORDER, lengths), six.space), spec)
    except MoboError as error:
        return Part("voxels of 0.1 m", numbers={"not evaluated": str(error)})
    numbers: dict[str, Number] = {"lengths": ",".join(f"{length:.4g}" for length in lengths), "voxels": spec.n_voxels}
    return Fine(numbers, spec.voxel_centres(), result.voxel_reach, result.voxel_torque, sum(lengths))


def _c15(pair: Pair) -> list[Part]:
    fine = _fine(pair.of(6))
    if isinstance(fine, Part):
        return [fine]
    distance = np.linalg.norm(fine.centres, axis=1)
    within, reached = distance <= fine.within + 1e-9, fine.reach > 0
    horizontal, z = np.hypot(fine.centres[:, 0], fine.centres[:, 1]), fine.centres[:, 2]
    return [
        _falls("reach falls with the distance", distance, fine.reach, within, fine.numbers),
        _falls("torque falls with the height", z, fine.torque, reached, fine.numbers),
        _falls("torque grows with the horizontal distance", -horizontal, fine.torque, reached, fine.numbers),
    ]


def _falls(name: str, x: Array, y: Array, where: Flags, numbers: dict[str, Number]) -> Part:
    """Return whether y falls as x rises: the margin is Spearman's correlation, negated."""
    a, b = x[where], y[where]
    if len(a) < 3 or np.ptp(a) == 0.0 or np.ptp(b) == 0.0:
        return Part(name, numbers=numbers | {"voxels that count": len(a)})
    value = -spearman(a, b)
    chance = np.random.default_rng(0)
    values = np.array([-spearman(a[i], b[i]) for i in chance.integers(0, len(a), (RESAMPLES, len(a)))])
    return judged(name, value, interval_of(values, value), numbers=numbers | {"voxels that count": len(a)})


def spearman(a: Array, b: Array) -> float:
    """Return Spearman's correlation of ranks, ties at their mean; 0 if one of them does not vary."""
    x, y = (_ranks(values) for values in (a, b))
    x, y = x - x.mean(), y - y.mean()
    scale = float(np.sqrt((x @ x) * (y @ y)))
    return float(x @ y) / scale if scale > 0 else 0.0


def _ranks(values: Array) -> Array:
    _, inverse, counts = np.unique(values, return_inverse=True, return_counts=True)
    last = np.cumsum(counts)
    ranks: Array = (last - (counts - 1) / 2)[inverse.ravel()]
    return ranks


def _c16(pair: Pair) -> list[Part]:
    fine = _fine(pair.of(6))
    if isinstance(fine, Part):
        return [fine]
    torque = fine.torque[fine.reach > 0]
    low, high = TORQUE_SCALE.green, TORQUE_SCALE.red
    names = (f"5 % of the voxels' torques at {low:g} N m or more", f"95 % of them at {high:g} N m or less")
    if len(torque) < 3:
        return [Part(name, numbers=fine.numbers | {"voxels reached": len(torque)}) for name in names]
    chance = np.random.default_rng(0)
    drawn = np.percentile(torque[chance.integers(0, len(torque), (RESAMPLES, len(torque)))], (5, 95), axis=1)
    p5, p95 = (float(value) for value in np.percentile(torque, (5, 95)))
    numbers = fine.numbers | {"5 %": p5, "95 %": p95}
    return [
        judged(names[0], p5 / low - 1, interval_of(drawn[0] / low - 1, p5 / low - 1), numbers=numbers),
        judged(names[1], 1 - p95 / high, interval_of(1 - drawn[1] / high, 1 - p95 / high), numbers=numbers),
    ]


CLAIMS = (
    Claim("C15", "YPPPYP: reach falls with distance, torque falls with height and grows with horizontal distance",
          (6,), _c15, evaluates=True),
    Claim("C16", "YPPPYP: the voxels' torques lie within 3 to 10 N m, the paper's colours", (6,), _c16, evaluates=True),
)  # fmt: skip
