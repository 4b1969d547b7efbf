"""The compiled kernel against Pinocchio, Coal and the reference engine."""

from __future__ import annotations

import dataclasses
import itertools
import math
import os
import subprocess
import sys
from fractions import Fraction
from pathlib import Path
from typing import Any

import coal
import numpy as np
import pinocchio as pin
import pytest
from arms import HANDED_ARM, LENGTHS, KernelView, arm, random_arm, small_spec
from hypothesis import given
from hypothesis import strategies as st

from mobo_core.evaluation import EvaluationSpec
from mobo_core.evaluation.chain import Array, Chain, chain_from_urdf
from mobo_core.evaluation.evaluate import Configurations, Result, evaluate
from mobo_core.evaluation.kernel.arguments import lane_constants
from mobo_core.evaluation.kernel.configuration import DAMPING_FLOOR, DAMPING_GAIN, MAX_STEP
from mobo_core.evaluation.kernel.geometry import any_pair_collides, place_capsules, segment_distance_squared
from mobo_core.evaluation.kernel.lanes import lane_jacobian_source, lane_step_source, state_size
from mobo_core.evaluation.kernel.load import kernel
from mobo_core.evaluation.kernel.orientation import FREE_ROLL, FULL, NONE, ORIENTATIONS
from mobo_core.evaluation.kernel.rows import LANES
from mobo_core.evaluation.reference import ReferenceModel
from mobo_core.evaluation.reference import tool_error as reference_tool_error
from mobo_core.jit.numerics import target_rotation

ARMS = {
    **{joints: (arm(joints), "") for joints in LENGTHS},
    "handed": (HANDED_ARM, "tcp"),
    "random": (random_arm(1), "flange"),
    "sliding": (random_arm(2, slides=(1, 3, 6)), "flange"),
    "fat": (arm("YPPRPP", (0.1,) * 6, link_radius=0.03, joint_limit=3.0), ""),
}
CHAINS = {name: chain_from_urdf(*case) for name, case in ARMS.items()}
any_chain = st.sampled_from(sorted(CHAINS)).map(lambda name: CHAINS[name])
unit = st.floats(0, 1)


def configuration(chain: Chain, shares: list[float]) -> Array:
    return chain.lower + np.array(shares[: chain.n]) * (chain.upper - chain.lower)


configurations = st.tuples(any_chain, st.lists(unit, min_size=7, max_size=7)).map(
    lambda case: (case[0], configuration(*case))
)


@given(configurations)
def test_kinematics_are_pinocchios(case: tuple[Chain, Array]) -> None:
    """The tip agrees with Pinocchio to 1e-12, gravity torque to 1e-9."""
    chain, q = case
    view, reference = KernelView(chain, q), ReferenceModel(chain)
    tip = reference.tip(q)
    assert np.abs(view.tip[3] - tip.translation).max() < 1e-12
    assert np.abs(view.tip[:3] - tip.rotation).max() < 1e-12
    assert np.abs(view.torque() - reference.torque(q)).max() < 1e-9


@given(st.text("RPY", min_size=1, max_size=9), st.data())
def test_arm_at_zero(joints: str, data: st.DataObject) -> None:
    """With all joints at zero the tip is at (0, 0, total length) and no joint carries torque."""
    lengths = data.draw(st.lists(st.floats(0, 0.3), min_size=len(joints), max_size=len(joints)))
    chain = chain_from_urdf(arm(joints, tuple(lengths)))
    view = KernelView(chain, np.zeros(chain.n))
    assert view.tip[3] == pytest.approx([0, 0, math.fsum(lengths)], abs=1e-15)
    assert np.array_equal(view.tip[:3], np.eye(3))
    assert view.torque().tolist() == [0.0] * chain.n
    assert chain.reach_radius == pytest.approx(math.fsum(lengths), abs=1e-15)


@given(st.lists(unit, min_size=6, max_size=6))
def test_vertical_axis_carries_no_torque(shares: list[float]) -> None:
    """A first joint that yaws needs no torque to hold the arm, whatever the configuration."""
    chain = CHAINS["YPPYPY"]
    assert abs(KernelView(chain, configuration(chain, shares)).torque()[0]) < 1e-15


@pytest.mark.slow
@given(st.floats(0.01, 50), st.lists(unit, min_size=6, max_size=6))
def test_torque_scales_with_the_masses(k: float, shares: list[float]) -> None:
    """All masses k times as great need k times the torque."""
    chain = CHAINS["PRRYPY"]
    heavier = chain_from_urdf(arm("PRRYPY", motor_mass=0.5 * k, link_density=1000.0 * k))
    q = configuration(chain, shares)
    assert KernelView(heavier, q).torque() == pytest.approx(k * KernelView(chain, q).torque(), rel=1e-9, abs=1e-12)


@given(st.sampled_from(sorted(LENGTHS)), st.lists(st.booleans(), min_size=7, max_size=7), st.data())
def test_motors_may_belong_to_parent_or_child(joints: str, moved: list[bool], data: st.DataObject) -> None:
    """Gravity torque is the same whether the motor of joint i is carried by link i or by the link before."""
    chain = CHAINS[joints]
    mass, moment = chain.mass.copy(), chain.mass[:, None] * chain.com
    for i in range(1, chain.n):
        if moved[i]:  # half a kilogram at the origin of joint i
            mass[i] -= 0.5
            mass[i - 1] += 0.5
            moment[i - 1] += 0.5 * chain.placement_p[i]
    com = np.divide(moment, mass[:, None], out=np.zeros_like(moment), where=mass[:, None] > 1e-12)
    other = dataclasses.replace(chain, mass=mass, com=com)
    q = configuration(chain, data.draw(st.lists(unit, min_size=7, max_size=7)))
    assert np.abs(KernelView(other, q).torque() - KernelView(chain, q).torque()).max() < 1e-12


@given(configurations, st.tuples(*[st.floats(-10, 10)] * 3))
def test_torque_under_any_gravity(case: tuple[Chain, Array], gravity: tuple[float, float, float]) -> None:
    """With gravity from any side the torque is Pinocchio's, and the slope of the potential energy."""
    chain, q = case
    torque = KernelView(chain, q).torque(gravity)
    model = chain.model.copy()
    model.gravity.linear = np.array(gravity)
    data = model.createData()
    radius = np.where(chain.slide > 0, chain.slide, 1.0)
    assert np.abs(torque - radius * pin.computeGeneralizedGravity(model, data, q)).max() < 1e-9

    def energy(at: Array) -> float:
        view = KernelView(chain, at)
        places = view.origins + np.einsum("nij,nj->ni", view.rotations, chain.com)
        return float(-chain.mass @ places @ np.array(gravity))

    h = 1e-5
    slope = [(energy(q + h * e) - energy(q - h * e)) / (2 * h) for e in np.eye(chain.n)]
    assert torque == pytest.approx(radius * slope, abs=1e-6)


class Lanes:
    """A row of configurations, each with a target, for the generated step of the kernel; all but ``q`` in base axes."""

    def __init__(self, chain: Chain) -> None:
        n = self.n = chain.n
        self._chain = chain
        self.q = np.zeros((LANES, n))
        self.target_r, self.target_p = np.tile(np.eye(3), (LANES, 1, 1)), np.zeros((LANES, 3))
        self.constants = lane_constants(
            chain.placement_r, chain.placement_p, chain.tip_r, chain.tip_p, chain.slide
        )  # fmt: skip

    def step(
        self,
        position_tolerance: float = 0.0,
        rotation_tolerance: float = 0.0,
        weight: float = 1.0,
        orientation: int = FULL,
    ) -> tuple[Array, Array, Array]:
        """Return the configurations after one step, and the squared norms of the errors before it."""
        rows = [self.q, self.target_r.reshape(LANES, 9), self.target_p, np.full((LANES, 2), np.nan)]
        state = np.zeros(state_size(self.n))
        state[: (self.n + 14) * LANES] = np.hstack(rows).T.ravel()
        chain = self._chain
        kernel(chain.n).lane_step(
            state, self.constants, chain.lower, chain.upper, weight, orientation,
            position_tolerance**2, rotation_tolerance**2,
        )  # fmt: skip
        after = state.reshape(-1, LANES)
        return after[: self.n].T.copy(), after[self.n + 12].copy(), after[self.n + 13].copy()


def lanes_of(chain: Chain, seed: int, at_limits: float = 0.2) -> Lanes:
    """Return lanes at random configurations, some joints at their limits, with targets anywhere near the arm."""
    rng = np.random.default_rng(seed)
    lanes = Lanes(chain)
    lanes.q = rng.uniform(chain.lower, chain.upper, (LANES, chain.n))
    held = rng.uniform(size=lanes.q.shape)
    lanes.q = np.where(held < at_limits, np.where(held < at_limits / 2, chain.lower, chain.upper), lanes.q)
    lanes.target_p = rng.uniform(-0.6, 0.6, (LANES, 3))
    for r in lanes.target_r:
        target_rotation(seed, 0, int(rng.integers(1000)), r)
    return lanes


def expected_step(
    chain: Chain, q: Array, target_r: Array, target_p: Array, orientation: int = FULL
) -> tuple[Array, float, float]:
    """Return the damped step by Pinocchio's kinematics and NumPy's linear algebra, and the squared errors."""
    model = ReferenceModel(chain)
    tip, rows = model.tip(q), model.jacobian(q)
    turn, free = pin.log3(target_r @ tip.rotation.T), np.zeros((3, 3))
    if orientation == FREE_ROLL:
        # The shortest turn that brings one z axis to the other; what is free is a turn about the tool's.
        turn = pin.log3(pin.Quaternion.FromTwoVectors(tip.rotation[:, 2], target_r[:, 2]).toRotationMatrix())
        free = np.outer(tip.rotation[:, 2], tip.rotation[:, 2])
    elif orientation == NONE:
        turn, free = np.zeros(3), np.eye(3)
    rows = np.concatenate([rows[:3], (np.eye(3) - free) @ rows[3:]])
    angle = float(np.linalg.norm(turn))
    shift = target_p - tip.translation
    error = np.concatenate([shift, 2 * math.sin(angle / 2) * turn / max(angle, 1e-300)])
    slope = rows.T @ error
    rows[:, ((q <= chain.lower) & (slope < 0)) | ((q >= chain.upper) & (slope > 0))] = 0.0
    e_position, e_rotation = float(shift @ shift), 4 * math.sin(angle / 2) ** 2
    damping = DAMPING_FLOOR + DAMPING_GAIN * (e_position + e_rotation)
    step = rows.T @ np.linalg.solve(rows @ rows.T + damping * np.eye(6), error)
    step *= min(1.0, MAX_STEP / np.abs(step).max())
    return np.clip(q + step, chain.lower, chain.upper), e_position, e_rotation


@given(any_chain, st.integers(0, 10**6), st.sampled_from(sorted(ORIENTATIONS.values())))
def test_step(chain: Chain, seed: int, orientation: int) -> None:
    """One step is that of damped least squares by Pinocchio: joints at a limit they push against do not move."""
    lanes = lanes_of(chain, seed)
    after, e_position, e_rotation = lanes.step(orientation=orientation)
    for lane in range(LANES):
        expected = expected_step(chain, lanes.q[lane], lanes.target_r[lane], lanes.target_p[lane], orientation)
        assert e_position[lane] == pytest.approx(expected[1], abs=1e-12)
        if expected[2] < 3.99:  # nearer to half a turn the axis is lost to rounding
            assert e_rotation[lane] == pytest.approx(expected[2], abs=1e-11)
            assert np.abs(after[lane] - expected[0]).max() < 1e-9
    assert np.all((chain.lower <= after) & (after <= chain.upper))
    assert np.abs(after - lanes.q).max() <= MAX_STEP + 1e-12


@given(any_chain, st.integers(0, 10**6), st.permutations(range(LANES)))
def test_lanes_do_not_depend_on_each_other(chain: Chain, seed: int, order: list[int]) -> None:
    """A lane's step is the same to the bit in any place, and whatever its neighbours do."""
    lanes, moved = lanes_of(chain, seed), lanes_of(chain, seed + 1)
    expected = lanes.step()
    for here, there in enumerate(order[: LANES // 2]):
        moved.q[there], moved.target_r[there] = lanes.q[here], lanes.target_r[here]
        moved.target_p[there] = lanes.target_p[here]
    for found, wanted in zip(moved.step(), expected, strict=True):
        for here, there in enumerate(order[: LANES // 2]):
            assert found[there].tobytes() == wanted[here].tobytes()


@given(st.sampled_from(sorted(LENGTHS)), st.integers(0, 10**6), st.sampled_from([1.0, 12.0]))
def test_products_left_out_change_no_bit(joints: str, seed: int, weight: float) -> None:
    """Where all frames are parallel at zero the shorter way gives, to the bit, what the way for any arm gives."""
    lanes, general = lanes_of(CHAINS[joints], seed), lanes_of(CHAINS[joints], seed)
    assert lanes.constants[:, 12].all()
    general.constants[:, 12:] = 0.0
    for found, wanted in zip(lanes.step(weight=weight), general.step(weight=weight), strict=True):
        assert found.tobytes() == wanted.tobytes()


def test_parallel_frames() -> None:
    """The shorter way takes only frames parallel at zero, axes along x, y or z and links along z."""
    chain = CHAINS["PRRYPY"]
    given, turning = (chain.placement_r, chain.placement_p, chain.tip_r, chain.tip_p), np.zeros(6)
    constants = lane_constants(*given, turning)
    assert constants[:, 12].tolist() == [2, 1, 1, 3, 2, 3, 4]
    assert constants[:, 13].tolist() == [0.0, *LENGTHS["PRRYPY"]]
    for k in range(4):
        moved = [part.copy() for part in given]
        moved[k].ravel()[:] += 1e-12
        assert not lane_constants(*moved, turning)[:, 12:].any()
    for other in (CHAINS["handed"], CHAINS["random"]):
        assert not Lanes(other).constants[:, 12:].any()


@given(any_chain, st.integers(0, 10**6), st.floats(0, math.pi))
def test_arrival(chain: Chain, seed: int, angle: float) -> None:
    """A lane whose tip is within both tolerances stays as it is to the bit; one out of either moves on."""
    rng = np.random.default_rng(seed)
    lanes = Lanes(chain)
    lanes.q = rng.uniform(chain.lower, chain.upper, (LANES, chain.n))
    axis, side = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 3)))
    turned, shifted = np.tile([0.0, 0.0, angle, angle], LANES // 4), np.tile([0.0, 0.01, 0.0, 0.01], LANES // 4)
    for lane in range(LANES):
        tip = ReferenceModel(chain).tip(lanes.q[lane])
        lanes.target_r[lane] = pin.exp3(turned[lane] * axis) @ tip.rotation
        lanes.target_p[lane] = tip.translation + shifted[lane] * side
    after, e_position, e_rotation = lanes.step(0.005, 0.01)
    assert e_position == pytest.approx(shifted**2, abs=1e-15)
    assert e_rotation == pytest.approx(4 * np.sin(turned / 2) ** 2, abs=1e-7)
    there = (shifted < 0.005) & (2 * np.sin(turned / 2) < 0.01)
    assert np.array_equal(after[there], lanes.q[there])


@given(any_chain, st.integers(0, 10**6), st.sampled_from([0.0, 1e-9, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3]))
def test_half_a_turn_is_no_arrival(chain: Chain, seed: int, short: float) -> None:
    """A tool in its place but turned by half a turn, where the axis is lost, is not taken for one that is there."""
    rng = np.random.default_rng(seed)
    lanes = Lanes(chain)
    lanes.q = rng.uniform(chain.lower, chain.upper, (LANES, chain.n))
    for lane in range(LANES):
        tip, axis = ReferenceModel(chain).tip(lanes.q[lane]), rng.normal(size=3)
        turn = pin.exp3((math.pi - short) * axis / np.linalg.norm(axis))
        lanes.target_r[lane], lanes.target_p[lane] = turn @ tip.rotation, tip.translation
        _, _, e_rotation = reference_tool_error(tip, lanes.target_r[lane], tip.translation)
        assert e_rotation == pytest.approx(4, abs=1e-5)
    after, _, e_rotations = lanes.step(1.0, 1.0)
    assert np.all(np.isfinite(after))
    assert e_rotations == pytest.approx(4, abs=1e-5)


def coal_distance(a: Array, b: Array, radius_a: float, radius_b: float) -> float:
    """Return Coal's distance of two capsules around the segments ``a`` and ``b``, shape (2, 3) each."""
    placed = []
    for (start, end), radius in ((a, radius_a), (b, radius_b)):
        along = end - start
        length = float(np.linalg.norm(along))
        turn = np.eye(3)
        if length > 0:
            turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), along / length).toRotationMatrix()
        placed += [coal.Capsule(radius, length), coal.Transform3s(turn, (start + end) / 2)]
    return float(coal.distance(*placed, coal.DistanceRequest(), coal.DistanceResult()))


def kernel_distance(a: Array, b: Array, radius_a: float, radius_b: float) -> float:
    return math.sqrt(segment_distance_squared(a[0], a[1], b[0], b[1])) - radius_a - radius_b


def segments() -> list[tuple[str, Array, Array]]:
    """Pairs of segments: anyhow, parallel, in line, crossing, touching, and shrunk to points."""
    rng = np.random.default_rng(5)
    pairs = []
    for i in range(300):
        a, b = rng.uniform(-1, 1, (2, 3)), rng.uniform(-1, 1, (2, 3))
        along, shift = a[1] - a[0], rng.uniform(-1, 1, 3)
        s, t = rng.uniform(0, 1, 2)
        middle = a[0] + s * along
        across = rng.uniform(-1, 1, 3)
        point = rng.uniform(-1, 1, 3)
        pairs += [
            ("anyhow", a, b),
            ("parallel", a, a + shift),
            ("antiparallel", a, a[::-1] + shift),
            ("nearly parallel", a, a + shift + rng.normal(0, 1e-8, (2, 3))),
            ("skew by 1e-4", a, a + shift + rng.normal(0, 1e-4, (2, 3))),
            (
                "crossing at 1e-4",
                a,
                np.array([middle - t * along - 1e-4 * across, middle + (1 - t) * along + 1e-4 * across]),
            ),
            ("in line", a, np.array([a[0] + (1 + s) * along, a[0] + (2 + s + t) * along])),
            ("overlapping in line", a, np.array([a[0] + s * along, a[0] + (1 + t) * along])),
            ("same", a, a.copy()),
            ("crossing", a, np.array([middle - t * across, middle + (1 - t) * across])),
            ("sharing an end", a, np.array([a[1], b[1]])),
            ("point and segment", a, np.array([point, point])),
            ("segment and point", np.array([point, point]), b),
            ("two points", np.array([point, point]), np.array([shift, shift])),
            ("same point", np.array([point, point]), np.array([point, point])),
        ]
        if i == 0:
            grid = np.eye(3)
            pairs += [(f"axes {j}{k}", np.array([-grid[j], grid[j]]), np.array([-grid[k], grid[k]]) + [0.1, 0.2, 0.3])
                      for j, k in itertools.product(range(3), repeat=2)]  # fmt: skip
    return pairs


def test_capsule_distances_are_coals() -> None:
    """Distances of capsules agree with Coal to 1e-9, either way round: parallel, crossing, shrunk to points."""
    for kind, a, b in segments():
        if kind == "nearly parallel":
            continue  # Coal takes these for parallel: see the next test
        for first, second in ((a, b), (b, a), (a[::-1], b)):
            found = kernel_distance(first, second, 0.02, 0.05)
            assert found == pytest.approx(coal_distance(first, second, 0.02, 0.05), abs=1e-9), (kind, first, second)


def exact_distance(a: Array, b: Array) -> float:
    """Return the distance of two segments, worked out in fractions: of ends, or of points between them."""
    (p, p2), (q, q2) = ([[Fraction(float(v)) for v in end] for end in segment] for segment in (a, b))
    u, v, w = ([x - y for x, y in zip(to, start, strict=True)] for start, to in ((p, p2), (q, q2), (q, p)))

    def dot(x: list[Fraction], y: list[Fraction]) -> Fraction:
        return sum((i * j for i, j in zip(x, y, strict=True)), Fraction(0))

    def squared(s: Fraction, t: Fraction) -> Fraction:
        x = [k + s * i - t * j for k, i, j in zip(w, u, v, strict=True)]
        return dot(x, x)

    uu, vv, uv, uw, vw = dot(u, u), dot(v, v), dot(u, v), dot(u, w), dot(v, w)
    found = []
    for end in (Fraction(0), Fraction(1)):
        found.append(squared(end, min(max((end * uv + vw) / vv, Fraction(0)), Fraction(1)) if vv else Fraction(0)))
        found.append(squared(min(max((end * uv - uw) / uu, Fraction(0)), Fraction(1)) if uu else Fraction(0), end))
    det = uu * vv - uv * uv
    if det:
        s, t = (uv * vw - uw * vv) / det, (uu * vw - uv * uw) / det
        if 0 <= s <= 1 and 0 <= t <= 1:
            found.append(squared(s, t))
    return math.sqrt(min(found))


def test_capsule_distances_are_exact() -> None:
    """Distances agree to 1e-9 with what fractions give, next to parallel too."""
    for kind, a, b in segments():
        assert kernel_distance(a, b, 0.0, 0.0) == pytest.approx(exact_distance(a, b), abs=1e-9), (kind, a, b)


@given(st.integers(0, 10**6), st.sampled_from([1.0, 1e-3, 1e-7, 1e-11, 1e-13, 0.0]))
def test_distance_is_the_least_over_both_segments(seed: int, size: float) -> None:
    """No pair of points on the two segments is closer than the distance, and some pair is as close."""
    rng = np.random.default_rng(seed)
    a, b = rng.uniform(-1, 1, (2, 3)), rng.uniform(-1, 1, 3) + size * rng.uniform(-1, 1, (2, 3))
    found = math.sqrt(segment_distance_squared(a[0], a[1], b[0], b[1]))
    grid = np.linspace(0, 1, 201)[:, None]
    points_a, points_b = a[0] + grid * (a[1] - a[0]), b[0] + grid * (b[1] - b[0])
    sampled = np.linalg.norm(points_a[:, None] - points_b[None], axis=2).min()
    assert sampled - 0.02 <= found <= sampled + 1e-12


@pytest.mark.parametrize("name", sorted(CHAINS))
def test_collision_of_whole_arms_is_coals(name: str) -> None:
    """Over random configurations the kernel calls those in collision that Coal does."""
    chain = CHAINS[name]
    reference, rng = ReferenceModel(chain), np.random.default_rng(3)
    ends = np.empty((len(chain.capsule_radius), 2, 3))
    verdicts = []
    for _ in range(400):
        q = rng.uniform(chain.lower, chain.upper)
        view, clearance = KernelView(chain, q), reference.clearance(q)
        collides = any_pair_collides(
            chain.capsule_joint, chain.capsule_a, chain.capsule_b, chain.capsule_radius, chain.pairs,
            view.origins, view.rotations, ends,
        )  # fmt: skip
        if abs(clearance) > 1e-9:
            assert collides == (clearance < 0), (q.tolist(), clearance)
            verdicts.append(collides)
    assert len(verdicts) > 390
    if name in ("fat", "random"):  # the others are too slim to meet themselves often
        assert 20 < sum(verdicts) < 380


def test_capsules_lie_along_their_links() -> None:
    """A link's capsule runs from its joint's origin to the next one, in any configuration."""
    chain, q = CHAINS["PRRYPY"], np.array([0.3, -1.0, 0.5, 2.0, 0.1, -0.7])
    view = KernelView(chain, q)
    ends = np.empty((len(chain.capsule_radius), 2, 3))
    place_capsules(chain.capsule_joint, chain.capsule_a, chain.capsule_b, view.origins, view.rotations, ends)
    assert ends[:, 0] == pytest.approx(view.origins[:4], abs=1e-15)
    assert ends[:, 1] == pytest.approx(view.origins[1:5], abs=1e-15)


def residual(chain: Chain, spec: EvaluationSpec, found: dict[tuple[int, int], Array], at: tuple[int, int]) -> str:
    """Say how well a configuration reaches its target by Pinocchio."""
    if at not in found:
        return "fails"
    rotation = np.empty((3, 3))
    target_rotation(spec.seed, *at, rotation)
    tip, reference = ReferenceModel(chain).tip(found[at]), ReferenceModel(chain)
    position = np.linalg.norm(tip.translation - spec.voxel_centres()[at[0]])
    angle = np.linalg.norm(pin.log3(tip.rotation.T @ rotation))
    return f"{position:.9g} m, {angle:.9g} rad, clearance {reference.clearance(found[at]):.3g} m"


AROUND = {"workspace_min": (-0.3, -0.3, -0.1), "workspace_max": (0.3, 0.3, 0.5), "voxel_size": 0.2}
QUESTIONS: list[tuple[str, dict[str, Any]]] = [
    ("PRRYPY", {}),
    ("YPPYPY", {}),
    ("RPYPRP", {"solution": "least_torque", "poses_per_voxel": 10}),
    ("YPYPYPR", {}),
    ("YPYPYPR", {"gravity": (3.0, -2.0, -9.0), "payload_kg": 1.5, "seed": 11}),
    ("handed", {"workspace_min": (0.0, -0.3, 0.1), "workspace_max": (0.6, 0.3, 0.7)}),
    ("random", {"self_collision": False}),
    ("sliding", {}),
    ("fat", {"poses_per_voxel": 10}),
]


@pytest.mark.slow
def test_kernel_and_reference_agree() -> None:
    """The engines reach the same poses but for 1 in 1,000, with the same torque to 1e-6 but for 1 in 100."""
    differing: list[str] = []
    n_poses = both = unlike = in_collision = 0
    for name, values in QUESTIONS:
        urdf, tip = ARMS[name]
        spec = EvaluationSpec.of({**AROUND, "poses_per_voxel": 14, "restarts": 1, **values})
        chain = chain_from_urdf(urdf, tip, payload_kg=spec.payload_kg, gravity=spec.gravity)
        found = evaluate(urdf, spec, tip=tip, configurations=True)
        reference = evaluate(urdf, spec, tip=tip, configurations=True, engine="reference")
        kernel_q, kernel_torque = by_pose(found)
        reference_q, reference_torque = by_pose(reference)
        n_poses += spec.n_voxels * spec.poses_per_voxel
        for at in sorted(kernel_q.keys() ^ reference_q.keys()):
            said = [residual(chain, spec, found, at) for found in (kernel_q, reference_q)]
            differing.append(f"{name} voxel {at[0]} pose {at[1]}: kernel {said[0]}; reference {said[1]}")
        for at in kernel_q.keys() & reference_q.keys():
            both += 1
            unlike += abs(kernel_torque[at] - reference_torque[at]) > 1e-6
        assert np.array_equal(found.out_of_range, reference.out_of_range)
        assert np.abs(found.in_collision - reference.in_collision).sum() <= len(differing) + 1
        in_collision += found.in_collision.sum()
        assert_accepted_configurations_are_good(chain, spec, found)
    assert n_poses > 2500
    assert both > 800
    assert in_collision > 20
    assert len(differing) <= n_poses / 1000, "\n".join(differing)
    assert unlike <= both / 100


def by_pose(result: Result) -> tuple[dict[tuple[int, int], Array], dict[tuple[int, int], float]]:
    """Return the accepted configurations, and their torques, by (voxel, pose)."""
    found = result.configurations
    assert found is not None
    where = list(zip(found.voxel.tolist(), found.pose.tolist(), strict=True))
    return dict(zip(where, found.q, strict=True)), dict(zip(where, found.torque.tolist(), strict=True))


def assert_accepted_configurations_are_good(chain: Chain, spec: EvaluationSpec, result: Result) -> None:
    """Check every accepted configuration by Pinocchio and Coal alone."""
    found, reference = result.configurations, ReferenceModel(chain)
    assert isinstance(found, Configurations)
    centres, rotation = spec.voxel_centres(), np.empty((3, 3))
    for voxel, pose, q, torque in zip(found.voxel, found.pose, found.q, found.torque, strict=True):
        target_rotation(spec.seed, int(voxel), int(pose), rotation)
        tip = reference.tip(q)
        assert np.linalg.norm(tip.translation - centres[voxel]) <= spec.position_tolerance + 1e-12
        assert np.linalg.norm(pin.log3(tip.rotation.T @ rotation)) <= spec.rotation_tolerance + 1e-9
        assert np.all((chain.lower <= q) & (q <= chain.upper))
        assert abs(float(np.linalg.norm(reference.torque(q))) - torque) < 1e-9
        if spec.self_collision:
            assert reference.clearance(q) > -1e-9


@pytest.mark.parametrize("joints", ["PRRYPY", "YPYPYPR"])
def test_every_accepted_configuration_of_the_papers_question_is_good(joints: str) -> None:
    """Each is at its target within 1 mm and 1 degree, inside the limits, free of collision, its torque right."""
    spec = EvaluationSpec(poses_per_voxel=15)
    result = evaluate(arm(joints), spec, configurations=True)
    assert result.reach > 35
    assert_accepted_configurations_are_good(CHAINS[joints], spec, result)


@pytest.mark.parametrize("values", [{"position_tolerance": 1e-7, "rotation_tolerance": 1e-7}, {"iterations": 5}])
def test_tolerances_and_iterations_count(values: dict[str, Any]) -> None:
    """Tighter tolerances are kept; fewer steps find fewer solutions."""
    spec, usual = small_spec(**values), small_spec()
    result = evaluate(arm("PRRYPY"), spec, configurations=True)
    assert_accepted_configurations_are_good(CHAINS["PRRYPY"], spec, result)
    assert 0 < result.reach <= evaluate(arm("PRRYPY"), usual).reach
    assert result.iterations <= result.attempts * spec.iterations


_INTERPRETED = """
import warnings

import mobo_core.jit.cache as cache

cache.interpreted = lambda function: function
warnings.simplefilter("ignore", RuntimeWarning)  # integers that wrap
import test_kernel

for joints in test_kernel.FEW_JOINTS:
    test_kernel.check_few_joints(joints)
    print(joints, flush=True)
"""
FEW_JOINTS = ("R", "P", "Y")


def test_arms_of_few_joints() -> None:
    """Arms with fewer joints than a pose has freedoms, a single one say, are evaluated by both engines alike.

    Numba is switched off here: for these few poses, to compile a kernel for each number of joints takes longer.
    """
    path = os.pathsep.join([str(Path(__file__).parent), *filter(None, sys.path)])
    environment = {**os.environ, "PYTHONPATH": path, "NUMBA_DISABLE_JIT": "1"}
    run = subprocess.run([sys.executable, "-c", _INTERPRETED], env=environment, capture_output=True, text=True)
    assert run.stdout.split() == list(FEW_JOINTS), run.stderr


def check_few_joints(joints: str) -> None:
    """Check that kernel and reference engine agree on an arm."""
    few = {"poses_per_voxel": 2, "restarts": 1} if len(joints) > 1 else {"poses_per_voxel": 5}
    spec = small_spec(rotation_tolerance=1.5, position_tolerance=0.25, **few)
    lengths = (0.6 / len(joints),) * len(joints)
    fast, reference = (evaluate(arm(joints, lengths), spec, engine=engine) for engine in ("kernel", "reference"))
    assert fast.reach == reference.reach
    assert fast.reach > 0
    assert fast.torque == pytest.approx(reference.torque, abs=1e-9)


@pytest.mark.parametrize("n", [6, 7])
def test_jacobian(n: int) -> None:
    """The Jacobian within the kernel's step is Pinocchio's to 1e-12, at any configuration."""
    names: dict[str, object] = {"compiled": lambda function: function}
    exec("import math\nimport numpy as np\n" + lane_step_source(n) + lane_jacobian_source(n), names)
    chain = next(chain for chain in CHAINS.values() if chain.n == n)
    lanes = lanes_of(chain, 5)
    state = np.zeros(state_size(n))
    state[: n * LANES] = lanes.q.T.ravel()
    out = np.empty(n * 6 * LANES)
    names["lane_jacobian"](state, lanes.constants, 1.0, out)  # type: ignore[operator]
    rows = out.reshape(n, 6, LANES)
    model = ReferenceModel(chain)
    for lane in range(LANES):
        assert np.abs(rows[:, :, lane].T - model.jacobian(lanes.q[lane])).max() < 1e-12
