"""The sampler como: cmaes's own loop, with failures, resume, designs from outside and several in flight."""

from __future__ import annotations

import itertools
import json
from typing import Any

import numpy as np
import pytest

from mobo_core.coordination.options import OptimizerOptions
from mobo_core.design import Design, DesignSpace
from mobo_core.errors import InputError
from mobo_core.search.front import hypervolume
from mobo_core.search.samplers.sampler import trial_seed
from mobo_core.search.study import OrderedStudy, StudySettings, Told

cmaes = pytest.importorskip("cmaes")

Values = tuple[float, float] | None
# Several updates of each kernel: a round of all ten takes some 130 trials.
MANY = 400
OUTSIDE = {
    "J1": "Y", "J2": "P", "J3": "P", "J4": "R", "J5": "P", "J6": "R",
    "u1": 0.5, "u2": 0.25, "u3": 1.0, "u4": 0.0, "u5": 0.125,
}  # fmt: skip


def settings_of(in_flight: int = 1, seed: int = 0, **space: Any) -> StudySettings:
    return StudySettings.of({"sampler": "como", "space": space, "in_flight": in_flight, "seed": seed})


def score(design: Design) -> Values:
    """Return (reach, torque in N m) of an arm: what reaches far is heavy; what begins with RR fails."""
    if design.joints.startswith("RR"):
        return None
    reach = 75 * min(1.0, 2.5 * sum(design.lengths[1:4])) * (0.4 + 0.1 * design.joints.count("P"))
    return reach, 8 * reach + 40 * design.joints.count("Y") + 400 * design.lengths[0]


def run(study: OrderedStudy, trials: int, outside: tuple[int, ...] = (), value: Any = score) -> list[Design]:
    """Go on up to ``trials``, those of the numbers ``outside`` with a design from outside."""
    while len(study.asked) < trials:
        if study.may_ask():
            study.recall(OUTSIDE) if len(study.asked) in outside else study.ask()
        else:
            tell_next(study, value)
    return [asked.design for asked in study.asked]


def tell_next(study: OrderedStudy, value: Any = score) -> None:
    number = len(study.told)
    study.tell(Told(number, value(study.asked[number].design)))


def test_is_the_loop_of_cmaes() -> None:
    """One in flight, the designs are those of the library's own ask and tell in batches; failures get the reference."""
    space = DesignSpace()
    reference = (0.0, 1.0)
    optimizer = cmaes.COMOCatCMAwM(
        x_space=[[0, 1]] * 5, c_space=[3] * 6, reference_point=reference, seed=trial_seed(5, 0)
    )
    expected: list[Design] = []
    failed = 0
    while len(expected) < MANY:
        told = []
        for solution in optimizer.ask_iter():
            joints = {f"J{i + 1}": "RPY"[k] for i, k in enumerate(np.nonzero(solution.c)[1])}
            lengths = {f"u{i + 1}": min(max(0.0, float(u)), 1.0) for i, u in enumerate(solution.x)}
            design = space.design(joints | lengths)
            expected.append(design)
            values = score(design)
            failed += values is None
            told.append((solution, reference if values is None else (-values[0] / 75, values[1] / 750)))
        optimizer.tell(told)
    assert optimizer.generation > 1
    assert failed > 10
    assert run(OrderedStudy(settings_of(seed=5)), MANY) == expected[:MANY]


@pytest.mark.slow
@pytest.mark.parametrize("in_flight", [1, 3])
def test_resume_after_updates(in_flight: int) -> None:
    """Resumed from its record it goes on as if never stopped, designs from outside among those recorded and to come."""
    settings = settings_of(in_flight)
    outside = (5, 30, 31, 217, 350)
    whole = OrderedStudy(settings)
    expected = run(whole, MANY, outside)
    for at in (31, 151, 330):
        again = OrderedStudy(settings)
        for past in whole.asked[:at]:
            while not again.may_ask():
                tell_next(again)
            assert again.recall(json.loads(json.dumps(past.params))) == past
        assert run(again, MANY, outside) == expected


@pytest.mark.slow
def test_a_design_from_outside_takes_the_place_of_none() -> None:
    """What was drawn for its trial is asked next, and the trials go on as without it, whatever its values."""
    settings = settings_of()
    plain = run(OrderedStudy(settings), MANY)
    for told in ((0.0, 1e9), (75.0, 0.0), None):
        outside = DesignSpace().design(OUTSIDE)
        designs = run(
            OrderedStudy(settings), MANY, (40, 41, 200),
            lambda design, told=told, outside=outside: told if design == outside else score(design),
        )  # fmt: skip
        assert [design for design in designs if design != outside] == plain[: MANY - 3]


def test_values_count() -> None:
    """Another value of one solution changes what comes after its kernel's update, and nothing before."""
    settings = settings_of()
    plain = run(OrderedStudy(settings), 100)
    changed = run(OrderedStudy(settings), 100, value=lambda d: (75.0, 1.0) if d == plain[3] else score(d))
    first = next(i for i, (a, b) in enumerate(zip(plain, changed, strict=True)) if a != b)
    assert 12 < first < 30


def test_all_trials_fail() -> None:
    """A study of nothing but failures goes on, and not with one design for ever."""
    designs = run(OrderedStudy(settings_of()), MANY, value=lambda _: None)
    assert len(set(designs[-100:])) > 50


def test_random_when_no_solution_can_be_asked() -> None:
    """What is in flight beyond the solutions there are is random from the trial's seed, and told to no kernel."""
    few, many = settings_of(1), settings_of(40)
    # Before the first update there is one kernel's population and the mean of each other.
    queue = cmaes.COMOCatCMAwM(x_space=[[0, 1]] * 5, c_space=[3] * 6).ask_queue_size
    assert 15 < queue < 40
    designs = run(OrderedStudy(many), 80)
    assert designs[:queue] == run(OrderedStudy(few), queue)
    random = OrderedStudy(StudySettings.of(few.to_dict() | {"sampler": "random"}))
    assert designs[queue:40] == run(random, 40)[queue:]
    extra = set(designs[queue:40])
    others = run(OrderedStudy(many), 80, value=lambda d: (75.0, 0.0) if d in extra else score(d))
    assert others == designs


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_finds_more_than_chance(seed: int) -> None:
    """After equal trials its hypervolume is above that of random arms."""

    def volume(settings: StudySettings) -> float:
        values = [score(design) or (0.0, 750.0) for design in run(OrderedStudy(settings), MANY)]
        return hypervolume(values, settings.aims)

    como = settings_of(seed=seed)
    assert volume(como) > volume(StudySettings.of(como.to_dict() | {"sampler": "random"})) + 0.005


@pytest.mark.parametrize(("n_joints", "types"), list(itertools.product((1, 2, 12), ("P", "PR", "RPY"))))
def test_any_space_of_fractions(n_joints: int, types: str) -> None:
    """Whatever the joints and their types, arms of the space are drawn; a space of one arm is refused."""
    if (n_joints, types) == (1, "P"):
        with pytest.raises(InputError, match=r"^StudySettings: sampler = 'como'; expected another .* one arm$"):
            settings_of(n_joints=n_joints, joint_types=types)
        return
    settings = settings_of(n_joints=n_joints, joint_types=types)
    for design in run(OrderedStudy(settings), 150):
        assert settings.space.params(design)


def test_sequential_lengths_are_refused() -> None:
    """In one line, where the settings are made."""
    with pytest.raises(InputError, match=r"^StudySettings: sampler = 'como'; expected another than como .* fractions"):
        settings_of(lengths="sequential")


@pytest.mark.parametrize(("given", "in_flight"), [(set(), 1), ({"in_flight"}, 8)])
def test_one_in_flight_unless_set(given: set[str], in_flight: int) -> None:
    """As a node's parameter, como has one trial in flight unless told otherwise."""
    settings = OptimizerOptions.of({"sampler": "como"} | dict.fromkeys(given, 8)).settings()
    assert (settings.sampler, settings.in_flight, settings.space.lengths) == ("como", in_flight, "fractions")
