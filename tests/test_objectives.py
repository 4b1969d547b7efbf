"""Objectives beyond reach and torque: their values, their bits, and those of other distributions."""

from __future__ import annotations

import pytest

from mobo_core.errors import InputError
from mobo_core.evaluation import EvaluationSpec
from mobo_core.evaluation.objectives import OBJECTIVES

PAPER = EvaluationSpec()


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
