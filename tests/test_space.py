"""Spaces beside the paper's: bounds of lengths, what is fixed, what differs from joint to joint."""

from __future__ import annotations

import itertools
import math
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import optuna
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from optuna.trial import FixedTrial
from studies import run_study

from mobo_core.bag.collector import read_study
from mobo_core.design import SPACES, Design, DesignSpace, effective_joints, load_space, to_urdf
from mobo_core.design.lengths import Links, nearest
from mobo_core.design.numbers import of_joint
from mobo_core.design.prepared import PreparedXacro
from mobo_core.errors import InputError
from mobo_core.evaluation import EvaluationSpec
from mobo_core.evaluation.chain import chain_from_urdf
from mobo_core.evaluation.evaluate import evaluate
from mobo_core.search import contract
from mobo_core.search.samplers.registry import SAMPLERS
from mobo_core.search.study import StudySettings
from mobo_core.settings import Settings
from mobo_core.verify.verify import verify

MODES = ("fractions", "sequential")
METRES = st.floats(0, 0.5).map(lambda x: round(x, 3))


class Drawn(FixedTrial):
    """A trial of numbers from a stream, often at the ends of their range."""

    def __init__(self, seed: int) -> None:
        super().__init__({})
        self.random = random.Random(seed)
        self.drawn: dict[str, Any] = {}

    def suggest_categorical(self, name: str, choices: Any) -> Any:
        return self.drawn.setdefault(name, self.random.choice(choices))

    def suggest_float(self, name: str, low: float, high: float, **_: Any) -> float:
        assert low <= high and math.isfinite(high)
        x = self.random.choice([low, high, self.random.uniform(low, high), self.random.uniform(low, high)])
        return self.drawn.setdefault(name, x)  # type: ignore[no-any-return]


@st.composite
def spaces(draw: st.DrawFn) -> DesignSpace:
    """Return a space whose total, or range of totals, its links can make."""
    n = draw(st.integers(1, 8))
    least = draw(st.sampled_from([0.0, 0.03, 0.05, 0.1]))
    values: dict[str, Any] = {
        "n_joints": n,
        "min_length": least,
        "max_length": max(least, draw(METRES), 0.01),
        "zero_lengths": draw(st.sampled_from(["allowed", "wrist", "never"] if least else ["allowed"])),
        "last_link": draw(st.sampled_from(["bounded", "remainder"])),
        "fixed_lengths": draw(st.just([]) | st.lists(st.none() | st.none() | METRES, min_size=n, max_size=n)),
        "lengths": draw(st.sampled_from(MODES)),
    }
    zero = values["zero_lengths"]
    may_be_zero = tuple(zero == "allowed" or (zero == "wrist" and n - 3 <= i < n - 1) for i in range(n))
    fixed = tuple(values["fixed_lengths"]) or (None,) * n
    links = Links(least, values["max_length"], may_be_zero, fixed, values["last_link"] == "bounded")
    low, high = draw(st.sampled_from(links.totals))
    a, b = sorted(low + draw(st.floats(0, 1)) * (min(high, low + 2.0) - low) for _ in "ab")
    if b <= 0:
        values["fixed_lengths"], values["last_link"], a, b = [], "remainder", n * 0.2, n * 0.2
    values["total_length"] = [a, b] if 0 < a < b else b
    return DesignSpace.of(values)


def bounds_of(space: DesignSpace, i: int) -> list[tuple[float, float]]:
    """Return what link ``i`` may have, written out from the settings."""
    fixed = space.fixed_lengths or (None,) * space.n_joints
    if (length := fixed[i]) is not None:
        return [(length, length)]
    last = max(j for j in range(space.n_joints) if fixed[j] is None)
    longest = math.inf if i == last and space.last_link == "remainder" else space.max_length
    wrist = space.n_joints - 3 <= i <= space.n_joints - 2
    may_be_zero = space.zero_lengths == "allowed" or (space.zero_lengths == "wrist" and wrist)
    return [(space.min_length, longest)] + [(0.0, 0.0)] * may_be_zero


@given(spaces(), st.integers(0, 2**32))
@settings(max_examples=300, deadline=None)
def test_every_arm_drawn_keeps_to_all_bounds_and_its_parameters_are_found_again(space: DesignSpace, seed: int) -> None:
    """Lengths are within their bounds exactly, add up to the total, and give parameters that give them again."""
    trial = Drawn(seed)
    design = space.suggest(trial)
    for i, length in enumerate(design.lengths):
        assert any(low <= length <= high for low, high in bounds_of(space, i)), (i, length)
    low, high = space.total_ends
    assert low - 1e-9 <= design.total_length <= high + 1e-9
    params = space.params(design)
    assert params.keys() == trial.drawn.keys()
    again = space.design(params)
    assert again.sampled_joints == design.sampled_joints
    assert again.lengths == pytest.approx(design.lengths, rel=0, abs=1e-9)
    assert set(space.distributions(params)) == set(params)
    other = DesignSpace.of({**space.to_dict(), "lengths": MODES[space.lengths == "fractions"]})
    assert other.design(other.params(design)).lengths == pytest.approx(design.lengths, rel=0, abs=1e-9)


@pytest.mark.parametrize("mode", MODES)
def test_bounds_are_reached_exactly(mode: str) -> None:
    """Links of exactly zero, the shortest and the longest length have parameters, and are drawn."""
    space = DesignSpace.of({"min_length": 0.05, "last_link": "bounded", "lengths": mode})
    for lengths in ((0.3, 0.0, 0.05, 0.2, 0.0, 0.05), (0.0, 0.0, 0.0, 0.0, 0.3, 0.3), (0.05, 0.3, 0.0, 0.0, 0.05, 0.2)):
        found = space.design(space.params(Design("YPPYPY", lengths))).lengths
        exact = [(a, b) for a, b in zip(lengths, found, strict=True) if a in (0.0, 0.05, 0.3)]
        assert [b for _, b in exact[:-1]] == [a for a, _ in exact[:-1]]
    study = optuna.create_study(sampler=optuna.samplers.RandomSampler(seed=0))
    drawn = [space.suggest(study.ask()).lengths for _ in range(200)]
    assert sum(0.0 in lengths for lengths in drawn) > 20


def test_a_range_of_totals_is_searched() -> None:
    """The total is a parameter T, the links add up to it, and an arm's own total is found again."""
    space = DesignSpace.of({"total_length": [0.5, 0.9], "n_joints": 4})
    study = optuna.create_study(sampler=optuna.samplers.RandomSampler(seed=0))
    totals = []
    for _ in range(40):
        trial = study.ask()
        totals.append(space.suggest(trial).total_length)
        assert totals[-1] == pytest.approx(trial.params["T"], abs=1e-12)
    assert min(totals) < 0.55 and max(totals) > 0.85
    params = space.params(Design("RPRP", (0.2, 0.2, 0.2, 0.1)))
    assert params["T"] == pytest.approx(0.7)
    with pytest.raises(InputError, match="add up to 1 m; expected 0.5 to 0.9 m"):
        space.params(Design("RPRP", (0.3, 0.3, 0.3, 0.1)))


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"total_length": 2.5, "last_link": "bounded"}, "total_length of at most 1.8 m: 6 links of max_length 0.3 m"),
        ({"min_length": 0.15, "zero_lengths": "never"}, "total_length of at least 0.9 m: 6 links of min_length 0.15 m"),
        ({"min_length": 0.2, "zero_lengths": "wrist"}, "total_length of at least 0.8 m: 4 links of min_length 0.2 m"),
        ({"fixed_lengths": [0.5, 0.2, None, None, None, None]}, "total_length of at least 0.7 m"),
        ({"fixed_lengths": [0.1] * 6, "total_length": 0.7}, "to be the sum of fixed_lengths, 0.6 m"),
        ({"fixed_lengths": [0.1] * 5}, "fixed_lengths to have 6 entries, one a joint, not 5"),
        ({"min_length": 0.25, "max_length": 0.26, "last_link": "bounded"}, "within 0 or 0.25 to 0.26 or 0.5 to 0.52"),
        ({"min_length": 0.4}, "min_length 0.4 m to be at most max_length, 0.3 m"),
        ({"zero_lengths": "never"}, "a min_length above 0 for zero_lengths: never"),
        ({"total_length": [0.6, 0.4]}, "low < high"),
        ({"total_length": [0.4, 2.0], "last_link": "bounded"}, "at most 1.8 m"),
        ({"joint_limit": "135degrees"}, "text such as 135deg"),
        ({"joint_limit": "400deg"}, "less than or equal to 6.28"),
        ({"joint_limit": 135}, "less than or equal to 6.28319 rad; degrees are written 135deg"),
        ({"motor_mass": [0.5, 0.4]}, "motor_mass to have 6 entries, one a joint, not 2"),
        ({"motor_mass": [0.5, 0.4, 0.3, 0.2, 0.1, 0]}, "greater than 0"),
        ({"joints": ["Y", "PX"]}, "distinct letters of RPY"),
        ({"joints": ["Y", "P"], "n_joints": 3}, "joints to have 3 entries, one a joint, not 2"),
    ],
)
def test_settings_that_do_not_fit(values: dict[str, Any], words: str) -> None:
    """They are refused in one line that names the bound that bites."""
    with pytest.raises(InputError) as error:
        DesignSpace.of(values)
    assert words in str(error.value) and "\n" not in str(error.value)


def test_a_total_that_only_an_endless_last_link_makes(tmp_path: Path) -> None:
    """It is refused of a file that people write, not of a bag that holds it."""
    (tmp_path / "space.yaml").write_text("total_length: 2.5\n")
    with pytest.raises(InputError, match="total_length 2.5 m; expected at most 1.8 m, which 6 links of max_length 0.3"):
        load_space(str(tmp_path / "space.yaml"))
    assert load_space(str(tmp_path / "space.yaml"), {"n_joints": 9}).n_joints == 9
    assert DesignSpace.of({"total_length": 2.5}).total_length == 2.5


def test_letters_joint_by_joint() -> None:
    """Each joint has its own letters; a joint of one letter is no parameter; the orders are counted so."""
    space = DesignSpace.of({"joints": ["Y", "P", "P", "RPY", "PY", "RPY"]})
    orders = {effective_joints("".join(order)) for order in itertools.product(*space.places)}
    assert (space.n_joints, space.letters, space.n_orders) == (6, "YPR", len(orders))
    study = optuna.create_study(sampler=optuna.samplers.RandomSampler(seed=0))
    found = set()
    for _ in range(100):
        trial = study.ask()
        design = space.suggest(trial)
        found.add(design.joints)
        assert {name for name in trial.params if name[0] == "J"} == {"J4", "J5", "J6"}
        assert space.params(design).keys() == trial.params.keys()
    assert found == orders
    with pytest.raises(InputError, match=r"joint 'R' at place 5; expected letters of PY"):
        space.params(Design("YPPRRP", (0.1,) * 6))


def test_angles_as_text_and_lists() -> None:
    """135deg is the paper's limit to the bit; lists hold one number a joint, and survive their own text."""
    assert DesignSpace.of({"joint_limit": "135deg"}) == DesignSpace()
    space = DesignSpace.of({"n_joints": 2, "joint_limit": ["90deg", "1.5rad"], "motor_mass": [1, 0.5]})
    assert space.joint_limit == (math.radians(90), 1.5) and space.motor_mass == (1.0, 0.5)
    assert DesignSpace.of(space.to_dict()) == space


@pytest.mark.parametrize("name", SPACES)
def test_presets(name: str) -> None:
    """A preset is a space by name; the paper's is the default."""
    space: Settings = load_space(name)
    assert (space == DesignSpace()) == (name == "paper")
    assert DesignSpace.of(space.to_dict()) == space
    with pytest.raises(InputError, match="no preset or file 'dask'; expected paper, desk or a YAML file"):
        load_space("dask")


def test_desk_arms_can_be_built() -> None:
    """No link of the desk's arms is shorter than 5 cm or longer than 30 cm."""
    space = load_space("desk")
    study = optuna.create_study(sampler=optuna.samplers.RandomSampler(seed=0))
    for _ in range(50):
        lengths = space.suggest(study.ask()).lengths
        assert min(lengths) >= 0.05 and max(lengths) <= 0.3 and sum(lengths) == pytest.approx(0.6)


pairs = st.tuples(st.floats(0, 1), st.floats(0, 1)).map(lambda pair: (min(pair), max(pair)))


@given(st.lists(pairs, min_size=1), st.floats(0, 1))
def test_nearest(intervals: list[tuple[float, float]], x: float) -> None:
    """It lies in an interval, and no end of any is nearer."""
    found = nearest(intervals, x)
    assert any(low <= found <= high for low, high in intervals)
    assert all(abs(found - x) <= abs(end - x) for pair in intervals for end in pair)


def motors(urdf: str) -> list[str]:
    """Return the names of a URDF's collision shapes."""
    robot = ElementTree.fromstring(urdf)
    return [shape.get("name", "") for shape in robot.iter("collision")]


BODIES = {"motor_radius": 0.02, "motor_length": [0.03, 0.02, 0.01]}


def test_motor_bodies_are_capsules_along_the_axes() -> None:
    """Each is a further shape of its joint's link; pairs that touch in the straight arm are left out."""
    design = Design("YPR", (0.2, 0.0, 0.25))
    plain = to_urdf(design, DesignSpace(n_joints=3))
    assert motors(plain) == ["link_1", "link_3"]
    urdf = to_urdf(design, DesignSpace.of({"n_joints": 3} | BODIES))
    assert motors(urdf) == ["motor_1", "link_1", "motor_2", "motor_3", "link_3"]
    chain = chain_from_urdf(urdf)
    np.testing.assert_allclose(chain.capsule_radius, [0.02, 0.015, 0.02, 0.02, 0.015])
    along = chain.capsule_b - chain.capsule_a
    # Joint frames are turned so that every axis is z.
    np.testing.assert_allclose(np.abs(along[[0, 2, 3]]), [[0, 0, 0.03], [0, 0, 0.02], [0, 0, 0.01]], atol=1e-15)
    assert {tuple(pair) for pair in chain.pairs} == {(0, 2), (0, 3), (0, 4)}


def test_motor_bodies_collide() -> None:
    """A folded arm that is free without motors is not with them."""
    design, spec = Design("YPPYPY", (0.05, 0.25, 0.15, 0.05, 0.05, 0.05)), EvaluationSpec.of({"poses_per_voxel": 5})
    free, bound = (
        evaluate(design, spec, space=DesignSpace.of(values))
        for values in ({}, {"motor_radius": 0.04, "motor_length": 0.05})
    )
    assert bound.failures()["in_collision"] > free.failures()["in_collision"]
    assert 0 < bound.reach < free.reach


@pytest.mark.parametrize("height, tilt", [(0.3, 0.0), (0.0, 0.5), (0.2, -math.pi / 2)])
def test_the_base_moves_the_arm_as_a_whole(height: float, tilt: float) -> None:
    """The tip is where a turn about y and a lift put that of the arm at the origin; the root stays base_link."""
    space = DesignSpace.of({"n_joints": 3, "base_height": height, "base_tilt": tilt})
    design = space.arm("YPR", (0.1, 0.2, 0.3))
    model = pin.buildModelFromXML(to_urdf(design, space))
    data = model.createData()
    pin.framesForwardKinematics(model, data, np.zeros(3))
    tip = data.oMf[model.getFrameId("tool")].translation
    np.testing.assert_allclose(tip, [0.6 * math.sin(tilt), 0, height + 0.6 * math.cos(tilt)], atol=1e-12)
    assert model.getFrameId("base_link", pin.BODY) < model.getFrameId("mount", pin.BODY) < model.nframes


def test_an_upright_arm_at_the_origin_has_no_mount() -> None:
    """Its URDF is that of the paper's space, to the byte."""
    design = Design("YPR", (0.1, 0.2, 0.3))
    plain = to_urdf(design, DesignSpace(n_joints=3))
    assert "mount" not in plain
    searched = DesignSpace.of({"n_joints": 3, "base_height": [-0.1, 0.1], "base_tilt": ["-30deg", "30deg"]})
    assert to_urdf(searched.arm("YPR", design.lengths), searched) == plain


@pytest.mark.parametrize("mode", MODES)
def test_a_searched_base(mode: str) -> None:
    """Its height and tilt are parameters, and are found again."""
    space = DesignSpace.of({"base_height": [0.0, 0.5], "base_tilt": [0, "90deg"], "lengths": mode})
    study = optuna.create_study(sampler=optuna.samplers.RandomSampler(seed=0))
    for _ in range(20):
        trial = study.ask()
        design = space.suggest(trial)
        assert design.base_height == trial.params["base_height"] and design.base_tilt == trial.params["base_tilt"]
        again = space.design(space.params(design))
        assert (again.base_height, again.base_tilt) == (design.base_height, design.base_tilt)
        assert again.lengths == pytest.approx(design.lengths, rel=0, abs=1e-9)
    with pytest.raises(InputError, match="base_height is 0.7; expected 0 to 0.5"):
        space.params(Design("YPPYPY", (0.1,) * 6, 0.7))


def test_searched_centers_of_ranges() -> None:
    """They are parameters, are found again, and turn an arm as a base that leans does."""
    space = DesignSpace.of({"n_joints": 3, "joint_center": [["-90deg", "90deg"], 0.3, [0, 1]]})
    study = optuna.create_study(sampler=optuna.samplers.RandomSampler(seed=0))
    for _ in range(20):
        trial = study.ask()
        design = space.suggest(trial)
        assert design.joint_centers == (trial.params["c1"], 0.3, trial.params["c3"])
        assert space.design(space.params(design)).joint_centers == design.joint_centers
    with pytest.raises(InputError, match=r"joint_center 2 is 0; expected 0\.3"):
        space.params(Design("PRP", (0.2,) * 3, joint_centers=(0.0, 0.0, 0.5)))
    # A first pitch joint at a lean of a has the angles of one upright, less a.
    tips = []
    for values in ({"base_tilt": 0.7}, {"joint_center": [0.7, 0, 0]}):
        own = DesignSpace.of({"n_joints": 3, "joint_limit": [1.0, 2.0, 2.0]} | values)
        chain = chain_from_urdf(to_urdf(own.arm("PRP", (0.1, 0.2, 0.3)), own))
        model = pin.buildModelFromXML(to_urdf(own.arm("PRP", (0.1, 0.2, 0.3)), own))
        data = model.createData()
        pin.framesForwardKinematics(model, data, np.array([chain.upper[0], 0.5, -0.2]))
        tips.append(data.oMf[model.getFrameId("tool")].translation.copy())
    np.testing.assert_allclose(*tips, atol=1e-12)


OFF_PAPER = [
    {"joint_limit": [1.0, 2.0, "90deg", 3], "motor_mass": [0.4, 0.3, 0.2, 0.1]},
    {"motor_radius": [0.02, 0.0, 0.03, 0.02], "motor_length": 0.0},
    {"joint_center": [0.0, ["-90deg", "90deg"], -0.5, [0, 1]], "joint_limit": [1.0, 2.0, 1.5, 3]},
    {"base_height": [-0.2, 0.2], "base_tilt": [-1, 1], "motor_radius": 0.02, "motor_length": [0.01, 0.02, 0.03, 0.04]},
]


@pytest.mark.parametrize("values", OFF_PAPER)
def test_prepared_urdfs_are_those_of_xacro(values: dict[str, Any]) -> None:
    """To the byte, also with what differs from joint to joint, motor bodies and a base, and without xacro's help."""
    space = DesignSpace.of({"n_joints": 4} | values)
    prepared = PreparedXacro(space)
    study = optuna.create_study(sampler=optuna.samplers.RandomSampler(seed=0))
    for _ in range(30):
        design = space.suggest(study.ask())
        assert prepared.to_urdf(design) == to_urdf(design, space)
    assert not prepared.plain


@pytest.mark.parametrize("values", OFF_PAPER)
def test_limits_and_masses_joint_by_joint(values: dict[str, Any]) -> None:
    """Each joint of the URDF has the limit, and each link the motor, of its own place."""
    space = DesignSpace.of({"n_joints": 4} | values)
    chain = chain_from_urdf(to_urdf(space.arm("RPRP", (0.1, 0.2, 0.2, 0.1)), space))
    rod = math.pi * 0.015**2 * 1000
    limits = [of_joint(space.joint_limit, i) for i in range(4)]
    centers = [0.0, 0.0, -0.5, 0.5] if "joint_center" in values else [0.0] * 4
    np.testing.assert_allclose(chain.upper, np.add(centers, limits))
    np.testing.assert_allclose(chain.lower, np.subtract(centers, limits))
    masses = [of_joint(space.motor_mass, i) + rod * length for i, length in enumerate((0.1, 0.2, 0.2, 0.1))]
    np.testing.assert_allclose(chain.mass, masses)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["tpe", "structured", "random"])
@pytest.mark.parametrize("check", contract.CHECKS)
def test_samplers_keep_the_contract_on_the_desk(check: Callable[[StudySettings], None], name: str) -> None:
    """A study of the desk's arms is a function of its settings too."""
    over = {"base_height": [0.0, 0.3], "total_length": [0.5, 0.7]}
    for space in (load_space("desk"), load_space("desk", over), load_space("desk", {"lengths": "sequential"})):
        check(StudySettings.of({"space": space, "sampler": name, "in_flight": 3, "n_startup_trials": 8}))


@pytest.mark.parametrize("name", SAMPLERS)
def test_every_sampler_takes_every_space(name: str) -> None:
    """All but como take all; como takes those of fractions."""
    values = {"joints": ["Y", "P", "RPY", "PY"], "total_length": [0.5, 0.7], "min_length": 0.05} | OFF_PAPER[2]
    for mode in MODES:
        space = DesignSpace.of(values | {"lengths": mode, "zero_lengths": "wrist", "last_link": "bounded"})
        given = {"space": space, "sampler": name, "n_startup_trials": 4, "in_flight": 1}
        if name == "como" and mode == "sequential":
            with pytest.raises(InputError, match="another than como with sequential lengths"):
                StudySettings.of(given)
            continue
        for asked in contract.run(StudySettings.of(given), trials=20):
            assert space.params(asked.design).keys() == asked.params.keys()


@pytest.mark.slow
def test_a_study_of_the_desk_is_recorded_resumed_and_verified(tmp_path: Path) -> None:
    """Evaluated by the kernel, killed and resumed it has the trials of one that ran through, and its bag is good."""
    values = {
        "space": load_space("desk", {"base_tilt": [0, "30deg"], "total_length": [0.5, 0.7]}).to_dict(),
        "spec": {"poses_per_voxel": 2, "restarts": 1, "iterations": 20}, "n_startup_trials": 8, "in_flight": 2,
    }  # fmt: skip
    whole = run_study(tmp_path / "whole", 16, settings=values, engine="kernel")
    half = run_study(tmp_path / "half", 16, settings=values, engine="kernel", kill_after=7)
    run_study(half, 16, settings=values, engine="kernel", resume=True)
    told = [[(t.trial, t.reach, t.torque) for t in read_study(bag).trials.values()] for bag in (whole, half)]
    assert told[0] == told[1] and len(told[0]) == 16 and any(reach > 0 for _, reach, _ in told[0])
    assert read_study(half).settings == StudySettings.of(values)
    assert not verify(read_study(half)).faults
