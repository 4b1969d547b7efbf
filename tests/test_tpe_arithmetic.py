"""The sampler's own exponential, logarithm and normal distribution, against SciPy's."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import special, stats

from mobo_core.jit.functions import exp, exp2, log, power
from mobo_core.jit.normal import CENTRAL, TAIL, between, half_mass, log_mass, log_tail, tail_at


@given(st.floats(-700, 700))
def test_exp(x: float) -> None:
    """e^x within some units of the last place; below e^-700 it stays there."""
    assert exp(x) == pytest.approx(math.exp(x), rel=1e-15)
    assert exp(-1e6) == exp(-700.0)


@given(st.floats(-1000, 999))
def test_exp2(x: float) -> None:
    """2^x to 1e-14 of itself; below 2^-1000 it stays there."""
    assert exp2(x) == pytest.approx(2.0**x, rel=1e-14)
    assert exp2(-1e6) == exp2(-1000.0)


@given(st.floats(1e-300, 1e300))
def test_log(x: float) -> None:
    """The logarithm to 4e-16 of itself, or of 1 where it is small."""
    assert log(x) == pytest.approx(math.log(x), rel=4e-16, abs=4e-16)


@given(st.floats(1, 1e6), st.floats(-1, 1))
def test_power(x: float, y: float) -> None:
    """x^y within rounding of the exponent."""
    assert power(x, y) == pytest.approx(x**y, rel=1e-14)


@given(st.floats(-12, 12))
def test_half_mass(t: float) -> None:
    """The normal distribution from its middle, odd to the bit."""
    assert half_mass(t, CENTRAL) == pytest.approx(0.5 * math.erf(t / math.sqrt(2)), rel=1e-13, abs=1e-15)
    assert half_mass(-t, CENTRAL) == -half_mass(t, CENTRAL)


@given(st.floats(0, 100))
def test_tail(t: float) -> None:
    """The logarithm of the upper tail, its slope, and its inverse."""
    value, slope = log_tail(t, TAIL)
    assert value == pytest.approx(special.log_ndtr(-t), rel=1e-13)
    assert slope == pytest.approx(-math.exp(stats.norm.logpdf(t) - special.log_ndtr(-t)), rel=1e-9)
    assert tail_at(value, TAIL) == pytest.approx(t, rel=1e-12, abs=1e-12)


@given(st.floats(-60, 60), st.floats(1e-3, 60), st.floats(0, 1))
def test_cut_off_normal(a: float, width: float, q: float) -> None:
    """The mass of a normal distribution between any bounds is SciPy's; below a quantile lies the share asked for."""
    b = a + width
    assert log_mass(a, b, CENTRAL, TAIL) == pytest.approx(
        stats.norm.logpdf(a) - stats.truncnorm.logpdf(a, a, b), rel=1e-9, abs=1e-9
    )
    x = between(q, a, b, CENTRAL, TAIL)
    assert a <= x <= b
    if 1e-9 < q < 1 - 1e-9:
        share = (log_mass(a, x, CENTRAL, TAIL) if x > a else -math.inf) - log_mass(a, b, CENTRAL, TAIL)
        assert math.exp(share) == pytest.approx(q, abs=1e-9)
    assert between(0.0, a, b, CENTRAL, TAIL) == a
    assert between(1.0, a, b, CENTRAL, TAIL) == b
