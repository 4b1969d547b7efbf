"""What an arm's motors have to hold, which ones do, and what payload that leaves.

All torques are static, at the accepted configurations. They grow with the payload, a point at the tip, and with each
motor's mass, a point at its joint's origin, in proportion; so a few torques of each configuration give all.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mobo_core.arms.motors import Motor, Motors
from mobo_core.errors import InputError, StudyError
from mobo_core.evaluation.chain import Chain, asked_chain
from mobo_core.evaluation.evaluate import evaluate
from mobo_core.evaluation.measures import joint_torques
from mobo_core.evaluation.result import Result
from mobo_core.evaluation.spec import EvaluationSpec

Array = NDArray[np.float64]

# Of the reached poses, those at which a payload may be too much.
MAY_FAIL = 0.01
_NOTHING = 1e-9  # N m for each kg, of a joint whose axis the payload is on, to rounding


@dataclass(frozen=True, eq=False)
class JointLoad:
    """What one joint has to hold, N m, over the reached poses, and with which motor.

    Attributes:
        joint: its name.
        median, p95, peak: of the absolute torque.
        voxel, pose: where the peak is.
        q: (n,) rad, the configuration there.
        motor: chosen or named; None without motors.
        holds: N m that it may take; infinite without motors.
        payload: kg, the largest that it holds over 99 % of the reached poses; -inf if not even none.
    """

    joint: str
    median: float
    p95: float
    peak: float
    voxel: int
    pose: int
    q: Array
    motor: Motor | None
    holds: float
    payload: float


@dataclass(frozen=True, eq=False)
class Sizing:
    """What an arm's joints have to hold with a payload.

    Attributes:
        result: of the evaluation, with its configurations.
        payload_kg: asked for.
        joints: from the base.
        payload: kg, the largest that every joint holds over 99 % of the reached poses; inf without motors, or where no
            joint feels it; -inf if not even none.
        voxel_payload: kg, the largest that every joint holds at all reached poses of a voxel; NaN where there is none.
    """

    result: Result
    payload_kg: float
    joints: tuple[JointLoad, ...]
    payload: float
    voxel_payload: Array


def size(
    urdf: str | bytes,
    spec: EvaluationSpec,
    payload_kg: float,
    *,
    tip: str = "",
    motors: Motors | None = None,
    own_motors: Sequence[float] | None = None,
    use: float = 1.0,
    progress: Callable[[int, int], None] | None = None,
) -> Sizing:
    """Return what an arm's joints have to hold.

    Args:
        urdf: the robot's description.
        spec: what is asked; its payload is replaced.
        payload_kg: kg, a point at the tip.
        tip: link that has to reach.
        motors: to choose from; each joint is given the lightest that holds its peak, or else the strongest; unless
            they are named.
        own_motors: kg of the motors that the description has at the joints' origins, in place of which the others
            come; None: masses stay as they are.
        use: share of the motors' torque that may be used.
        progress: called with (voxels done, in all).

    Raises:
        InputError: the URDF or the tip is not fit, or motors of another number of joints.
        StudyError: the arm reaches no pose.
    """
    asked = EvaluationSpec.of({**spec.to_dict(), "payload_kg": payload_kg})
    gravity = np.array(spec.gravity)
    bare = asked_chain(urdf, tip, asked.model_copy(update={"payload_kg": 0.0}))
    if motors is not None and motors.joints and len(motors.joints) != bare.n:
        raise InputError(f"motors of {len(motors.joints)} joints", where="motors", expected=f"of {bare.n}")
    lightened = _lightened(bare, own_motors)
    result = evaluate(urdf, asked, tip=tip, configurations=True, progress=progress)
    found = result.configurations
    assert found is not None
    if not len(found.q):
        raise StudyError(f"the arm reaches none of {spec.n_voxels * spec.poses_per_voxel:,} poses: nothing to hold")
    loaded = asked_chain(urdf, tip, asked.model_copy(update={"payload_kg": 1.0}))
    empty = _torques(bare, bare.mass, bare.com, gravity, found.q)
    per_kg = _torques(loaded, loaded.mass, loaded.com, gravity, found.q) - empty
    chosen: list[Motor | None] = [None] * bare.n
    if motors is not None:
        by_name = {motor.name: motor for motor in motors.motors}
        mass, com = lightened
        # From the tip: a motor does not load its own joint, at whose origin it is, but those before.
        for joint in range(bare.n - 1, -1, -1):
            if own_motors is not None:
                empty = _torques(bare, mass, com, gravity, found.q)
            peak = float(np.abs(empty[:, joint] + payload_kg * per_kg[:, joint]).max())
            motor = by_name[motors.joints[joint]] if motors.joints else lightest(motors.motors, peak / use)
            chosen[joint] = motor
            if own_motors is not None:
                mass, com = _heavier(bare, mass, com, joint, motor.mass)
        if own_motors is not None:
            empty = _torques(bare, mass, com, gravity, found.q)
    holds = np.array([np.inf if motor is None else use * motor.torque for motor in chosen])
    most = payloads(empty, per_kg, holds)
    torque = np.abs(empty + payload_kg * per_kg)
    joints = []
    for i, name in enumerate(bare.joint_names):
        at = int(torque[:, i].argmax())
        joints.append(
            JointLoad(
                name, float(np.median(torque[:, i])), float(np.percentile(torque[:, i], 95)), float(torque[at, i]),
                int(found.voxel[at]), int(found.pose[at]), found.q[at], chosen[i], float(holds[i]),
                over_most(most[:, i]),
            )
        )  # fmt: skip
    whole = most.min(axis=1)
    by_voxel = np.full(spec.n_voxels, np.inf)
    np.minimum.at(by_voxel, found.voxel, whole)
    by_voxel[result.voxel_reach == 0] = np.nan
    return Sizing(result, payload_kg, tuple(joints), over_most(whole), by_voxel)


def _torques(chain: Chain, mass: Array, com: Array, gravity: Array, q: Array) -> Array:
    out = np.empty(q.shape)
    joint_torques(
        chain.placement_r, chain.placement_p, chain.tip_r, chain.tip_p, chain.slide, mass, com, gravity, q, out
    )  # fmt: skip
    return out


def _lightened(chain: Chain, own_motors: Sequence[float] | None) -> tuple[Array, Array]:
    """Return masses and their centres without the motors."""
    mass, com = chain.mass.copy(), chain.com.copy()
    for joint, motor in enumerate(own_motors or ()):
        on = _carrier(chain, joint)
        if on < 0:
            continue
        if motor > mass[on] + 1e-9:
            what = f"joint {on + 1} carries {mass[on]:.3g} kg in all"
            expected = f"at least the {motor:g} kg of joint {joint + 1}'s motor"
            raise InputError(what, where="motor mass", expected=expected)
        mass, com = _heavier(chain, mass, com, joint, -min(motor, float(mass[on])))
    return mass, com


def _carrier(chain: Chain, joint: int) -> int:
    """Return which joint carries the motor of a joint: itself, but of one that slides the one before, -1: the base."""
    return joint - 1 if chain.slide[joint] > 0 else joint


def _heavier(chain: Chain, mass: Array, com: Array, joint: int, by: float) -> tuple[Array, Array]:
    """Return masses and centres with so much more where a joint's motor is: at its origin, of a slide in the middle."""
    on = _carrier(chain, joint)
    if on < 0:
        return mass, com
    mass, com = mass.copy(), com.copy()
    moment = mass[on] * com[on] + (by * chain.placement_p[joint] if on < joint else 0.0)
    mass[on] += by
    # What has no mass left has its whole moment in rounding.
    com[on] = moment / mass[on] if mass[on] > 1e-12 else 0.0
    return mass, com


def lightest(motors: Sequence[Motor], torque: float) -> Motor:
    """Return the lightest motor that holds a torque, N m, of equals the strongest; the strongest if none does."""
    holding = [motor for motor in motors if motor.torque >= torque]
    if not holding:
        return max(motors, key=lambda motor: (motor.torque, -motor.mass))
    return min(holding, key=lambda motor: (motor.mass, -motor.torque))


def payloads(empty: Array, per_kg: Array, holds: Array) -> Array:
    """Return kg up to which each joint holds each configuration, (m, n): inf for any, -inf if not even none.

    Args:
        empty: (m, n) N m without payload.
        per_kg: (m, n) N m more for each kg.
        holds: (n,) N m, of each joint.
    """
    per_kg = np.where(np.abs(per_kg) > _NOTHING, per_kg, 0.0)
    # Payload makes the torque larger in its own direction: what is left until that is used up.
    left = holds - np.sign(per_kg) * empty
    with np.errstate(divide="ignore", invalid="ignore"):
        most = np.where(per_kg != 0, left / np.abs(per_kg), np.inf)
    return np.where(np.abs(empty) <= holds, most, -np.inf)


def over_most(most: Array) -> float:
    """Return what all but MAY_FAIL of the configurations allow."""
    return float(np.sort(most)[int(MAY_FAIL * len(most))])
