"""The sampler structured: a search of each joint order, and how trials are shared out."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from collections import Counter
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from mobo_core.bag.record import settings_of as settings_of_record
from mobo_core.bag.record import study_record
from mobo_core.design import Design, DesignSpace
from mobo_core.design.joints import effective_orders
from mobo_core.design.prepared import PreparedXacro
from mobo_core.errors import InputError
from mobo_core.evaluation import EvaluationSpec, load_spec
from mobo_core.evaluation.evaluate import evaluate, solve_poses
from mobo_core.jit.numerics import target_rotation
from mobo_core.search.contract import go_on
from mobo_core.search.front import Aim, hypervolume, pareto_front
from mobo_core.search.samplers.structured import model, search, volume
from mobo_core.search.samplers.structured.archive import Archive, Front
from mobo_core.search.samplers.structured.orders import sampled_orders, twins
from mobo_core.search.samplers.structured.policy import directions
from mobo_core.search.samplers.structured.region import Region, spread, vary
from mobo_core.search.study import Asked, OrderedStudy, StudySettings

TWO = ("reach", "torque")
SPEC = EvaluationSpec()
# Few values, so that some are equal.
GAINS = st.sampled_from([-0.25, 0.0, 0.125, 0.25, 0.5, 0.75, 1.0]) | st.floats(-0.5, 1.0)


def settings_of(in_flight: int = 3, startup: int = 8, **values: Any) -> StudySettings:
    return StudySettings.of({"sampler": "structured", "in_flight": in_flight, "n_startup_trials": startup, **values})


def value(number: int, design: Design) -> tuple[float, ...] | None:
    """Return reach and torque, made up: best are wrists of no length, and each order has a length of its own."""
    wanted = 0.1 + 0.05 * sum(a != b for a, b in pairwise(design.joints))  # the same for mirror twins
    miss = abs(design.lengths[0] - wanted) + sum(design.lengths[-2:])
    return None if number % 9 == 4 else (60.0 * max(0.0, 1.0 - 2.0 * miss), 300.0 * design.lengths[1])


def run(settings: StudySettings, trials: int) -> list[Asked]:
    return go_on(OrderedStudy(settings), trials, value=value)


@pytest.mark.parametrize("m", [2, 3])
@given(data=st.data())
def test_what_a_point_adds(m: int, data: st.DataObject) -> None:
    """Fronts are those of all points at once, and what each point adds is the difference of their hypervolumes."""
    points = data.draw(st.lists(st.tuples(*[GAINS] * m), min_size=1, max_size=24))
    aims = (Aim(True, 1.0),) * m
    front, before = Front(m, 1), 0.0
    for i, point in enumerate(points):
        new = hypervolume(points[: i + 1], aims)
        assert float(volume.added(front.gains, len(front), np.array(point))) == pytest.approx(new - before, abs=1e-12)
        front.add(np.array(point), np.array([float(i)]))
        before = new
    assert front.volume == pytest.approx(before, abs=1e-12)
    assert sorted(front.arms[:, 0]) == sorted(map(float, pareto_front(points, aims)))


@pytest.mark.parametrize("m", [2, 3])
def test_a_full_front_keeps_its_best(m: int) -> None:
    """One that is full loses little of its hypervolume, and nothing of its ends."""
    rng = np.random.default_rng(m)
    points = np.abs(rng.normal(size=(300, m)))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    front = Front(m, 1, capacity=24)
    for point in points:
        front.add(point, np.zeros(1))
    kept = hypervolume(front.gains.tolist(), (Aim(True, 1.0),) * m)
    assert len(front) == 24
    assert kept > (0.95 if m == 2 else 0.83) * hypervolume(points.tolist(), (Aim(True, 1.0),) * m)
    assert (front.gains.max(axis=0) == points.max(axis=0)).all()


def test_expectations_are_those_of_a_gaussian_process() -> None:
    """Means and deviations are what linear algebra makes of the kernel; arms in flight lower deviations alone."""
    rng = np.random.default_rng(0)
    z, asked, gains = rng.random((20, 4)), rng.random((5, 4)), rng.random((16, 2))
    twin = np.arange(20) % 5 == 0
    mean, deviation = np.empty((5, 2)), np.empty((5, 2))
    scale, noise = model.NEAR
    model.predict(z, gains, twin, 16, asked, scale, noise, mean, deviation)

    def kernel(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
        r = np.sqrt(5.0) * np.linalg.norm(a[:, None] - b[None], axis=2) / scale
        return (1 + r + r * r / 3) * np.exp(-r)

    alike = np.where(twin[:, None] == twin[None], 1.0, model.TWIN)
    own = kernel(z, z) * alike + noise * np.eye(20)
    cross = kernel(asked, z) * np.where(twin, model.TWIN, 1.0)
    middle, sd = gains.mean(axis=0), gains.std(axis=0)
    np.testing.assert_allclose(mean, middle + cross[:, :16] @ np.linalg.solve(own[:16, :16], gains - middle), atol=1e-9)
    rest = 1 - (cross * np.linalg.solve(own, cross.T).T).sum(axis=1)
    np.testing.assert_allclose(deviation, np.sqrt(rest)[:, None] * sd, rtol=1e-6)
    model.predict(z, gains, twin, 16, z[:2], scale, noise, mean[:2], deviation[:2])
    assert (deviation[1] == -1).all()


def test_rules_of_older_bags_stay() -> None:
    """A record that does not say means rules 1, whose designs are what they were; others have one set of rules."""
    latest = settings_of()
    record = study_record("s", latest)
    assert latest.sampler_rules == 2 and settings_of_record(record, "bag") == latest
    del record["sampler_rules"]
    older = settings_of_record(record, "bag")
    assert older.sampler_rules == 1 and older == settings_of(sampler_rules=1)
    first = [asked.design for asked in run(older, 60)]
    assert hashlib.sha256(repr(first).encode()).hexdigest()[:16] == "19ac61e717792f9d"
    one = {"joints": ["R", "P", "P", "R"]}  # an order alone soon has many arms
    designs = [[asked.design for asked in run(settings_of(space=one, sampler_rules=n), 80)] for n in (1, 2)]
    assert designs[0][:60] == designs[1][:60] and designs[0] != designs[1]
    assert StudySettings(sampler="tpe").sampler_rules == 1
    with pytest.raises(InputError, match="sampler_rules = 3; expected at most 2 of structured"):
        settings_of(sampler_rules=3)


@pytest.mark.parametrize("n", [4, 6, 7])
def test_orders_are_those_that_can_be_built(n: int) -> None:
    """Each once, with letters that build it."""
    found = sampled_orders(DesignSpace(n_joints=n))
    assert sorted(found) == sorted(effective_orders(n, "RPY"))
    assert all(Design(sampled, (0.1,) * n).joints == order for order, sampled in found.items())


def test_mirror_twins_are_worth_alike() -> None:
    """48 pairs of the 239 six-joint orders; their arms of equal lengths differ by where poses lie."""
    pairs = twins(DesignSpace(), SPEC, TWO)
    assert len(pairs) == 96 and all(pairs[pairs[order]] == order for order in pairs)
    spec = load_spec("mobo")
    for order, lengths in (("PRRYPP", (0.1, 0.2, 0.2, 0.0, 0.0, 0.1)), ("PRRRPR", (0.05, 0.25, 0.2, 0.05, 0.05, 0.0))):
        own, other = (evaluate(Design(joints, lengths), spec) for joints in (order, pairs.get(order, order)))
        assert own.reach == pytest.approx(other.reach, abs=2.5)
        assert own.torque == pytest.approx(other.torque, rel=0.1)


def test_mirror_twins_reach_mirrored_poses() -> None:
    """All 48 pairs, equal lengths: what one reaches the other one reaches in the mirror, but for solver noise."""
    space, spec, mirror = DesignSpace(), load_spec("mobo"), np.eye(3)[[1, 0, 2]]
    sampled, xacro = sampled_orders(space), PreparedXacro(space)
    positions, rotations = spec.voxel_centres(), np.empty((spec.n_voxels, 3, 3))
    for voxel, rotation in enumerate(rotations):
        target_rotation(spec.seed, voxel, 0, rotation)
    reached = differ = 0
    for order, twin in twins(space, spec, TWO).items():
        if order < twin:
            own, its = (xacro.to_urdf(Design(sampled[name], (0.1, 0.2, 0.2, 0.1, 0.0, 0.0))) for name in (order, twin))
            outcome, _, _ = solve_poses(own, spec, positions, rotations)
            mirrored, _, _ = solve_poses(its, spec, positions @ mirror, mirror @ rotations @ mirror)
            reached += np.count_nonzero(outcome == 0)
            differ += np.count_nonzero((outcome == 0) != (mirrored == 0))
    assert reached > 250 and differ < 0.02 * reached, (reached, differ)


def test_twins_know_each_others_best() -> None:
    """In the end no order's best is far behind its twin's, where equal lengths are worth the same."""
    study = OrderedStudy(settings_of(8, space={"n_joints": 4, "max_length": 0.6}, seed=1))
    best: dict[str, float] = {}
    for trial in go_on(study, 800, value=lambda _, design: value(0, design))[:780]:
        told = value(0, trial.design)
        assert told
        best[trial.design.joints] = max(best.get(trial.design.joints, 0.0), told[0])
    pairs = twins(DesignSpace(n_joints=4), SPEC, TWO)
    assert len(pairs) > 10 and all(abs(best[a] - best[b]) < 2.0 for a, b in pairs.items())


@pytest.mark.parametrize(
    ("space", "spec", "objectives"),
    [
        ({}, {"workspace_min": (-0.7, -0.5, -0.1)}, TWO),
        ({}, {"gravity": (1.0, 0.0, -9.0)}, TWO),
        ({"base_tilt": 0.1}, {}, TWO),
        ({"base_tilt": [0.0, 0.1]}, {}, TWO),
        ({"joint_center": 0.1}, {}, TWO),
        ({}, {"obstacles": [{"centre": [0.3, 0, 0.2], "size": [0.1, 0.1, 0.1]}]}, TWO),
        ({"joint_types": "RY"}, {}, TWO),
    ],
)
def test_no_twins_where_the_mirror_shows(space: dict[str, Any], spec: dict[str, Any], objectives: tuple[str]) -> None:
    """A workspace, gravity, base or choice of letters that is not its own mirror image leaves no twins."""
    assert not twins(DesignSpace.of(space), EvaluationSpec.of(spec), objectives)


def test_bounds_are_reached_exactly() -> None:
    """Links of no length, and of the greatest, are tried at each place, to the bit."""
    designs = [asked.design for asked in run(settings_of(space={"n_joints": 4, "max_length": 0.25}), 300)]
    for i in range(4):
        assert any(design.lengths[i] == 0.0 for design in designs)
    for i in range(3):
        assert any(design.lengths[i] == 0.25 for design in designs)
    assert all(abs(sum(design.lengths) - 0.6) < 1e-9 and max(design.lengths[:3]) <= 0.25 for design in designs)


@given(st.integers(0, 2**63 - 1), st.sampled_from([0.0, 0.05, 0.1]), st.sampled_from(["bounded", "remainder"]))
def test_points_keep_to_their_region(seed: int, least: float, last: str) -> None:
    """Whatever is drawn or changed has lengths within bounds, or none, that add up."""
    space = DesignSpace.of({"min_length": least, "last_link": last, "total_length": [0.5, 0.9]})
    region, state = Region(space), np.uint64(seed)
    points = np.empty((6, 9))
    for i, point in enumerate(points):
        spread(np.uint64(state + np.uint64(i)), region.low, region.high, region.zero, point)
    vary(state, points[1:3], points[3:], region.low, region.high, region.zero, points[0])
    for point in points:
        assert point[6] == pytest.approx(sum(point[:6]), abs=1e-9)
        assert all(x == 0.0 or least <= x <= high for x, high in zip(point, region.high, strict=True) if x != point[8])


def test_every_order_gets_its_share() -> None:
    """At seven joints all 577 orders are tried about once in as many trials; of few, none is left behind."""
    counts = Counter(asked.design.joints for asked in run(settings_of(8, space={"n_joints": 7}, startup=577), 577))
    assert len(counts) == 577
    study = OrderedStudy(settings_of(1, space={"n_joints": 3}, seed=3))
    counts = Counter(asked.design.joints for asked in go_on(study, 400, value=value))
    assert len(counts) == study.settings.space.n_orders == 17 and min(counts.values()) >= 5


def test_every_order_is_searched_well() -> None:
    """After some sixty trials an order each is near its best lengths, of which the wrist's are zero."""
    asked = run(settings_of(8, space={"n_joints": 4, "joint_types": "RP", "max_length": 0.6}), 960)
    best: dict[str, float] = {}
    for trial in asked:
        if told := value(trial.number, trial.design):
            best[trial.design.joints] = max(best.get(trial.design.joints, 0.0), told[0])
    assert len(best) == 16 and min(best.values()) > 54.0


def test_three_objectives() -> None:
    """The front of three grows beyond that of random arms."""

    def three(number: int, design: Design) -> tuple[float, ...] | None:
        told = value(number, design)
        return told and (*told, 10.0 * design.lengths[2])

    def found(sampler: str) -> float:
        space = {"n_joints": 4, "joint_types": "RP"}
        settings = settings_of(4, space=space, objectives="reach,torque,mass").to_dict() | {"sampler": sampler}
        study = OrderedStudy(StudySettings.of(settings))
        values = [three(asked.number, asked.design) for asked in go_on(study, 250, value=three)]
        return hypervolume([told for told in values if told], study.settings.aims)

    assert found("structured") > found("random") + 0.02


def test_all_trials_fail() -> None:
    """A study of nothing but failures goes on, and not with one design for ever."""
    asked = go_on(OrderedStudy(settings_of(space={"n_joints": 3})), 120, value=lambda *_: None)
    assert len({trial.design for trial in asked[-50:]}) > 25


def test_asking_costs_the_same_at_any_number_of_trials(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a model is made of, and what is looked up, does not grow with the trials told."""
    rows: list[int] = []
    plain = search.predict

    def counted(z: NDArray[np.float64], *others: Any) -> None:
        rows.append(len(z))
        plain(z, *others)

    monkeypatch.setattr(search, "predict", counted)
    monkeypatch.setattr("mobo_core.search.samplers.structured.archive.KEPT", 64)
    study = OrderedStudy(settings_of(8, space={"n_joints": 2, "joint_types": "RP"}))
    looked_up: list[int] = []
    storage, trial_of = study._optuna._storage, study._optuna._storage.get_trial
    monkeypatch.setattr(storage, "get_trial", lambda trial_id: (looked_up.append(trial_id), trial_of(trial_id))[1])
    go_on(study, 400, value=value)
    early = len(looked_up)
    go_on(study, 800, value=value)
    assert max(rows) <= search.OWN + search.TWINS + 32 and len(rows) > 500
    assert len(looked_up) - early < 1.05 * early


def test_an_archive_forgets_but_its_front() -> None:
    """Of its arms of late it keeps a number; its front, its count and what it gained are of all."""
    archive = Archive(2, [0], 1, 1)
    for i in range(2000):
        share = 1.0 - 1.0 / (i + 1)
        archive.tell(i, np.array([share]), np.array([share]), np.array([share, 0.5]))
    assert (archive.told, len(archive.points), len(archive.front)) == (2000, 512, 1)
    assert archive.gained() == pytest.approx((0.5 / 1000 - 0.5 / 2000, 1 / 1000 - 1 / 2000))
    assert Archive(2, [0], 1, 1).gained() == (1.0, 1.0)


@pytest.mark.parametrize("m", [2, 3])
def test_directions_measure_hypervolume(m: int) -> None:
    """The mean power of the highest scaled gain over directions is in proportion to the hypervolume."""
    rng, aims = np.random.default_rng(0), (Aim(True, 1.0),) * m
    ratios = []
    for _ in range(20):
        points = rng.random((5, m))
        heights = (points[None] / directions(m)[:, None]).min(axis=2).max(axis=1)
        ratios.append(float((heights**m).mean()) / hypervolume(points.tolist(), aims))
    assert max(ratios) < 1.15 * min(ratios)


def fingerprint() -> str:
    """Return designs as text, floats to the bit."""
    settings = settings_of(3, space={"n_joints": 3, "joint_types": "RP"}, seed=7)
    return "\n".join(str(asked.params) for asked in run(settings, 60))


def test_bits_are_those_of_plain_arithmetic() -> None:
    """What is drawn by compiled functions is, to the bit, what is drawn where Python runs them step by step."""
    command = [sys.executable, "-W", "ignore", "-c", "import test_structured; print(test_structured.fingerprint())"]
    plain = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    run = subprocess.run(command, env=plain, cwd=Path(__file__).parent, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert run.stdout.strip() == fingerprint()
