"""Random numbers, sine and cosine, targets and starts: the same bits everywhere."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import kstest

from mobo_core.jit.numerics import (
    STREAM_ORIENTATION,
    STREAM_START,
    mix,
    random_start,
    sin_cos,
    stream,
    target_rotation,
    uniform,
)

words = st.integers(0, 2**63 - 1)


def plain_mix(state: int, word: int) -> int:
    """SplitMix64's next output from (state ^ word), in Python's own integers."""
    mask = 2**64 - 1
    z = ((state ^ word) + 0x9E3779B97F4A7C15) & mask
    z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & mask
    z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & mask
    return z ^ (z >> 31)


def plain_stream(*parts: int) -> int:
    """Fold (seed, kind, a, b, c) into a state."""
    state = 0
    for part in parts:
        state = plain_mix(state, part)
    return state


def plain_uniform(state: int, k: int) -> float:
    """The top 53 bits as a fraction."""
    return math.ldexp(plain_mix(state, k) >> 11, -53)


def plain_rotation(seed: int, voxel: int, pose: int) -> list[list[float]]:
    """A target's matrix by the textbook formula for unit quaternions."""
    state, k = plain_stream(seed, 1, voxel, pose, 0), 0
    while True:
        w, x, y, z = (2.0 * plain_uniform(state, k + i) - 1.0 for i in range(4))
        n = w * w + x * x + y * y + z * z
        if 1e-4 < n <= 1.0:
            break
        k += 4
    f = 1.0 / math.sqrt(n)
    w, x, y, z = w * f, x * f, y * f, z * f
    return [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
    ]


def rotation(seed: int, voxel: int, pose: int) -> np.ndarray:
    out = np.empty((3, 3))
    target_rotation(seed, voxel, pose, out)
    return out


ROTATIONS = np.array([rotation(0, i // 30, i % 30) for i in range(6000)])


def test_known_numbers() -> None:
    """The generator gives the numbers published for SplitMix64 from seed 0; streams stay as they were."""
    published = [0xE220A8397B1DCDAF, 0x6E789E6AA1B965F4, 0x06C45D188009454F]
    states = [0, 0x9E3779B97F4A7C15, (2 * 0x9E3779B97F4A7C15) % 2**64]
    assert [int(mix(np.uint64(state), 0)) for state in states] == published
    orientation, start = stream(0, STREAM_ORIENTATION, 0, 0, 0), stream(2026, STREAM_START, 74, 29, 5)
    assert (int(orientation), int(start)) == (0xF9AC6E337C2F0F1E, 0xCFFB31B24B06BBCF)
    assert float(uniform(np.uint64(orientation), 0)) == 0.4599168720727639
    assert float(uniform(np.uint64(start), 3)) == 0.38460696136963535


@given(words, st.integers(0, 5), words, words, words, words)
def test_bits_of_the_streams(seed: int, kind: int, a: int, b: int, c: int, k: int) -> None:
    """Every number is, to the bit, what Python's unbounded integers give."""
    state = stream(seed, kind, a, b, c)
    assert int(state) == plain_stream(seed, kind, a, b, c)
    drawn = float(uniform(np.uint64(state), k))
    assert drawn == plain_uniform(plain_stream(seed, kind, a, b, c), k)
    assert 0 <= drawn < 1


def test_sine_and_cosine_near_whole_turns() -> None:
    """Sine and cosine are right to 3e-16 in the range of joint angles, on and beside every quarter turn."""
    rng = np.random.default_rng(0)
    quarters = np.arange(-40, 41) * (math.pi / 2)
    beside = np.concatenate([quarters + d for d in (0, 1e-16, -1e-16, 1e-9, -1e-9, 1e-3, math.pi / 4)])
    for x in np.concatenate([rng.uniform(-20, 20, 20_000), rng.normal(0, 1e-6, 1000), beside, [0.0, -0.0]]):
        s, c = sin_cos(x)
        assert abs(s - math.sin(x)) <= 3e-16, x
        assert abs(c - math.cos(x)) <= 3e-16, x


def test_sine_and_cosine_far_out() -> None:
    """They stay right to 3e-16 up to 1e5 rad, farther than any limit a URDF may set."""
    for x in np.random.default_rng(1).uniform(-1e5, 1e5, 10_000):
        s, c = sin_cos(x)
        assert abs(s - math.sin(x)) <= 3e-16, x
        assert abs(c - math.cos(x)) <= 3e-16, x


@given(st.floats(-1000, 1000))
def test_sine_and_cosine_are_plain_arithmetic(x: float) -> None:
    """Compiled or not, the bits are the same: nothing was contracted or reordered; sine is odd, cosine even."""
    s, c = sin_cos(x)
    assert (s, c) == sin_cos.py_func(x)
    assert s * s + c * c == pytest.approx(1, abs=1e-15)
    if abs((x / (math.pi / 2)) % 1 - 0.5) > 1e-9:  # at odd multiples of pi/4 the two sides round apart
        assert sin_cos(-x) == (-s, c)


@given(words, st.integers(0, 999_999), st.integers(0, 65_534))
def test_bits_of_the_targets(seed: int, voxel: int, pose: int) -> None:
    """A target's orientation is, to the bit, what plain Python gives for (seed, voxel, pose)."""
    assert rotation(seed, voxel, pose).tolist() == plain_rotation(seed, voxel, pose)


def test_targets_are_rotations() -> None:
    """Targets are orthonormal to rounding, and right-handed."""
    for r in ROTATIONS:
        assert np.abs(r @ r.T - np.eye(3)).max() <= 2e-15
        assert np.linalg.det(r) > 0.999


def test_targets_are_uniform() -> None:
    """Over SO(3): every matrix entry is uniform in [-1, 1], and angles follow (w - sin w) / pi."""
    for i in range(3):
        for j in range(3):
            assert kstest(ROTATIONS[:, i, j], "uniform", args=(-1, 2)).pvalue > 0.01, (i, j)
    angles = np.arccos(np.clip((np.trace(ROTATIONS, axis1=1, axis2=2) - 1) / 2, -1, 1))
    assert kstest(angles, lambda w: (w - np.sin(w)) / np.pi).pvalue > 0.01


def test_neighbouring_targets_are_independent() -> None:
    """The turn from a pose to the next, and from a voxel to the next, is itself uniform."""
    for step in (1, 30):
        turns = np.einsum("nji,njk->nik", ROTATIONS[:-step], ROTATIONS[step:])
        angles = np.arccos(np.clip((np.trace(turns, axis1=1, axis2=2) - 1) / 2, -1, 1))
        assert kstest(angles, lambda w: (w - np.sin(w)) / np.pi).pvalue > 0.01, step


def test_targets_depend_on_seed_voxel_and_pose_alone() -> None:
    """Asked again in any order a target is the same; another seed, voxel or pose gives another."""
    where = [(s, v, p) for s in (0, 1, 2**62) for v in (0, 1, 74) for p in (0, 1, 29)]
    first = {at: rotation(*at).tobytes() for at in where}
    assert {at: rotation(*at).tobytes() for at in reversed(where)} == first
    assert len(set(first.values())) == len(where)


@given(words, st.integers(0, 10**6), st.integers(0, 10**5), st.integers(0, 1000), st.integers(1, 9))
def test_starts(seed: int, voxel: int, pose: int, attempt: int, n: int) -> None:
    """IK starts lie within the limits and are, to the bit, what plain Python gives; streams do not overlap."""
    lower, upper = np.linspace(-3, 1, n), np.linspace(-2.5, 6, n)
    q = np.empty(n)
    random_start(seed, voxel, pose, attempt, lower, upper, q)
    assert STREAM_START != STREAM_ORIENTATION
    state = plain_stream(seed, 2, voxel, pose, attempt)
    expected = [float(lower[i] + plain_uniform(state, i) * (upper[i] - lower[i])) for i in range(n)]
    assert q.tolist() == expected
    assert np.all((lower <= q) & (q <= upper))
