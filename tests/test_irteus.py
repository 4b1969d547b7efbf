"""ik_mode irteus, of the reference engine alone."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from arms import arm

from mobo_core.coordination.options import StudyOptions
from mobo_core.errors import InputError, UnableError
from mobo_core.evaluation import EvaluationSpec, irteus
from mobo_core.evaluation.chain import chain_from_urdf
from mobo_core.evaluation.evaluate import evaluate
from mobo_core.evaluation.reference import ReferenceModel
from mobo_core.evaluation.spec import load_spec, with_ik
from mobo_core.jit.numerics import target_rotation
from mobo_core.search.study import StudySettings

AROUND = {"workspace_min": (-0.3, -0.3, -0.1), "workspace_max": (0.3, 0.3, 0.5), "voxel_size": 0.2}
CHAIN = chain_from_urdf(arm("PRRYPY"))


def test_it_reaches_what_the_kernels_method_reaches() -> None:
    """Within the tolerances by Pinocchio, free of collision, of about as many poses; first from zero."""
    spec = EvaluationSpec.of({**AROUND, "poses_per_voxel": 2})
    found = evaluate(arm("PRRYPY"), with_ik(spec, "irteus"), engine="reference", configurations=True)
    other = evaluate(arm("PRRYPY"), spec, engine="reference")
    assert found.reach == pytest.approx(other.reach, rel=0.15) and found.reach > 5
    assert found.configurations is not None
    model, rotation = ReferenceModel(CHAIN), np.empty((3, 3))
    held = found.configurations
    for voxel, pose, q in zip(held.voxel, held.pose, held.q, strict=True):
        target_rotation(spec.seed, voxel, pose, rotation)
        tip = model.tip(q)
        assert np.linalg.norm(tip.translation - spec.voxel_centres()[voxel]) <= 1e-3
        assert np.linalg.norm(pin.log3(tip.rotation.T @ rotation)) <= np.radians(1.0) + 1e-9
        assert model.clearance(q) > 0
    q = np.ones(6)
    irteus.start(CHAIN, 0, 0, 0, 0, q)
    assert not q.any()


def test_a_step_is_the_weighted_least_norm_damped_near_singularities() -> None:
    """By the library's pseudo-inverse far from them; bounded at them; a joint of less weight moves less."""
    model, error = ReferenceModel(CHAIN), np.array([0.01, -0.02, 0.03, 0.1, 0.2, -0.1])
    for q in np.random.default_rng(0).uniform(-2, 2, (50, 6)):
        jac = model.jacobian(q)
        jac *= 10.0  # far from singularities
        assert irteus.step(jac, np.ones(6), error) == pytest.approx(np.linalg.pinv(jac) @ error, rel=1e-4, abs=1e-6)
    jac = np.hstack([np.eye(6), np.eye(6)])  # two joints for each way
    weight = np.repeat([1.0, 0.25], 6)
    assert irteus.step(jac, weight, error) == pytest.approx(np.concatenate([0.8 * error, 0.2 * error]))
    at_zero = irteus.step(model.jacobian(np.zeros(6)), np.ones(6), error)
    assert np.isfinite(at_zero).all() and np.abs(at_zero).max() < 20


def test_only_the_reference_engine_has_it() -> None:
    """The kernel says so, and a study that names the kernel does before it starts."""
    spec = with_ik(load_spec("mobo"), "irteus")
    assert (spec.restarts, spec.iterations, spec.rules) == (5, 49, 1)
    with pytest.raises(UnableError, match=r"kernel: ik_mode 'irteus'; expected .* engine 'reference'"):
        evaluate(arm("PRRYPY"), spec)
    settings = StudySettings(spec=spec)
    with pytest.raises(InputError, match="ik_mode 'irteus', which engine kernel lacks; expected engine:=reference"):
        StudyOptions.of({"engine": "kernel"}).check(settings)
    StudyOptions.of({"engine": "reference"}).check(settings)
