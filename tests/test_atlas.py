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
from mobo_core.atlas.atlas import Atlas, atlas_of, fronts_of, partial
from mobo_core.atlas.file import packaged, read_atlas, write_atlas
from mobo_core.atlas.growth import expected_gain, volumes_added
from mobo_core.atlas.reading import read_trials
from mobo_core.atlas.regret import fitting_atlas, regret, unfit, voxels_within
from mobo_core.atlas.trials import Rows
from mobo_core.bag.collector import read_study
from mobo_core.design import DesignSpace, to_urdf
from mobo_core.errors import InputError
from mobo_core.evaluation.spec import EvaluationSpec, load_spec
from mobo_core.report.own_atlas import own_atlas
from mobo_core.report.row import Row
from mobo_core.report.table import study_table
from mobo_core.search.front import Aim, hypervolume, pareto_front
from mobo_core.search.mirror import exact_twins
from mobo_core.search.study import StudySettings

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


def test_no_trial_makes_an_atlas_of_no_arm(atlas: Atlas, bags: list[Path], tmp_path: Path) -> None:
    settings = read_trials(bags[:1])[0][0].settings
    none = fronts_of(Rows(("reach", "torque"), 3).trials(), settings, [{"name": "none"}])
    assert len(none) == none.about.orders == none.about.hypervolume == 0 and partial(none) == ""
    write_atlas(tmp_path / "none.parquet", none)
    back = read_atlas(tmp_path / "none.parquet")
    assert not len(back) and not len(answer(back, Wish()))
    assert regret(none, atlas).hypervolume == 0.0


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
    assert mobo("atlas", bags[0], "-o", tmp_path / "one.parquet", "--searched") == 1
    capsys.readouterr()
    for arguments, why in (
        (["ask", file, "--max", "torque"], "--max: 'torque'; expected a name and a number"),
        (["ask", file, "--near", "0.1,nan,0.2"], "--near: '0.1,nan,0.2'; expected finite numbers"),
        (["ask", file, "--top", "0"], "--top: 0; expected 1 or more"),
        (["ask", bags[0] / "metadata.yaml"], "not readable"),
        ([bags[0], "-o", "a.csv"], "suffix '.csv'; expected a file name ending in .parquet"),
        ([bags[0], "-o", file, "--order", "RPP"], "--order; expected mobo atlas ask"),
        ([bags[0]], "no -o"),
        (["ask", file, "--searched"], "--searched; expected mobo atlas BAG… -o"),
    ):
        assert mobo("atlas", *arguments) == 2
        error = capsys.readouterr().err
        assert why in error and error.count("\n") == 1


def test_a_study_is_at_no_distance_from_its_own_atlas_and_short_of_a_larger_one(
    bags: list[Path], atlas: Atlas
) -> None:
    study = read_study(bags[0])
    own = own_atlas(study, study_table(study))
    sources, trials = read_trials(bags[:1])
    streamed = atlas_of(trials, sources)
    assert own.joints == streamed.joints and np.array_equal(own.expected_gain, streamed.expected_gain)
    none = regret(own, streamed)
    assert none.hypervolume == none.of_hypervolume == streamed.about.hypervolume
    assert all(one.short == 0.0 and one.hypervolume == one.of_hypervolume for one in none.orders)
    assert str(none) == f"{none.hypervolume:.4f} of {none.hypervolume:.4f}"
    far = regret(own, atlas)
    assert far.of_hypervolume == atlas.about.hypervolume >= far.hypervolume
    rows = _rows(bags)
    for one in far.orders:
        best = {
            name: max(row.reach for study, row in rows if row.complete and row.joints == one.joints and study in name)
            for name in ("seed0", "seed0 seed1")
        }
        assert one.short == best["seed0 seed1"] - best["seed0"] >= 0.0
    worst = far.orders[0]
    assert worst.short > 0.0 and str(far).endswith(f"; {worst.joints} {worst.short:.1f} voxels short")
    back = regret(atlas, own)  # what is ahead of an atlas is not short of it
    assert back.hypervolume == back.of_hypervolume and not any(one.short for one in back.orders)


def test_values_of_other_questions_are_not_compared(bags: list[Path], atlas: Atlas, tmp_path: Path) -> None:
    settings = read_study(bags[0]).settings
    assert unfit(settings, "simulated", atlas) == ""
    sequential = settings.model_copy(update={"space": settings.space.model_copy(update={"lengths": "sequential"})})
    assert unfit(sequential, "", atlas) == ""
    other = settings.model_copy(update={"spec": EvaluationSpec(seed=3)})
    assert unfit(other, "", atlas) == "spec.seed is 3, in the atlas 0"
    assert unfit(settings, "kernel", atlas) == "engine is 'kernel', in the atlas 'simulated'"
    write_atlas(tmp_path / "a.parquet", atlas)
    assert fitting_atlas(other, "", tmp_path / "a.parquet")[0] is None
    assert fitting_atlas(settings)[1] == "mobo brings no atlas of 3 joints"


@pytest.mark.parametrize(("n_joints", "orders"), [(6, 239), (7, 577)])
def test_the_atlases_that_mobo_brings_are_such(n_joints: int, orders: int) -> None:
    path = packaged(n_joints)
    assert path is not None and path.stat().st_size < 3_000_000
    brought = read_atlas(path)
    settings = StudySettings(space=DesignSpace(n_joints=n_joints), spec=load_spec("mobo"))
    assert fitting_atlas(settings, "kernel")[0] is not None
    assert brought.about.orders == len(brought.orders) == orders
    wanted = brought.wanted
    for rows in brought.orders.values():
        values = [wanted[row] for row in rows]
        assert len(pareto_front(values, brought.aims)) == len(values)
    assert regret(brought, brought).orders[0].short == 0.0


def test_no_arm_reaches_voxels_beyond_its_length() -> None:
    spec = EvaluationSpec()
    assert voxels_within(DesignSpace(), spec) == 71
    assert voxels_within(DesignSpace.of({"total_length": 0.1}), spec) == 1
    assert voxels_within(DesignSpace.of({"base_height": (-0.1, 0.4)}), spec) == 75


def test_the_report_says_how_well_orders_are_known(
    bags: list[Path], atlas: Atlas, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    write_atlas(tmp_path / "a.parquet", atlas)
    # Joint torques of the front have their own tests; here they would compile a kernel for three joints.
    monkeypatch.setattr("mobo_core.report.joint_torques.chosen", lambda *_: [])
    assert mobo("report", bags[0], "-o", tmp_path / "r", "--atlas", tmp_path / "a.parquet") == 0
    said = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("atlas "))
    assert "voxels short, by 120 trials (partial: 8 of 8 orders" in said
    page = (tmp_path / "r" / "index.html").read_text()
    assert "How well each order is known" in page and "Against an atlas of 120 trials" in page
    lines = (tmp_path / "r" / "atlas_orders.csv").read_text().splitlines()
    assert len(lines) == 9 and lines[0].endswith("hypervolume,expected_gain,voxels_short,hypervolume_short")


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


def test_what_is_asked_of_the_atlases_that_mobo_brings(capsys: pytest.CaptureFixture[str]) -> None:
    """That of as many joints as the order or the lengths asked for, of six if there are neither."""
    for wish, n_joints in (((), 6), (("--order", "YPYPYPY"), 7), (("--near", "0,0.3,0,0,0.3,0,0"), 7)):
        arms = mobo_json(capsys, "atlas", "ask", *wish, "--top", 1, "--json")["arms"]
        assert [len(arm["joints"]) for arm in arms] == [n_joints]
