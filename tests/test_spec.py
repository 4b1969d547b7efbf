"""The evaluation's question."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mobo_core.errors import InputError
from mobo_core.evaluation import PRESETS, EvaluationSpec, load_spec


def refusal(values: Any) -> str:
    """Return the error on these values, after checking that it is one line and means exit code 2."""
    with pytest.raises(InputError) as error:
        EvaluationSpec.of(values, where="spec")
    assert error.value.exit_code == 2
    text = str(error.value)
    assert text == " ".join(text.split())
    assert text.startswith("spec: ")
    assert "; expected " in text
    return text


def test_presets() -> None:
    """The paper's grid has 5 x 5 x 3 = 75 voxels, its fine one 10 x 10 x 6 = 600, and all else is the same."""
    paper, fine = load_spec("paper"), load_spec("paper_fine")
    assert set(PRESETS) == {"paper", "paper_fine", "mobo"}
    assert (paper.shape, paper.n_voxels) == ((5, 5, 3), 75)
    assert (fine.shape, fine.n_voxels) == ((10, 10, 6), 600)
    assert paper == EvaluationSpec()
    assert fine == EvaluationSpec(voxel_size=0.1)


def test_defaults_are_the_papers_experiment() -> None:
    """By default 30 poses a voxel, 1 mm, 1 degree, six attempts of 50 steps, collisions on, no payload."""
    spec = EvaluationSpec()
    assert (spec.poses_per_voxel, spec.restarts, spec.iterations) == (30, 5, 50)
    assert (spec.position_tolerance, spec.rotation_tolerance) == (1e-3, math.pi / 180)
    assert (spec.self_collision, spec.gravity, spec.payload_kg) == (True, (0, 0, -9.81), 0)
    assert (spec.solution, spec.ik_mode, spec.orientation, spec.seed) == ("first", "paper", "full", 0)


def test_centres_of_the_papers_voxels() -> None:
    """Centres ascend in each axis, z fastest; 4 of the 75 lie beyond 0.6 m and 12 at 0.6 m."""
    centres = EvaluationSpec().voxel_centres()
    assert centres.shape == (75, 3)
    assert centres[0] == pytest.approx([-0.4, -0.4, 0.0])
    assert centres[1] == pytest.approx([-0.4, -0.4, 0.2])
    assert centres[3] == pytest.approx([-0.4, -0.2, 0.0])
    assert centres[15] == pytest.approx([-0.2, -0.4, 0.0])
    assert centres[74] == pytest.approx([0.4, 0.4, 0.4])
    distance = np.linalg.norm(centres, axis=1)
    assert np.count_nonzero(distance > 0.6 + 1e-9) == 4
    assert np.count_nonzero(np.abs(distance - 0.6) < 1e-9) == 12


@given(
    st.tuples(*[st.integers(1, 6)] * 3),
    st.sampled_from([0.01, 0.05, 0.1, 0.2, 0.3, 1 / 3, 1.0, 7.0]),
    st.tuples(*[st.integers(-30, 30)] * 3),
)
def test_voxel_index(shape: tuple[int, int, int], size: float, corner: tuple[int, int, int]) -> None:
    """Voxel (ix, iy, iz) is number (ix ny + iy) nz + iz, its centre half a voxel inside the corner."""
    low = tuple(c * 0.1 for c in corner)
    high = tuple(a + n * size for a, n in zip(low, shape, strict=True))
    spec = EvaluationSpec(workspace_min=low, workspace_max=high, voxel_size=size)
    assert spec.shape == shape
    centres = spec.voxel_centres()
    assert len(centres) == spec.n_voxels == math.prod(shape)
    for ix in range(shape[0]):
        for iy in range(shape[1]):
            for iz in range(shape[2]):
                expected = [low[0] + (ix + 0.5) * size, low[1] + (iy + 0.5) * size, low[2] + (iz + 0.5) * size]
                assert centres[(ix * shape[1] + iy) * shape[2] + iz] == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"workspace_max": (-0.5, 0.5, 0.5)}, ("at least one voxel", "(0, 5, 3)")),
        ({"workspace_max": (-1.5, 0.5, 0.5)}, ("at least one voxel",)),
        ({"voxel_size": 3.0}, ("at least one voxel", "(0, 0, 0)")),
        ({"voxel_size": 0.001}, ("at most 1000000 voxels", "600000000")),
        ({"voxel_size": 1e-300}, ("at most 1000000 voxels",)),
        ({"workspace_max": (1e300, 0.5, 0.5)}, ("at most 1000000 voxels",)),
        ({"workspace_min": (-1e308,) * 3, "workspace_max": (1e308,) * 3}, ("at most 1000000 voxels",)),
        ({"voxel_size": 0.01, "poses_per_voxel": 100}, ("at most 50000000 poses", "60000000")),
        ({"voxel_size": 0.15}, ("whole numbers of voxels of 0.15 m",)),
        ({"workspace_max": (1001.5, 0.5, 0.5), "workspace_min": (999.5, -0.5, -0.1)}, ("within 1 km",)),
        ({"workspace_min": (1e9, 0, 0), "workspace_max": (1e9 + 1, 1, 1)}, ("within 1 km",)),
        ({"voxel_size": 0}, ("voxel_size = 0", "greater than 0")),
        ({"voxel_size": -0.2}, ("voxel_size = -0.2", "greater than 0")),
        ({"voxel_size": math.nan}, ("voxel_size = nan", "finite")),
        ({"voxel_size": math.inf}, ("voxel_size = inf", "finite")),
        ({"voxel_size": 10**400}, ("voxel_size = 1000",)),
        ({"voxel_size": None}, ("voxel_size = None", "number")),
        ({"voxel_size": "wide"}, ("voxel_size = 'wide'", "number")),
        ({"workspace_min": (0, 0)}, ("workspace_min",)),
        ({"workspace_min": (0, 0, 0, 0)}, ("workspace_min",)),
        ({"workspace_min": 0}, ("workspace_min = 0",)),
        ({"workspace_min": (math.nan, 0, 0)}, ("workspace_min.0 = nan", "finite")),
        ({"gravity": (0, -math.inf, 0)}, ("gravity.1 = -inf", "finite")),
        ({"gravity": "down"}, ("gravity = 'down'",)),
        ({"poses_per_voxel": 0}, ("poses_per_voxel = 0", "1")),
        ({"poses_per_voxel": 65536}, ("poses_per_voxel = 65536", "65535")),
        ({"poses_per_voxel": 1.5}, ("poses_per_voxel = 1.5", "integer")),
        ({"restarts": -1}, ("restarts = -1", "0")),
        ({"restarts": 10**9}, ("restarts = 1000000000", "1000")),
        ({"iterations": 0}, ("iterations = 0", "1")),
        ({"iterations": 10**9}, ("iterations = 1000000000", "10000")),
        ({"position_tolerance": 0}, ("position_tolerance = 0",)),
        ({"rotation_tolerance": 4}, ("rotation_tolerance = 4", "3.14")),
        ({"payload_kg": -1}, ("payload_kg = -1", "0")),
        ({"seed": -1}, ("seed = -1", "0")),
        ({"target_poses": [[0, 0, 0, 0, 0]]}, ("target_poses.0",)),
        ({"target_poses": [[0, 0, 0, 0, 0, 2e3]]}, ("target_poses of 1000 at most",)),
        ({"target_poses": [[0] * 6], "poses_per_voxel": 30}, ("poses_per_voxel of 1", "30")),
        ({"target_poses": [[0] * 6] * 1001}, ("target_poses = ", "1000")),
        ({"floor_z": "low"}, ("floor_z = 'low'", "number")),
        ({"obstacles": [{"centre": (0, 0, 0)}]}, ("obstacles.0.size", "required")),
        ({"obstacles": [{"centre": (0, 0, 0), "size": (1, 0, 1)}]}, ("obstacles.0", "sides above 0")),
        ({"obstacles": [{"centre": [0] * 3, "size": [1] * 3, "colour": 1}]}, ("colour", "one of centre, rpy, size")),
        ({"obstacles": 1}, ("obstacles = 1",)),
        ({"tool_xyz": (0, 0, 1e4)}, ("tool_xyz of 1000 at most",)),
        ({"tool_rpy": (0, math.nan, 0)}, ("tool_rpy.1 = nan", "finite")),
        ({"payload_com": (0, 0)}, ("payload_com",)),
        ({"seed": 2**63}, (f"seed = {2**63}",)),
        ({"self_collision": "perhaps"}, ("self_collision = 'perhaps'", "boolean")),
        ({"ik_mode": "magic"}, ("ik_mode = 'magic'", "'paper'")),
        ({"orientation": "some"}, ("orientation = 'some'", "'full'", "'free_roll'", "'none'")),
        ({"solution": "best"}, ("solution = 'best'", "'first'", "'least_torque'")),
        ({"poses": 30}, ("unknown field 'poses'", "poses_per_voxel")),
        ({1: 2}, ("unknown field '1'",)),
        ({"voxel_size": "x" * 100_000}, ("voxel_size = 'xxx", "...")),
        ([0.2], ("[0.2]", "a mapping")),
        (None, ("None", "a mapping")),
        ("paper", ("'paper'", "a mapping")),
    ],
)
def test_bad_specs(values: Any, words: tuple[str, ...]) -> None:
    """A spec that makes no sense is refused in one line with field, value and what was expected."""
    text = refusal(values)
    assert len(text) < 500
    for word in words:
        assert word in text


@given(
    st.fixed_dictionaries(
        {},
        optional={
            name: st.one_of(
                st.none(),
                st.booleans(),
                st.integers(),
                st.floats(),
                st.text(max_size=20),
                st.lists(st.floats(), max_size=4),
                st.dictionaries(st.text(max_size=3), st.integers(), max_size=2),
            )
            for name in EvaluationSpec.model_fields
        },
    )
)
def test_any_values_make_a_spec_or_an_input_error(values: dict[str, Any]) -> None:
    """Whatever the fields hold, the answer is a spec whose voxels can be listed, or a one-line error."""
    try:
        spec = EvaluationSpec.of(values)
    except InputError as error:
        assert "\n" not in str(error)
        return
    assert 1 <= spec.n_voxels <= 1_000_000
    assert np.all(np.isfinite(spec.voxel_centres()))


def test_unknown_preset() -> None:
    """A name that is neither preset nor file is refused, and the presets are named."""
    with pytest.raises(InputError) as error:
        load_spec("papre")
    assert str(error.value) == "spec: no preset or file 'papre'; expected paper, paper_fine, mobo or a YAML file"


def test_spec_file(tmp_path: Path) -> None:
    """A YAML file gives a spec; what it leaves out keeps its default, and faults name the file."""
    path = tmp_path / "spec.yaml"
    path.write_text("voxel_size: 0.1\ngravity: [0, 0, -1.62]\nself_collision: false\n")
    spec = load_spec(str(path))
    assert spec == EvaluationSpec(voxel_size=0.1, gravity=(0, 0, -1.62), self_collision=False)
    path.write_text(json.dumps(spec.to_dict()))
    assert load_spec(str(path)) == spec
    path.write_text("voxel_size: -1\n")
    with pytest.raises(InputError, match=r"spec\.yaml: voxel_size = -1; expected greater than 0"):
        load_spec(str(path))
    with pytest.raises(InputError, match="no preset or file"):
        load_spec(str(tmp_path))


def test_canonical_text() -> None:
    """Equal specs have equal JSON text, from which the same spec comes back; specs cannot be changed."""
    spec = EvaluationSpec(voxel_size=1, workspace_max=(1.5, 0.5, 0.9), seed=7)
    same = EvaluationSpec(seed=7, workspace_max=(1.5, 0.5, 0.9), voxel_size=1.0)
    assert spec.to_json() == same.to_json()
    assert spec.to_json() != EvaluationSpec().to_json()
    assert EvaluationSpec.of(json.loads(spec.to_json())) == spec
    with pytest.raises(ValueError, match="frozen"):
        spec.seed = 1  # type: ignore[misc]
