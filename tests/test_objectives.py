"""Objectives beyond reach and torque: their values, their bits, and those of other distributions."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin
import pytest
from arms import HANDED_ARM, LENGTHS, arm, random_arm, small_spec

from mobo_core.errors import InputError, UnableError
from mobo_core.evaluation import EvaluationSpec
from mobo_core.evaluation import evaluate as evaluate_module
from mobo_core.evaluation.batch import Batch
from mobo_core.evaluation.chain import Chain, chain_from_urdf
from mobo_core.evaluation.evaluate import evaluate
from mobo_core.evaluation.objectives import OBJECTIVES, Accumulator, Known, Objective
from mobo_core.evaluation.reference import ReferenceModel

PAPER = EvaluationSpec()
EXTRA = ("mean_torque", "peak_torque", "manipulability", "mass", "axes")


def test_built_in_objectives() -> None:
    """Their names, in order; each has a unit, a summary and a bound above 0; their bits hold everywhere."""
    names = ["reach", "torque", "mean_torque", "peak_torque", "manipulability", "mass", "axes"]
    assert [objective.name for objective in OBJECTIVES.built_in] == names
    assert all(objective.unit and objective.summary and not objective.tolerance for objective in OBJECTIVES.built_in)
    assert all(objective.bound(PAPER) > 0 for objective in OBJECTIVES.built_in)
    assert [o.name for o in OBJECTIVES.built_in if o.direction == "maximize"] == ["reach", "manipulability"]
    with pytest.raises(InputError, match="parameter objectives: 'cost'; expected reach, torque, "):
        OBJECTIVES.of("cost", "parameter objectives")


def test_reach_and_torque_have_the_bounds_of_every_hypervolume() -> None:
    """Reach is at most the number of voxels; torque is measured from 10 N m each."""
    assert (OBJECTIVES["reach"].bound(PAPER), OBJECTIVES["torque"].bound(PAPER)) == (75.0, 750.0)


def test_a_payload_moves_the_bounds() -> None:
    """A heavier payload makes room for torque and mass, as far as the workspace goes."""
    heavy = EvaluationSpec(payload_kg=2.0)
    more = {name: OBJECTIVES[name].bound(heavy) - OBJECTIVES[name].bound(PAPER) for name in ("mean_torque", "mass")}
    assert more == {"mean_torque": pytest.approx(2.0 * 9.81 * 0.75**0.5), "mass": 2.0}


@pytest.mark.parametrize("joints", sorted(LENGTHS))
def test_values_are_those_of_pinocchio(joints: str) -> None:
    """Of a real evaluation: what the libraries give for the accepted configurations, and their definitions."""
    spec = small_spec(payload_kg=0.7, gravity=(1.0, 2.0, -9.0), poses_per_voxel=30)
    result = evaluate(arm(joints), spec, objectives=EXTRA, configurations=True)
    found = result.configurations
    assert found is not None and len(found.q) > 20
    model = ReferenceModel(chain_from_urdf(arm(joints), payload_kg=0.7, gravity=spec.gravity))
    torques = np.array([model.torque(q) for q in found.q])
    assert result.extra["peak_torque"] == pytest.approx(np.abs(torques).max(), rel=1e-12)
    norms = np.linalg.norm(torques, axis=1)
    means = [norms[found.voxel == voxel].mean() for voxel in np.unique(found.voxel)]
    assert result.extra["mean_torque"] == pytest.approx(np.mean(means), rel=1e-12)
    assert result.extra["mean_torque"] == pytest.approx(result.torque / np.count_nonzero(result.voxel_reach), rel=1e-12)
    jacobians = [model.jacobian(q) for q in found.q]
    measures = [math.sqrt(max(0.0, np.linalg.det(jac @ jac.T))) for jac in jacobians]
    assert result.extra["manipulability"] == pytest.approx(np.mean(measures), rel=1e-9)
    assert result.extra["mass"] == pytest.approx(pin.computeTotalMass(model.model), rel=1e-12)


@pytest.mark.parametrize(("urdf", "tip"), [(arm("RPYPRP"), ""), (HANDED_ARM, "tcp"), (random_arm(3), "flange")])
def test_measures_at_random_configurations(urdf: str, tip: str) -> None:
    """Torque of each joint and manipulability are Pinocchio's anywhere within the limits."""
    chain = chain_from_urdf(urdf, tip, payload_kg=0.3, gravity=(0.5, -1.0, -9.5))
    q = np.random.default_rng(0).uniform(chain.lower, chain.upper, (200, chain.n))
    batch = Batch(chain, np.array([0.5, -1.0, -9.5]), np.arange(200), np.zeros(200, np.int64), q, np.zeros(200))
    model = ReferenceModel(chain)
    assert batch.joint_torque == pytest.approx(np.array([model.torque(row) for row in q]), rel=1e-9, abs=1e-11)
    # The determinant, squared singular values in a row, loses digits that the values themselves keep.
    measures = [np.prod(np.linalg.svd(model.jacobian(row), compute_uv=False)) for row in q]
    measures = measures if chain.n >= 6 else [0.0] * 200
    assert batch.manipulability == pytest.approx(measures, rel=1e-7, abs=1e-10)


def test_manipulability_of_few_joints_and_of_the_straight_arm_is_none() -> None:
    """Fewer than 6 joints move the tip in less than 6 ways, and so do all of them on one line."""
    for joints, lengths in (("YPPYP", (0.1, 0.2, 0.1, 0.1, 0.1)), ("PRRYPY", LENGTHS["PRRYPY"])):
        chain = chain_from_urdf(arm(joints, lengths, n_joints=len(joints)))
        one = np.zeros(1)
        batch = Batch(chain, np.zeros(3), one.astype(int), one.astype(int), np.zeros((1, chain.n)), one)
        assert batch.manipulability[0] == pytest.approx(0.0, abs=1e-9)


def test_joints_at_one_place_are_one_axis() -> None:
    """The places of joints are counted by the lengths between them: none of length, none more."""
    for lengths, places in (
        ((0.1, 0.1, 0.1, 0.1, 0.1, 0.1), 6.0),
        ((0.0, 0.3, 0.2, 0.1, 0.0, 0.0), 4.0),
        ((0.0, 0.0, 0.3, 0.0, 0.0, 0.3), 2.0),
        ((0.3, 0.0005, 0.2995, 0.0, 0.0, 0.0), 3.0),
    ):
        assert evaluate(arm("YPPYPY", lengths), small_spec(), objectives=("axes",)).extra == {"axes": places}


def test_an_arm_that_reaches_nothing_is_not_worth_much() -> None:
    """It has the worst of torques, not the best, and no manipulability; its mass and axes are what they are."""
    far = EvaluationSpec(workspace_min=(5.0, 5.0, 5.0), workspace_max=(5.2, 5.2, 5.2), poses_per_voxel=3)
    result = evaluate(arm("PRRYPY"), far, objectives=EXTRA)
    assert result.reach == 0
    worst = {name: OBJECTIVES[name].bound(far) for name in ("mean_torque", "peak_torque")}
    assert result.extra == {**worst, "manipulability": 0.0, "mass": pytest.approx(3.424, abs=1e-3), "axes": 5.0}


@pytest.mark.parametrize(("urdf", "tip"), [(arm("PRRYPY"), ""), (HANDED_ARM, "tcp")])
def test_bits_do_not_depend_on_chunks_or_threads(urdf: str, tip: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """All values are the same to the bit in chunks of any size, with any number of threads."""
    expected = evaluate(urdf, PAPER, tip=tip, objectives=EXTRA).extra
    assert all(value > 0 for value in expected.values())
    assert evaluate(urdf, PAPER, tip=tip, objectives=EXTRA, threads=2).extra == expected
    for chunk in (1, 100, 30 * 74):
        monkeypatch.setattr(evaluate_module, "_CHUNK_POSES", chunk)
        assert evaluate(urdf, PAPER, tip=tip, objectives=EXTRA).extra == expected, chunk


def test_known_bits() -> None:
    """The values are, on this machine too, those of the machine on which this test was written."""
    assert evaluate(arm("PRRYPY"), PAPER, objectives=EXTRA).extra == {
        "mean_torque": 5.864945052730334,
        "peak_torque": 8.663046619166957,
        "manipulability": 0.016722859352491078,
        "mass": 3.4241150082346223,
        "axes": 5.0,
    }


def test_nothing_is_measured_that_is_not_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reach and torque alone, or with what needs no measure of joints, compute none."""
    for name in ("joint_torques", "manipulabilities"):
        monkeypatch.setattr(f"mobo_core.evaluation.batch.{name}", lambda *_: pytest.fail("measured"))
    assert evaluate(arm("PRRYPY"), small_spec(), objectives=("reach", "torque")).extra == {}
    names = ["mean_torque", "mass", "axes"]
    assert list(evaluate(arm("PRRYPY"), small_spec(), objectives=["reach", *names]).extra) == names


class Count:
    """How many configurations there are."""

    def __init__(self, chain: Chain, spec: EvaluationSpec) -> None:
        self.count = 0

    def add(self, batch: Batch) -> None:
        self.count += len(batch.q)

    def value(self) -> float:
        return float(self.count)


def test_objectives_of_others(monkeypatch: pytest.MonkeyPatch) -> None:
    """One that counts gets every accepted configuration once; one whose value is no number is refused by name."""

    def lost(chain: Chain, spec: EvaluationSpec) -> Accumulator:
        return Known(math.nan)

    count = Objective("count", "", "maximize", "How many", lambda spec: 1.0, Count)
    bad = Objective("lost", "", "maximize", "Nothing", lambda spec: 1.0, lost)
    entries = {**OBJECTIVES._entries, "count": count, "lost": bad}
    monkeypatch.setattr(OBJECTIVES, "_entries", entries)
    monkeypatch.setattr(evaluate_module, "_CHUNK_POSES", 50)
    result = evaluate(arm("PRRYPY"), small_spec(), objectives=("count",))
    assert result.extra == {"count": pytest.approx(10 * result.reach)}
    with pytest.raises(UnableError, match="objective 'lost': nan; expected a finite number"):
        evaluate(arm("PRRYPY"), small_spec(), objectives=("lost",))
    with pytest.raises(InputError, match="objective: 'cost'; expected reach, "):
        evaluate(arm("PRRYPY"), small_spec(), objectives=("cost",))
