"""Designs and the space they come from."""

from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import Any

import optuna
import pytest
from hypothesis import given
from hypothesis import strategies as st
from optuna.trial import FixedTrial

from mobo_core.design import Design, DesignSpace, effective_joints
from mobo_core.design.joints import count_orders, effective_orders
from mobo_core.errors import InputError

MODES = ("fractions", "sequential")
orders = st.text("RPY", min_size=1, max_size=12)


def one_line(error: pytest.ExceptionInfo[InputError], *words: str) -> None:
    """Check that an error is one line for people, naming ``words``, and means exit code 2."""
    text = str(error.value)
    assert error.value.exit_code == 2
    assert text == " ".join(text.split())
    assert "; expected " in text
    for word in words:
        assert word in text


@pytest.mark.parametrize(("joints", "count"), [(1, 3), (2, 7), (6, 239), (7, 577)])
def test_number_of_effective_orders(joints: int, count: int) -> None:
    """There are 239 effective orders of 6 joints and 577 of 7, as many as the paper has."""
    found = {effective_joints("".join(order)) for order in itertools.product("RPY", repeat=joints)}
    assert len(found) == count
    assert DesignSpace(n_joints=joints).n_orders == count


@given(st.integers(0, 6), st.permutations("RPY").map("".join), st.integers(1, 3))
def test_effective_orders(joints: int, letters: str, types: int) -> None:
    """Every order that can be built from some letters is named once, and the count is theirs."""
    letters = letters[:types]
    found = list(effective_orders(joints, letters))
    sampled = {effective_joints("".join(order)) for order in itertools.product(letters, repeat=joints)}
    assert len(found) == len(sampled) == count_orders(joints, letters) and set(found) == sampled


@given(orders)
def test_yaw_rule(sampled: str) -> None:
    """The joint after an effective yaw is a pitch, every other one as sampled, and nothing changes twice."""
    effective = effective_joints(sampled)
    assert len(effective) == len(sampled)
    assert effective[0] == sampled[0]
    for before, joint, drawn in zip(effective, effective[1:], sampled[1:], strict=False):
        assert joint == ("P" if before == "Y" else drawn)
    assert effective_joints(effective) == effective


@pytest.mark.parametrize(
    ("sampled", "effective"), [("YYYY", "YPYP"), ("YRRYYR", "YPRYPR"), ("YYR", "YPR"), ("PRRYPY", "PRRYPY")]
)
def test_yaw_rule_by_example(sampled: str, effective: str) -> None:
    """A pitch put in by the yaw rule is no yaw, so the joint after it is free again."""
    design = Design(sampled, (0.1,) * len(sampled))
    assert (design.sampled_joints, design.joints, design.name) == (sampled, effective, effective)


def shares(space: DesignSpace, order: str, fractions: list[float]) -> dict[str, Any]:
    """Return parameters of either mode from shares of each longest length."""
    params: dict[str, Any] = {f"J{i}": joint for i, joint in enumerate(order, start=1)}
    used = 0.0
    for i, share in enumerate(fractions[: len(order) - 1], start=1):
        longest = min(space.max_length, max(0.0, space.total_length - used))
        if space.lengths == "fractions":
            params[f"u{i}"] = share
        else:
            params[f"L{i}"] = share * longest
        used += share * longest
    return params


@given(
    st.sampled_from(MODES),
    st.text("RPY", min_size=1, max_size=9),
    st.lists(st.floats(0, 1) | st.sampled_from([0.0, 1.0]), min_size=9, max_size=9),
    st.sampled_from([(0.6, 0.3), (0.7, 0.3), (1.0, 0.1), (0.3, 0.3), (0.1, 0.7), (1e-3, 3e-4)]),
)
def test_lengths_add_up(mode: str, order: str, fractions: list[float], metres: tuple[float, float]) -> None:
    """Lengths are 0 or more, add up to the total, and all but the last stay within the longest allowed."""
    total, longest = metres
    space = DesignSpace(n_joints=len(order), lengths=mode, total_length=total, max_length=longest)
    design = space.design(shares(space, order, fractions))
    assert design.sampled_joints == order
    assert len(design.lengths) == len(order)
    assert min(design.lengths) >= 0
    assert all(length <= longest for length in design.lengths[:-1])
    assert design.total_length == pytest.approx(total, abs=1e-15)
    design.check_total(total)


@pytest.mark.parametrize("mode", MODES)
def test_design_of_the_parameters_is_the_design_suggested(mode: str) -> None:
    """A trial's parameters rebuild its design, and the distributions found for them are those it drew from."""
    space = DesignSpace(n_joints=7, lengths=mode)
    study = optuna.create_study(sampler=optuna.samplers.RandomSampler(seed=1))
    for _ in range(50):
        trial = study.ask()
        design = space.suggest(trial)
        assert space.design(trial.params) == design
        assert space.distributions(trial.params) == trial.distributions
        assert list(space.distributions(trial.params)) == list(trial.params)


def test_fractions_have_ranges_that_never_change() -> None:
    """In fractions mode all lengths are drawn from [0, 1], whatever came before."""
    space = DesignSpace(n_joints=6, lengths="fractions")
    for fractions in ([0.0] * 5, [1.0] * 5, [0.3, 0.9, 0.5, 0.1, 1.0]):
        drawn = space.distributions(shares(space, "PRRYPY", fractions))
        assert [drawn[f"u{i}"] for i in range(1, 6)] == [optuna.distributions.FloatDistribution(0, 1)] * 5
        assert set(drawn) == {f"J{i}" for i in range(1, 7)} | {f"u{i}" for i in range(1, 6)}


def test_sequential_ranges_end_at_what_remains() -> None:
    """In sequential mode L_i is drawn from [0, min(0.3, remaining)], in metres, and the last link is not drawn."""
    space = DesignSpace(lengths="sequential")
    params = {f"J{i}": "P" for i in range(1, 7)} | {"L1": 0.1, "L2": 0.3, "L3": 0.125, "L4": 0.05, "L5": 0.0}
    drawn = space.distributions(params)
    highs = [drawn[f"L{i}"].high for i in range(1, 6)]  # type: ignore[attr-defined]
    assert highs == pytest.approx([0.3, 0.3, 0.2, 0.075, 0.025], abs=1e-15)
    assert all(drawn[f"L{i}"].low == 0 for i in range(1, 6))  # type: ignore[attr-defined]
    assert space.design(params).lengths == pytest.approx((0.1, 0.3, 0.125, 0.05, 0, 0.025), abs=1e-15)


def test_last_link_may_exceed_the_longest() -> None:
    """With all else at zero the last link takes the whole length, twice the longest that is drawn."""
    for mode in MODES:
        space = DesignSpace(lengths=mode)
        design = space.design(shares(space, "PPPPPP", [0.0] * 5))
        assert design.lengths == (0, 0, 0, 0, 0, 0.6)


def test_remainder_below_zero_from_rounding() -> None:
    """Lengths that add up to a rounding more than the total leave links of length zero, not below."""
    used = (0.035, 0.029, 0.6 - (0.035 + 0.029))
    assert 0.6 - sum(used) < 0
    letters = {f"J{i}": "R" for i in range(1, 6)}
    params = {
        "sequential": letters | {"L1": used[0], "L2": used[1], "L3": used[2], "L4": 0.0},
        "fractions": letters | {"u1": used[0] / 0.6, "u2": used[1] / (0.6 - used[0]), "u3": 1.0, "u4": 1.0},
    }
    for mode in MODES:
        design = DesignSpace(n_joints=5, lengths=mode, max_length=0.6).design(params[mode])
        assert design.lengths == (*used, 0.0, 0.0)


def test_one_joint_needs_no_lengths() -> None:
    """An arm of one joint has one link of the whole length and one parameter."""
    for mode in MODES:
        space = DesignSpace(n_joints=1, lengths=mode)
        assert space.design({"J1": "Y"}) == Design("Y", (0.6,))
        assert set(space.distributions({"J1": "Y"})) == {"J1"}


def test_only_the_letters_of_the_space_are_drawn() -> None:
    """A space of pitches and yaws draws no rolls."""
    space = DesignSpace(joint_types="PY")
    study = optuna.create_study(sampler=optuna.samplers.RandomSampler(seed=0))
    drawn = "".join(space.suggest(study.ask()).sampled_joints for _ in range(40))
    assert set(drawn) == {"P", "Y"}
    with pytest.raises(ValueError, match="R"):
        space.suggest(FixedTrial(shares(space, "PRPPPP", [0.5] * 5)))


@pytest.mark.parametrize(
    ("joints", "lengths", "words"),
    [
        ("PRXYPY", (0.1,) * 6, ("'X'", "place 3", "R (roll), P (pitch), Y (yaw) or S (slide)")),
        ("prr", (0.2,) * 3, ("'p'", "place 1")),
        ("P R", (0.2,) * 3, ("' '", "place 2")),
        ("", (), ("0 joints", "1 to 64")),
        ("P" * 65, (0.01,) * 65, ("65 joints", "1 to 64")),
        ("PRR", (0.3, 0.3), ("2 lengths for 3 joints", "3 lengths in metres")),
        ("PRR", (0.3, -1e-9, 0.3), ("length 2 is -1e-09",)),
        ("PRR", (0.3, math.nan, 0.3), ("length 2 is nan",)),
        ("PRR", (0.3, 0.3, math.inf), ("length 3 is inf",)),
    ],
)
def test_bad_designs(joints: str, lengths: tuple[float, ...], words: tuple[str, ...]) -> None:
    """A design that cannot be is refused in one line with letter, place or length."""
    with pytest.raises(InputError) as error:
        Design(joints, lengths)
    one_line(error, *words)


def test_lengths_must_add_up_within_a_micrometre() -> None:
    """Lengths that miss the total by more than 1e-6 m are refused, naming both sums."""
    Design("PR", (0.3, 0.3 + 0.9e-6)).check_total(0.6)
    Design("PR", (0.3, 0.3 - 0.9e-6)).check_total(0.6)
    for wrong in (0.3 + 1.1e-6, 0.3 - 1.1e-6, 0.0):
        with pytest.raises(InputError) as error:
            Design("PR", (0.3, wrong)).check_total(0.6)
        one_line(error, "lengths add up to", "0.6 m within 1e-06")


def test_designs_are_values() -> None:
    """Designs of equal joints and lengths are equal, hash alike, and cannot be changed."""
    design = Design("PR", (0.1, 1))
    assert design == Design("PR", (0.1, 1.0))
    assert hash(design) == hash(Design("PR", (0.1, 1.0)))
    assert design != Design("PR", (0.1, 0.9))
    with pytest.raises(AttributeError):
        design.sampled_joints = "RR"  # type: ignore[misc]


def test_space_survives_yaml(tmp_path: Path) -> None:
    """A space written as YAML reads back equal; fields left out keep the paper's values."""
    space = DesignSpace(n_joints=7, joint_types="YP", lengths="sequential", total_length=0.8, joint_limit=4.7)
    path = tmp_path / "space.yaml"
    path.write_text("".join(f"{name}: {value}\n" for name, value in space.to_dict().items()))
    assert DesignSpace.from_yaml(path) == space
    path.write_text("n_joints: 7\n")
    assert DesignSpace.from_yaml(path) == DesignSpace(n_joints=7)
    path.write_text("")
    assert DesignSpace.from_yaml(path) == DesignSpace()


def test_defaults_are_the_papers_experiment() -> None:
    """The default space is that of the paper's 6-DOF experiment."""
    expected = (6, "RPY", 0.6, 0.3, 0.75 * math.pi, 0.5, 0.015, 1000.0)
    space = DesignSpace()
    assert expected == (
        *(space.n_joints, space.joint_types, space.total_length, space.max_length),
        *(space.joint_limit, space.motor_mass, space.link_radius, space.link_density),
    )


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("arms: 6", ("unknown field 'arms'", "n_joints")),
        ("joints: 6", ("joints = 6", "a list of letters joint by joint", "n_joints")),
        ("n_joints: six", ("n_joints = 'six'", "integer")),
        ("n_joints: 0", ("n_joints = 0", "greater than or equal to 1")),
        ("n_joints: 5000", ("n_joints = 5000", "12")),
        ("n_joints: 6.5", ("n_joints = 6.5",)),
        ("n_joints: [6]", ("n_joints = [6]",)),
        ("lengths: random", ("lengths = 'random'", "fractions", "sequential")),
        ("joint_types: RX", ("RX", "distinct letters of RPY")),
        ("joint_types: RR", ("RR", "distinct letters of RPY")),
        ("joint_types: ''", ("distinct letters of RPY",)),
        ("total_length: 0", ("total_length = 0", "greater than 0")),
        ("total_length: .nan", ("total_length = nan", "finite")),
        ("max_length: .inf", ("max_length = inf", "finite")),
        ("motor_mass: -1", ("motor_mass = -1", "greater than 0")),
        ("link_radius: 0", ("link_radius = 0", "greater than 0")),
        ("- 6", ("[6]", "a mapping of names to values")),
        ("n_joints: [", ("not YAML",)),
        ("a: &a 1\nb: *c", ("not YAML",)),
        ("\x00", ("not YAML",)),
        ("#" * 100_001, ("file too large", "100000")),
    ],
)
def test_bad_spaces(tmp_path: Path, text: str, words: tuple[str, ...]) -> None:
    """A YAML that is no design space is refused in one line with file, field, value and what was expected."""
    path = tmp_path / "space.yaml"
    path.write_text(text)
    with pytest.raises(InputError) as error:
        DesignSpace.from_yaml(path)
    one_line(error, str(path), *words)


def test_unreadable_spaces(tmp_path: Path) -> None:
    """No file, a folder, and bytes that are not text are refused in one line with the path."""
    (tmp_path / "bytes.yaml").write_bytes(b"\xff\xfe\xfa")
    for path in (tmp_path / "none.yaml", tmp_path, tmp_path / "bytes.yaml"):
        with pytest.raises(InputError) as error:
            DesignSpace.from_yaml(path)
        one_line(error, str(path), "YAML")


def test_lengths_are_added_one_after_the_other() -> None:
    """As Python 3.11 adds them, on every Python: sums rounded once at the end would change recorded designs."""
    from mobo_core.design.lengths import added

    lengths = [0.1] * 10
    assert added(lengths) == 0.9999999999999999 != math.fsum(lengths)
    assert added([]) == 0.0
