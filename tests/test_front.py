"""The Pareto front and its hypervolume against definitions by brute force and against Optuna's."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mobo_core.evaluation import EvaluationSpec
from mobo_core.search.front import Aim, RunningFront, aims_of, hypervolume, pareto_front
from mobo_core.search.study import StudySettings

N_VOXELS = 75
AIMS = aims_of(("reach", "torque"), EvaluationSpec())
WORST = 10.0 * N_VOXELS

# Few distinct values, so that ties and equal arms are common; and any values.
coarse = st.tuples(st.integers(0, 6).map(lambda i: i * 12.5), st.integers(0, 7).map(lambda i: i * 125.0))
fine = st.tuples(st.floats(0, N_VOXELS), st.floats(0, 1.2 * WORST))
arms = st.lists(coarse, max_size=30) | st.lists(fine, max_size=30)


def dominates(a, b):
    return a[0] >= b[0] and a[1] <= b[1] and a != b


@given(arms)
def test_front_is_what_nothing_dominates(points):
    front = pareto_front(points, AIMS)
    expected = [
        i
        for i, point in enumerate(points)
        if not any(dominates(other, point) for other in points) and point not in points[:i]
    ]
    assert sorted(front) == expected


@given(arms)
def test_front_rises_in_reach_and_torque(points):
    front = [points[i] for i in pareto_front(points, AIMS)]
    for low, high in zip(front, front[1:], strict=False):
        assert low[0] < high[0] and low[1] < high[1]


def test_front_of_nothing_is_empty():
    assert pareto_front([], AIMS) == []
    assert hypervolume([], AIMS) == 0


def test_of_equal_arms_the_first_is_on_the_front():
    assert pareto_front([(1.0, 2.0), (1.0, 2.0)], AIMS) == [0]


def brute(points):
    """Return the dominated share of the box, counted over the cells between all coordinates."""
    xs = sorted({0.0, *(min(p[0], N_VOXELS) for p in points)})
    ys = sorted({WORST, *(min(p[1], WORST) for p in points)})
    area = 0.0
    for x0, x1 in zip(xs, xs[1:], strict=False):
        for y0, y1 in zip(ys, ys[1:], strict=False):
            if any(p[0] >= x1 and p[1] <= y0 for p in points):
                area += (x1 - x0) * (y1 - y0)
    return area / (N_VOXELS * WORST)


@given(arms)
def test_hypervolume_is_the_dominated_share_of_the_box(points):
    assert hypervolume(points, AIMS) == pytest.approx(brute(points), rel=1e-12, abs=1e-15)


@given(arms)
def test_hypervolume_agrees_with_optuna(points):
    wfg = pytest.importorskip("optuna._hypervolume")
    inside = [point for point in points if point[1] < WORST]
    losses = np.array([(-reach, torque) for reach, torque in inside]).reshape(-1, 2)
    expected = wfg.compute_hypervolume(losses, np.array([0.0, WORST])) if inside else 0.0
    assert hypervolume(points, AIMS) == pytest.approx(expected / (N_VOXELS * WORST), rel=1e-9, abs=1e-15)


@given(arms, fine)
def test_hypervolume_never_falls_with_another_arm_and_stays_in_0_1(points, another):
    before, after = hypervolume(points, AIMS), hypervolume([*points, another], AIMS)
    assert 0 <= before <= after + 1e-12 <= 1 + 2e-12


def test_the_ideal_arm_fills_the_box():
    assert hypervolume([(N_VOXELS, 0.0)], AIMS) == 1


def test_an_arm_at_or_beyond_the_reference_torque_adds_nothing():
    assert hypervolume([(50.0, WORST), (60.0, 2 * WORST)], AIMS) == 0


@given(st.lists(st.tuples(*[st.integers(0, 6).map(float) | st.floats(0, 30)] * 2), max_size=30))
def test_running_front(arms: list[tuple[float, float]]) -> None:
    """After every arm the running front has the size and hypervolume, to the bit, of all arms so far."""
    aims = (Aim(True, 3.0), Aim(False, 30.0))
    front = RunningFront(aims)
    for n, arm in enumerate(arms, start=1):
        front.add(arm)
        assert len(front) == len(pareto_front(arms[:n], aims))
        assert front.hypervolume == hypervolume(arms[:n], aims)


SEVERAL = st.integers(2, 3).flatmap(
    lambda n: st.tuples(
        st.tuples(*[st.builds(Aim, st.booleans(), st.sampled_from([4.0, 10.0]))] * n),
        st.lists(st.tuples(*[st.integers(0, 11).map(float)] * n), max_size=12),
    )
)


@given(SEVERAL)
def test_any_directions_by_brute_force(given: tuple[tuple[Aim, ...], list[tuple[float, ...]]]) -> None:
    """Two or three objectives of any directions: front by the definition, volume by counting the cells of the box."""
    aims, arms = given
    gains = [[aim.gain(value) for aim, value in zip(aims, arm, strict=True)] for arm in arms]

    def beats(a: list[float], b: list[float]) -> bool:
        return all(x >= y for x, y in zip(a, b, strict=True)) and a != b

    front = pareto_front(arms, aims)
    assert sorted(front) == [
        i for i, arm in enumerate(arms) if not any(beats(other, gains[i]) for other in gains) and arm not in arms[:i]
    ]
    first = [aims[0].gain(arms[i][0]) for i in front]
    assert first == sorted(first)
    cells = 0  # of side 1, each by its far corner
    for cell in itertools.product(*[range(1, 12)] * len(aims)):
        cells += any(all(gain >= corner for gain, corner in zip(arm, cell, strict=True)) for arm in gains)
    assert hypervolume(arms, aims) == pytest.approx(cells / math.prod(aim.bound for aim in aims), rel=1e-12)
    running = RunningFront(aims)
    for arm in arms:
        running.add(arm)
    assert (len(running), running.hypervolume) == (len(front), hypervolume(arms, aims))


def test_objectives_are_aimed_at_by_their_own_words() -> None:
    """Direction and bound are those of the registry, in the study's order."""
    aims = StudySettings.of({"objectives": "mass,manipulability,reach"}).aims
    assert [aim.maximize for aim in aims] == [False, True, True] and aims[2].bound == N_VOXELS
