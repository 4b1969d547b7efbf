"""ik_mode complete: no reachable pose missed, no unreachable one claimed, torque as that of blind restarts."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from mobo_core.design import Design, DesignSpace, to_urdf
from mobo_core.evaluation import load_spec, with_ik
from mobo_core.evaluation.chain import chain_from_urdf
from mobo_core.evaluation.evaluate import evaluate, solve_poses
from mobo_core.evaluation.reference import ReferenceModel

SPEC = load_spec("mobo")
FEW = SPEC.model_copy(update={"poses_per_voxel": 6})
EXHAUSTIVE = with_ik(FEW, "paper").model_copy(update={"restarts": 199, "iterations": 100})

# One arm of each kind: high and low reach, concentrated and spread lengths, six and seven joints.
ARMS = {
    "PRRYPY": (0.06, 0.27, 0.16, 0.11, 0.0, 0.0),
    "YPPPYP": (0.05, 0.2, 0.15, 0.1, 0.05, 0.05),
    "RPYPRP": (0.0, 0.0, 0.3, 0.3, 0.0, 0.0),
    "YPRRYPY": (0.0, 0.0, 0.3, 0.15, 0.15, 0.0, 0.0),
}


def urdf(name: str) -> str:
    return to_urdf(Design(name, ARMS[name]), DesignSpace(n_joints=len(name)))


@pytest.mark.parametrize("name", ARMS)
def test_reaches_what_an_exhaustive_search_reaches(name: str) -> None:
    """At least 99.5 % of it; at most two misses where fewer than 400 poses are reachable."""
    found, there = evaluate(urdf(name), FEW, configurations=True), evaluate(urdf(name), EXHAUSTIVE, configurations=True)
    reached = set(zip(found.configurations.voxel.tolist(), found.configurations.pose.tolist(), strict=True))
    reachable = set(zip(there.configurations.voxel.tolist(), there.configurations.pose.tolist(), strict=True))
    missed = len(reachable - reached)
    assert missed <= (2 if len(reachable) < 400 else 0.005 * len(reachable))


@pytest.mark.parametrize("name", ARMS)
def test_reaches_poses_made_by_forward_kinematics(name: str) -> None:
    """At least 99.5 % of 1,000 poses of uniform collision-free configurations inside the limits."""
    chain = chain_from_urdf(urdf(name))
    model = ReferenceModel(chain)
    rng = np.random.default_rng(7)
    positions, rotations = [], []
    while len(positions) < 1000:
        q = rng.uniform(chain.lower, chain.upper)
        if model.clearance(q) > 0:
            tip = model.tip(q)
            positions.append(tip.translation.copy())
            rotations.append(tip.rotation.copy())
    outcome, _, _ = solve_poses(urdf(name), SPEC, np.array(positions), np.array(rotations))
    assert np.count_nonzero(outcome == 0) >= 995


@pytest.mark.parametrize("name", ARMS)
def test_claims_no_pose_it_does_not_reach(name: str) -> None:
    """Every accepted configuration: 1 mm and 1 degree by Pinocchio, limits, Coal, Pinocchio's torque to 1e-9 N m."""
    from mobo_core.jit.numerics import target_rotation

    chain = chain_from_urdf(urdf(name))
    model, centres, target = ReferenceModel(chain), SPEC.voxel_centres(), np.empty((3, 3))
    configurations = evaluate(urdf(name), FEW, configurations=True).configurations
    assert len(configurations.voxel) > 50
    for voxel, pose, q, torque in zip(*vars(configurations).values(), strict=True):
        target_rotation(SPEC.seed, voxel, pose, target)
        tip = model.tip(q)
        assert np.linalg.norm(tip.translation - centres[voxel]) <= 1e-3 + 1e-12
        assert np.linalg.norm(pin.log3(tip.rotation.T @ target)) <= np.radians(1) + 1e-12
        assert np.all((q >= chain.lower) & (q <= chain.upper))
        assert model.clearance(q) > -1e-12
        assert abs(np.linalg.norm(model.torque(q)) - torque) <= 1e-9


@pytest.mark.parametrize("name", ARMS)
def test_torque_is_that_of_blind_restarts(name: str) -> None:
    """Mean torque over the poses both reach: within 2 %."""
    spec = SPEC.model_copy(update={"poses_per_voxel": 20})
    blind = with_ik(spec, "paper").model_copy(update={"restarts": 20})
    found, other = (evaluate(urdf(name), asked, configurations=True).configurations for asked in (spec, blind))
    mine = dict(zip(zip(found.voxel, found.pose, strict=True), found.torque, strict=True))
    theirs = dict(zip(zip(other.voxel, other.pose, strict=True), other.torque, strict=True))
    both = mine.keys() & theirs.keys()
    ratio = np.mean([mine[at] for at in both]) / np.mean([theirs[at] for at in both])
    assert ratio == pytest.approx(1.0, abs=0.02)


def test_least_torque_needs_no_more_than_the_first_solution() -> None:
    """On every voxel, reach being the same."""
    first = evaluate(urdf("YPRRYPY"), FEW)
    least = evaluate(urdf("YPRRYPY"), FEW.model_copy(update={"solution": "least_torque"}))
    assert np.array_equal(first.voxel_reach, least.voxel_reach)
    assert np.all(least.voxel_torque <= first.voxel_torque + 1e-12)
    assert least.torque < 0.95 * first.torque


def test_same_bits_for_any_number_of_threads() -> None:
    """Voxels are independent of each other, in any split."""
    one, three = (evaluate(urdf("PRRYPY"), FEW, threads=threads, configurations=True) for threads in (1, 3))
    for name in ("voxel", "pose", "q", "torque"):
        assert getattr(one.configurations, name).tobytes() == getattr(three.configurations, name).tobytes()


def test_same_poses_given_or_drawn() -> None:
    """solve_poses agrees with evaluate on the targets of a spec, up to which random starts a pose gets."""
    from mobo_core.jit.numerics import target_rotation

    voxel, target = 37, np.empty((3, 3))
    rotations = []
    for pose in range(SPEC.poses_per_voxel):
        target_rotation(SPEC.seed, voxel, pose, target)
        rotations.append(target.copy())
    centre = np.repeat(SPEC.voxel_centres()[voxel][None], len(rotations), axis=0)
    outcome, _, _ = solve_poses(urdf("PRRYPY"), SPEC, centre, np.array(rotations))
    assert np.count_nonzero(outcome == 0) / len(outcome) == evaluate(urdf("PRRYPY"), SPEC).voxel_reach[voxel]


# Redundant, its lengths uneven: blind attempts reach much that rules 1 do not, at wide limits above all.
UNEVEN = Design("PRPYPRY", tuple(0.6 * share / 0.602 for share in (0.086, 0.107, 0.004, 0.035, 0.035, 0.102, 0.233)))


def uneven(limit: float) -> str:
    return to_urdf(UNEVEN, DesignSpace(n_joints=7, joint_limit=limit))


def test_wider_limits_reach_no_less() -> None:
    """At +-270 degrees an arm reaches what it does at +-135, but for two poses, inside the limits."""
    from mobo_core.evaluation.result import Configurations

    def reached(limit: float) -> tuple[set[tuple[int, int]], Configurations]:
        found = evaluate(uneven(limit), FEW, configurations=True).configurations
        return set(zip(found.voxel.tolist(), found.pose.tolist(), strict=True)), found

    narrow, _ = reached(0.75 * np.pi)
    wide, found = reached(1.5 * np.pi)
    assert len(narrow) > 20
    assert len(narrow - wide) <= 2
    assert np.all(np.abs(found.q) <= 1.5 * np.pi)


EFFORT = {1: {"restarts": 31, "iterations": 10}, 2: {"restarts": 63, "iterations": 12}, 3: {}}


@pytest.mark.parametrize("rules", EFFORT)
def test_rules(rules: int) -> None:
    """Rules 1 need more iterations than later ones; all reach what is asked here; none depends on threads."""
    spec = FEW.model_copy(update={"rules": rules, "poses_per_voxel": 3, **EFFORT[rules]})
    one, three = (evaluate(uneven(0.75 * np.pi), spec, threads=threads, configurations=True) for threads in (1, 3))
    assert one.configurations.q.tobytes() == three.configurations.q.tobytes()
    assert one.reach > 1
    assert (one.iterations > 100 * 225) == (rules == 1)


@pytest.mark.parametrize(
    ("rules", "six", "seven"),
    [
        (
            1,
            (55.333333333333336, 327.2393136796084, 3785, 19773),
            (4.166666666666666, 57.63410817896067, 13120, 57680),
        ),
        (
            2,
            (55.333333333333336, 327.3830473976164, 4258, 25038),
            (6.333333333333333, 77.28853731704731, 3949, 12361),
        ),
    ],
)
def test_rules_of_older_bags_keep_their_bits(rules: int, six: tuple[float, ...], seven: tuple[float, ...]) -> None:
    """What rules 1 and 2 gave when bags were recorded by them."""
    spec = FEW.model_copy(update={"rules": rules, **EFFORT[rules]})
    for arm, known in ((urdf("PRRYPY"), six), (uneven(1.5 * np.pi), seven)):
        result = evaluate(arm, spec)
        assert (result.reach, result.torque, result.attempts, result.iterations) == known
