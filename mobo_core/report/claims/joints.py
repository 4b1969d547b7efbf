"""C17: what each joint holds."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from mobo_core.errors import MoboError
from mobo_core.report.claims.claim import Claim, Pair, missing
from mobo_core.report.claims.evidence import Arm, Array, Evidence, Indices
from mobo_core.report.claims.noise import RESAMPLES, interval_of, judged
from mobo_core.report.claims.verdict import Number, Part

ABOUT = 0.5  # how far from one joint's torque the saving may be
_ARMS = 6
_MOST_POSES = 1_000_000


def _c17(pair: Pair) -> list[Part]:
    six = pair.of(6)
    names = ("YPP chains hold more torque than PRRY", "by about what their elbow holds")
    if (part := missing(names[0], six, "PRRY")) is not None:
        return [part]
    chains = [prefix for prefix in ("YPPY", "YPPP") if prefix in six.prefixes]
    if not chains:
        return [Part(names[0], unsure=("YPPY", "YPPP"))]
    share = max(1, min(_ARMS, _MOST_POSES // (3 * six.spec.n_voxels * six.spec.poses_per_voxel)))
    prry = _torques(six, six.prefixes["PRRY"].top(most=share))
    chain = _torques(six, [arm for prefix in chains for arm in six.prefixes[prefix].top(most=share)])
    if not len(prry) or not len(chain):
        return [Part(names[0])]
    totals, whole = prry.sum(axis=1), chain.sum(axis=1)
    pitch = chain[:, 2]  # the second one, at the elbow: at its shoulder PRRY has a pitch as well

    def saving(a: Indices, b: Indices) -> float:
        return float((whole[b].mean() - totals[a].mean()) / max(pitch[b].mean(), 1e-9))

    chance = np.random.default_rng(0)
    drawn = np.array([
        saving(chance.integers(0, len(prry), len(prry)), chance.integers(0, len(chain), len(chain)))
        for _ in range(RESAMPLES)
    ])  # fmt: skip
    value = saving(np.arange(len(prry)), np.arange(len(chain)))
    numbers: dict[str, Number] = {"saving, of the elbow's torque": value, "PRRY N m": float(totals.mean())}
    numbers |= {"YPP chains N m": float(whole.mean()), "their elbow N m": float(pitch.mean())}
    for label, table in (("PRRY", prry), ("YPP chains", chain)):
        numbers[f"{label} by joint"] = " ".join(f"{torque:.2f}" for torque in table.mean(axis=0))
    searched = [(six, prefix) for prefix in ("PRRY", *chains)]
    return [
        judged(names[0], value, interval_of(drawn, value), searched, searched, numbers),
        judged(names[1], ABOUT - abs(value - 1), interval_of(ABOUT - np.abs(drawn - 1), ABOUT - abs(value - 1)),
               searched, searched, numbers),
    ]  # fmt: skip


def _torques(evidence: Evidence, arms: Sequence[Arm]) -> Array:
    """Return the mean absolute gravity torque of each joint of each arm in N m, (arms, joints)."""
    from mobo_core.evaluation.evaluate import evaluate

    found = []
    for arm in arms:
        made = evidence.urdf(arm)
        if made is None:
            continue
        try:
            result = evaluate(made[0], evidence.spec, tip=made[1], joint_torques=True)
        except MoboError:
            continue
        means = [joint.mean for joint in result.joint_torques or ()]
        if len(means) == evidence.n_joints and all(map(math.isfinite, means)):
            found.append(means)
    return np.array(found).reshape(-1, evidence.n_joints)


CLAIMS = (
    Claim("C17", "PRRY saves about one pitch joint's torque against YPP chains", (6,), _c17, evaluates=True),
)
