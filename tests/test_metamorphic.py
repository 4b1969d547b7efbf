"""What must come of a changed question, on random arms of six and seven joints, of 135 and of 270 degrees to each side.

Where starts are blind (``ik_mode: paper``), the first attempts stay the same, and what holds holds pose by pose. Where
they are looked for (``complete``), a pose in a hundred, or two, may be missed on one side.
"""

from __future__ import annotations

import math
from itertools import islice

import numpy as np
import pytest

from mobo_core.bench.random_arms import KINDS, draws
from mobo_core.design import Design, DesignSpace, to_urdf
from mobo_core.evaluation import EvaluationSpec, load_spec
from mobo_core.evaluation.evaluate import evaluate, solve_poses
from mobo_core.evaluation.result import Result
from mobo_core.jit.numerics import target_rotation
from mobo_core.search.mirror import exact_twins, swapped

COMPLETE = load_spec("mobo").model_copy(update={"poses_per_voxel": 2})
BLIND = load_spec("paper").model_copy(update={"poses_per_voxel": 2, "iterations": 30})
# The first of each kind.
ARMS = [(n, limit, design) for n, limit in KINDS for design in islice(draws(DesignSpace(n_joints=n), 3), 2)]


def asked(spec: EvaluationSpec, **values: object) -> list[Result]:
    """Return the evaluations of all arms; ``values`` of their space."""
    found = []
    for n, limit, design in ARMS:
        space = DesignSpace.of({"n_joints": n, "joint_limit": limit, **values})
        found.append(evaluate(to_urdf(design, space), spec, configurations=True))
    return found


def reached(result: Result) -> set[tuple[int, int]]:
    """Return (voxel, pose) of what an arm reaches."""
    configurations = result.configurations
    return set(zip(configurations.voxel.tolist(), configurations.pose.tolist(), strict=True))


@pytest.fixture(scope="module")
def complete() -> list[Result]:
    return asked(COMPLETE)


@pytest.fixture(scope="module")
def blind() -> list[Result]:
    return asked(BLIND)


def none_lost(before: list[Result], after: list[Result], *, noise: bool) -> None:
    """See that what was reached still is."""
    assert sum(len(reached(result)) for result in before) > 60
    for one, other in zip(before, after, strict=True):
        lost = reached(one) - reached(other)
        assert len(lost) <= (max(2, 0.01 * len(reached(one))) if noise else 0), lost


def test_wider_limits_lose_nothing(complete: list[Result]) -> None:
    """A joint that turns a tenth further reaches what it did."""
    wider = [
        evaluate(to_urdf(design, DesignSpace(n_joints=n, joint_limit=1.1 * limit)), COMPLETE, configurations=True)
        for n, limit, design in ARMS
    ]
    none_lost(complete, wider, noise=True)


def test_more_restarts_lose_nothing(blind: list[Result]) -> None:
    """The first attempts stay what they were."""
    none_lost(blind, asked(BLIND.model_copy(update={"restarts": BLIND.restarts + 6})), noise=False)


def test_thinner_links_lose_nothing(complete: list[Result], blind: list[Result]) -> None:
    """Links of half the radius collide in no place where the thicker ones do not."""
    radius = DesignSpace().link_radius / 2
    none_lost(blind, asked(BLIND, link_radius=radius), noise=False)
    none_lost(complete, asked(COMPLETE, link_radius=radius), noise=True)


@pytest.mark.parametrize("factor", [2.0, 3.0])
def test_torque_scales_with_the_masses(factor: float, complete: list[Result]) -> None:
    """The same poses, and each voxel's torque times the factor: a power of two to the bit, others but for rounding."""
    plain = DesignSpace()
    heavy = asked(COMPLETE, motor_mass=factor * plain.motor_mass, link_density=factor * plain.link_density)
    for one, other in zip(complete, heavy, strict=True):
        assert np.array_equal(one.configurations.q, other.configurations.q)
        if factor == 2.0:
            assert np.array_equal(factor * one.voxel_torque, other.voxel_torque)
        assert other.voxel_torque == pytest.approx(factor * one.voxel_torque, rel=1e-12, abs=1e-12)


def test_a_payload_changes_no_reach(complete: list[Result]) -> None:
    """Nor a configuration: weight is no matter of inverse kinematics. Torque is another."""
    loaded = asked(COMPLETE.model_copy(update={"payload_kg": 0.7}))
    for one, other in zip(complete, loaded, strict=True):
        assert np.array_equal(one.voxel_reach, other.voxel_reach)
        assert np.array_equal(one.configurations.q, other.configurations.q)
        assert not reached(one) or one.torque != other.torque


def test_mirror_twins_reach_turned_targets() -> None:
    """An arm whose rolls and pitches change places reaches what is mirrored in the plane x = y, but for noise."""
    mirror, positions = np.eye(3)[[1, 0, 2]], COMPLETE.voxel_centres()
    rotations = np.empty((len(positions), 3, 3))
    for voxel, rotation in enumerate(rotations):
        target_rotation(COMPLETE.seed, voxel, 0, rotation)
    both = differ = pairs = 0
    for n, limit in KINDS:
        space = DesignSpace(n_joints=n, joint_limit=limit)
        for design in islice(draws(space, 4), 12):
            order = design.joints
            if order not in exact_twins({order, swapped(order)}, space, COMPLETE):
                continue
            pairs += 1
            outcomes = [
                solve_poses(to_urdf(Design(joints, design.lengths), space), COMPLETE, at, turned)[0] == 0
                for joints, at, turned in (
                    (order, positions, rotations), (swapped(order), positions @ mirror, mirror @ rotations @ mirror)
                )
            ]  # fmt: skip
            both += np.count_nonzero(outcomes[0] & outcomes[1])
            differ += np.count_nonzero(outcomes[0] != outcomes[1])
    assert pairs >= 3 and both > 20 and differ <= max(2, 0.02 * both), (pairs, both, differ)


def test_the_arms_are_of_all_kinds() -> None:
    assert {(n, round(math.degrees(limit))) for n, limit, _ in ARMS} == {(6, 135), (6, 270), (7, 135), (7, 270)}
