"""The atlas: the front of every joint order, how far it has come, and what it answers."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow
import pyarrow.parquet
import pytest
from studies import mobo, mobo_json, run_study

from mobo_core.atlas.ask import Wish, answer
from mobo_core.atlas.atlas import Atlas, atlas_of, partial
from mobo_core.atlas.file import read_atlas, write_atlas
from mobo_core.atlas.growth import expected_gain, volumes_added
from mobo_core.atlas.reading import read_trials
from mobo_core.bag.collector import read_study
from mobo_core.design import DesignSpace, to_urdf
from mobo_core.errors import InputError
from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.report.row import Row
from mobo_core.report.table import study_table
from mobo_core.search.front import Aim, hypervolume
from mobo_core.search.mirror import exact_twins

SPACE = {"n_joints": 3, "joint_types": "RP", "max_length": 0.3}
SETTINGS: dict[str, Any] = {"sampler": "random", "space": DesignSpace.of(SPACE), "n_startup_trials": 1}
AIMS = (Aim(True, 75.0), Aim(False, 750.0))


@pytest.fixture(scope="module")
def bags(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("atlas")
    return [
        run_study(folder / f"seed{seed}", 60, name=f"seed{seed}", settings=SETTINGS | {"seed": seed}, rejected={3, 7})
        for seed in (0, 1)
    ]


@pytest.fixture(scope="module")
def atlas(bags: list[Path]) -> Atlas:
    sources, trials = read_trials(bags)
    return atlas_of(trials, sources)


def _rows(bags: list[Path]) -> list[tuple[str, Row]]:
    return [(bag.name, row) for bag in bags for row in study_table(read_study(bag)).rows]


def _dominates(a: Row, b: Row) -> bool:
    return a.reach >= b.reach and a.torque <= b.torque and (a.reach, a.torque) != (b.reach, b.torque)


def test_every_front_is_what_brute_force_finds_in_the_bags(bags: list[Path], atlas: Atlas) -> None:
    rows = _rows(bags)
    expected = {
        (study, row.trial, row.joints, row.lengths, row.reach, row.torque)
        for study, row in rows
        if row.complete and not any(_dominates(b, row) for _, b in rows if b.complete and b.joints == row.joints)
    }
    found = {
        (study, trial, joints, tuple(lengths), reach, torque)
        for study, trial, joints, lengths, reach, torque in zip(
            atlas.study, atlas.trial.tolist(), atlas.joints, atlas.lengths.tolist(),
            atlas.values["reach"].tolist(), atlas.values["torque"].tolist(), strict=True,
        )
    }  # fmt: skip
    assert found == expected and len(atlas) == len(expected)


def test_trials_of_an_order_count_failed_ones_and_add_up(bags: list[Path], atlas: Atlas) -> None:
    counts = {joints: int(atlas.trials_of_order[rows[0]]) for joints, rows in atlas.orders.items()}
    rows = _rows(bags)
    assert counts == {joints: sum(row.joints == joints for _, row in rows) for joints in counts}
    assert sum(counts.values()) == atlas.about.trials == 120
    assert "8 of 8 orders" in partial(atlas)


def test_metadata_tells_the_question_and_the_hypervolume(bags: list[Path], atlas: Atlas) -> None:
    values = [(row.reach, row.torque) for _, row in _rows(bags) if row.complete]
    assert atlas.about.hypervolume == hypervolume(values, AIMS)
    assert atlas.spec == EvaluationSpec() and atlas.space == SETTINGS["space"]
    assert [(one["name"], one["trials"]) for one in atlas.about.studies] == [("seed0", 60), ("seed1", 60)]
    assert atlas.about.versions["mobo"]


def test_a_file_gives_the_atlas_back_to_the_bit(atlas: Atlas, tmp_path: Path) -> None:
    write_atlas(tmp_path / "a.parquet", atlas)
    back = read_atlas(tmp_path / "a.parquet")
    assert back.about.__dict__ | {"studies": None} == atlas.about.__dict__ | {"studies": None}
    for name in ("joints", "twin", "study"):
        assert getattr(back, name) == getattr(atlas, name)
    for name in ("lengths", "base", "trials_of_order", "expected_gain", "trial"):
        assert np.array_equal(getattr(back, name), getattr(atlas, name))
    assert all(np.array_equal(back.values[name], atlas.values[name]) for name in atlas.values)


def test_bags_that_ask_something_else_are_refused(bags: list[Path], tmp_path: Path) -> None:
    other = run_study(tmp_path / "other", 3, settings=SETTINGS | {"spec": EvaluationSpec(seed=1)})
    with pytest.raises(InputError, match=r"spec\.seed is 1; expected 0, as in"):
        read_trials([bags[0], other])
    same_arms = {"space": SETTINGS["space"].model_copy(update={"lengths": "sequential"}), "in_flight": 1}
    drawn_otherwise = run_study(tmp_path / "sequential", 3, settings=SETTINGS | same_arms)
    assert len(read_trials([bags[0], drawn_otherwise])[1]) == 63


def test_twins_are_exact_only_where_the_mirror_changes_nothing(atlas: Atlas) -> None:
    twins = dict(zip(atlas.joints, atlas.twin, strict=True))
    assert twins["RPP"] == "PRR" and twins["PRR"] == "RPP"
    space, spec = atlas.space, atlas.spec
    leaning = space.model_copy(update={"base_tilt": 0.1})
    wide = spec.model_copy(update={"workspace_max": (0.7, 0.5, 0.5)})
    fallen = spec.model_copy(update={"gravity": (9.81, 0.0, 0.0)})
    assert exact_twins(twins, space, spec) == twins
    for other, asked in ((leaning, spec), (space, wide), (space, fallen)):
        assert exact_twins(twins, other, asked) == {}


@pytest.mark.parametrize("m", [2, 3])
def test_what_each_arm_adds_is_how_the_hypervolume_grows(m: int) -> None:
    chance = np.random.default_rng(m)
    aims = (*AIMS, Aim(False, 6.0))[:m]
    values = chance.random((60, m)) * [75.0, 900.0, 7.0][:m]
    values[chance.random((60, m)) < 0.1] = 0.0
    values[30:40] = values[20:30].round(-1)  # ties
    values[[5, 17]] = np.nan
    added = volumes_added(values, aims)
    for n in range(1, 61):
        whole = hypervolume([row for row in values[:n].tolist() if not math.isnan(sum(row))], aims)
        assert added[:n].sum() == pytest.approx(whole, abs=1e-12)


@pytest.mark.parametrize("b", [1.2, 1.5, 2.0])
def test_gains_that_fall_off_as_a_power_are_carried_on(b: float) -> None:
    added = 0.1 * np.arange(1.0, 2001.0) ** -b
    assert expected_gain(added[:1000]) == pytest.approx(added[1000:].sum(), rel=0.01)


def test_the_expected_gain_is_about_right_on_average_and_larger_for_who_has_more_to_gain() -> None:
    """Histories of 100 trials whose gains come in lumps, seldom or often, small or large; then 100 trials more."""
    chance = np.random.default_rng(0)
    expected, came = [], []
    for _ in range(400):
        t = np.arange(1.0, 201.0)
        size, often = 10.0 ** chance.uniform(-3, -1), chance.uniform(2, 6)
        added = (chance.random(200) < np.minimum(1, often / t)) * chance.exponential(size, 200) * t**-0.5
        expected.append(expected_gain(added[:100]))
        came.append(added[100:].sum())
    assert 0.7 < np.mean(expected) / np.mean(came) < 1.4
    ranks = [np.argsort(np.argsort(values)) for values in (expected, came)]
    assert np.corrcoef(ranks)[0, 1] > 0.6


def test_an_order_of_one_trial_may_gain_and_one_that_never_gained_is_at_its_end() -> None:
    assert 0.0 < expected_gain(np.array([0.2])) < 0.2
    assert expected_gain(np.zeros(10)) == 0.0
    early = np.array([0.2] + 999 * [0.0])
    assert 0.0 < expected_gain(early) < 1e-3


def test_a_wish_is_met_as_brute_force_says(atlas: Atlas) -> None:
    wish = Wish(without="P", reach_at_least=20.0, at_most={"torque": 600.0}, least="torque")
    values = list(zip(atlas.joints, atlas.values["reach"], atlas.values["torque"], strict=True))
    good = [i for i, (joints, reach, torque) in enumerate(values) if joints == "RRR" and reach >= 20 and torque <= 600]
    assert good and answer(atlas, wish).tolist() == sorted(good, key=lambda i: values[i][2])
    everything = answer(atlas, Wish(reach_at_least=0.0)).tolist()
    assert everything == sorted(range(len(atlas)), key=lambda i: (-values[i][1], values[i][2]))
    own = answer(atlas, Wish(orders=["RPP", "PRR"], near=atlas.lengths[3].tolist(), reach_at_least=0.0)).tolist()
    assert {atlas.joints[i] for i in own} == {"RPP", "PRR"}
    far = np.linalg.norm(atlas.lengths[own] - atlas.lengths[3], axis=1)
    assert (np.diff(far) >= 0).all()
    assert not len(answer(atlas, Wish(reach_at_least=76.0)))


@pytest.mark.parametrize(
    ("wish", "why"),
    [
        (Wish(least="mass"), "'mass'; expected reach or torque"),
        (Wish(orders=["RRP", "YPY"]), "no arm of 'YPY'; expected one of the atlas's 8 orders, such as"),
        (Wish(near=(0.1, 0.2)), "2 lengths; expected 3"),
    ],
)
def test_wishes_that_no_atlas_can_meet_are_refused(atlas: Atlas, wish: Wish, why: str) -> None:
    with pytest.raises(InputError, match=why):
        answer(atlas, wish)


def test_the_commands(bags: list[Path], atlas: Atlas, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "a.parquet"
    assert mobo("atlas", *bags, "-o", file) == 0
    assert "8 orders" in capsys.readouterr().out and len(read_atlas(file)) == len(atlas)
    found = mobo_json(capsys, "atlas", "ask", file, "--order", "rpp", "--top", 2, "--json", "-o", tmp_path / "arms")
    assert found["atlas"]["trials"] == 120
    assert [arm["joints"] for arm in found["arms"]] == ["RPP", "RPP"]
    best = answer(atlas, Wish(orders=["RPP"]))[0]
    assert found["arms"][0]["lengths"] == atlas.lengths[best].tolist()
    urdfs = sorted((tmp_path / "arms").iterdir())
    assert [urdf.name for urdf in urdfs] == ["1_RPP.urdf", "2_RPP.urdf"]
    study = read_study(next(bag for bag in bags if bag.name == atlas.study[best]))
    sent = study.candidate_of(int(atlas.trial[best]))
    assert sent is not None and urdfs[0].read_text() == sent.urdf == to_urdf(atlas.design(int(best)), atlas.space)
    assert mobo("atlas", "ask", file, "--reach-at-least", "76") == 1
    capsys.readouterr()
    for arguments, why in (
        (["ask", file, "--max", "torque"], "--max: 'torque'; expected a name and a number"),
        (["ask", file, "--near", "0.1,nan,0.2"], "--near: '0.1,nan,0.2'; expected finite numbers"),
        (["ask", file, "--top", "0"], "--top: 0; expected 1 or more"),
        (["ask", bags[0] / "metadata.yaml"], "not readable"),
        ([bags[0], "-o", "a.csv"], "suffix '.csv'; expected a file name ending in .parquet"),
        ([bags[0], "-o", file, "--order", "RPP"], "--order; expected mobo atlas ask"),
        ([bags[0]], "no -o"),
    ):
        assert mobo("atlas", *arguments) == 2
        error = capsys.readouterr().err
        assert why in error and error.count("\n") == 1


def _changed(file: Path, to: Path, **columns: list[Any]) -> Path:
    table = pyarrow.parquet.read_table(file)
    for name, values in columns.items():
        at = table.column_names.index(name)
        kind = pyarrow.array(values).type if values and not isinstance(values[0], float) else pyarrow.float64()
        table = table.set_column(at, name, pyarrow.array(values, kind))
    pyarrow.parquet.write_table(table, to)
    return to


def test_a_file_from_anywhere_is_not_believed(atlas: Atlas, tmp_path: Path) -> None:
    good, bad, n = tmp_path / "good.parquet", tmp_path / "bad.parquet", len(atlas)
    write_atlas(good, atlas)

    def refused(why: str, **columns: list[Any]) -> None:
        with pytest.raises(InputError, match=why):
            read_atlas(_changed(good, bad, **columns) if columns else bad)

    refused("not finite", reach=[math.nan] * n)
    refused("not finite", torque=[math.inf] * n)
    refused("length_2 holds a negative", length_2=[-1.0] * n)
    refused("joints 'R", joints=["R\x1b[2J"] * n)
    refused("joints 'RP'", joints=["RP"] * n)
    refused("very long name", study=["x" * 1000] * n)
    refused("value is missing", expected_gain=[1.0] * (n - 1) + [None])
    refused("column 'trial' is string; expected int64", trial=["1"] * n)
    bad.write_bytes(good.read_bytes()[:-100])
    refused("not readable")
    bad.write_text("PAR1")
    refused("not readable")
    pyarrow.parquet.write_table(pyarrow.table({"reach": [1.0]}), bad)
    refused("no atlas; expected a file that `mobo atlas` wrote")


@pytest.mark.parametrize(
    "change", [{"format": 2}, {"objectives": ["reach"]}, {"n_voxels": -1}, {"spec": 3}, {"more": 1}, {"trials": "x"}]
)
def test_metadata_that_cannot_be_is_refused(atlas: Atlas, tmp_path: Path, change: dict[str, Any]) -> None:
    file = tmp_path / "a.parquet"
    write_atlas(file, atlas)
    table = pyarrow.parquet.read_table(file)
    about = json.loads(table.schema.metadata[b"mobo_atlas"]) | change
    pyarrow.parquet.write_table(table.replace_schema_metadata({b"mobo_atlas": json.dumps(about)}), file)
    with pytest.raises(InputError, match="metadata not readable"):
        read_atlas(file)
