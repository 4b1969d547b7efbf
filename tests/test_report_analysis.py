"""What the report says of structures, lengths, noise, importance and time, against oracles; and exports."""

from __future__ import annotations

import json
import math
import random
from pathlib import Path

import numpy as np
import optuna
import pytest
from studies import QUICK, mobo, run_study

from mobo_core.bag.collector import read_study
from mobo_core.design import Design, DesignSpace, to_urdf
from mobo_core.evaluation.evaluate import evaluate
from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.report import structures
from mobo_core.report.importance import importances
from mobo_core.report.notebook import notebook
from mobo_core.report.optuna_trials import export_study
from mobo_core.report.positions import clusters, group_text, positions
from mobo_core.report.row import Row
from mobo_core.report.stages import stages
from mobo_core.report.table import StudyTable, study_table
from mobo_core.report.uncertainty import standard_errors, steadiness
from mobo_core.search.front import aims_of, hypervolume
from mobo_core.search.mirror import exact_twins

SAMPLE = Path(__file__).parents[1] / "bags" / "sample" / "paper_6"
AIMS = aims_of(("reach", "torque"), EvaluationSpec())


def row(trial: int, joints: str, reach: float, torque: float, lengths: tuple[float, ...] = (0.1,) * 6) -> Row:
    return Row(
        trial=trial, complete=True, joints=joints, sampled_joints=joints, lengths=lengths, reach=reach, torque=torque,
        on_front=False, above_floor=reach >= 7.5, known_as=(), attempt=1, evaluator="e", seconds=0.1, reason="",
        values=(reach, torque),
    )  # fmt: skip


def random_table(n: int, seed: int) -> StudyTable:
    chance = random.Random(seed)
    orders = ["".join(chance.choice("RP") for _ in range(6)) for _ in range(6)]
    rows = []
    for i in range(n):
        reach = chance.uniform(0, 60)
        rows.append(row(i, chance.choice(orders), reach, reach * chance.uniform(3, 12)))
    return StudyTable(tuple(rows), 6, 75, AIMS)


@pytest.mark.parametrize("seed", range(4))
def test_contribution_is_what_the_hypervolume_loses(seed: int) -> None:
    """Of each prefix and order, against the hypervolume of all other arms."""
    table = random_table(150, seed)
    marked = StudyTable(
        tuple(Row(**{**vars(r), "on_front": not any(
            (o.reach >= r.reach and o.torque < r.torque) or (o.reach > r.reach and o.torque <= r.torque)
            for o in table.rows)}) for r in table.rows), 6, 75, AIMS)  # fmt: skip
    whole = hypervolume([r.values for r in marked.rows], AIMS)
    for structure in structures.prefixes(marked):
        rest = hypervolume([r.values for r in marked.rows if r.joints[:4] != structure.name], AIMS)
        assert structure.contribution == pytest.approx(whole - rest, abs=1e-12)
        best = max(r.reach for r in structure.rows)
        assert structure.best.reach == best and structure.least_torque(best) == structure.best.torque
        assert structure.least_torque(best + 1) is None


def test_exact_twins_are_arms_of_equal_worth() -> None:
    """Their evaluations differ by no more than poses do; an order broken by the Yaw rule has no twin."""
    orders = ["PRRYPY", "RPPYPY", "PRPRPR", "RPRPRP", "PPRRPY", "RRPPRY"]
    twins = exact_twins(orders, DesignSpace(), EvaluationSpec())
    assert twins == {"PRPRPR": "RPRPRP", "RPRPRP": "PRPRPR", "PPRRPY": "RRPPRY", "RRPPRY": "PPRRPY"}
    assert exact_twins(orders, DesignSpace(base_tilt=0.1), EvaluationSpec()) == {}
    lopsided = EvaluationSpec(workspace_min=(-0.5, -0.3, -0.1))
    assert exact_twins(orders, DesignSpace(), lopsided) == {}
    lengths = (0.05, 0.25, 0.2, 0.05, 0.03, 0.02)
    for a, b in (("PPRRPY", "RRPPRY"),):
        spec = EvaluationSpec(poses_per_voxel=60)
        found = [evaluate(to_urdf(Design(joints, lengths), DesignSpace()), spec) for joints in (a, b)]
        assert found[0].reach == pytest.approx(found[1].reach, abs=1.5)
        assert found[0].mean_torque == pytest.approx(found[1].mean_torque, rel=0.05)


def test_joints_within_a_tenth_of_the_arm_are_together() -> None:
    """From base to tool."""
    assert group_text([0, 0.05, 0.5, 0.9, 0.95, 1.0]) == "2-1-3"
    assert group_text([0, 0.2, 0.4, 0.6, 0.8, 0.95]) == "1-1-1-1-1-1"
    assert group_text([0]) == "1"


def test_clusters_are_those_the_lengths_were_made_of() -> None:
    """Two kinds of proportions, mixed, come apart; arms of one kind stay one cluster."""
    chance = np.random.default_rng(0)

    def arms(centre: list[float], count: int, first: int) -> list[Row]:
        shares = np.abs(np.array(centre) + 0.01 * chance.standard_normal((count, 6)))
        made = 0.6 * shares / shares.sum(axis=1, keepdims=True)
        return [row(2 * i + first, "PRRYPY", 40.0, 300.0, tuple(lengths)) for i, lengths in enumerate(made.tolist())]

    two = arms([0.5, 0.5, 0, 0, 0, 0], 500, 0) + arms([0, 0.3, 0.3, 0.4, 0, 0], 500, 1)
    found = clusters(StudyTable(tuple(two), 6, 75, AIMS))
    assert len(found) == 2
    for cluster in found:
        assert len({r.trial % 2 for r in cluster.rows}) == 1
    assert len(clusters(StudyTable(tuple(arms([0.2, 0.2, 0.2, 0.2, 0.1, 0.1], 400, 0)), 6, 75, AIMS))) == 1


def test_standard_errors_are_the_spread_over_seeds_of_the_poses() -> None:
    """Of reach and torque, against evaluations of one arm with other poses, within what so few tell."""
    study = read_study(SAMPLE)
    best = study_table(study).front[0]
    reach_se, torque_se = standard_errors(study, [best])
    urdf, spec = study.candidate_of(best.trial).urdf, study.settings.spec  # type: ignore[union-attr]
    found = [evaluate(urdf, spec.model_copy(update={"seed": seed})) for seed in range(1, 17)]
    assert 0.55 < np.std([f.reach for f in found], ddof=1) / reach_se[0] < 1.7
    assert torque_se[0] > 0


def test_the_front_is_steadier_than_what_it_dominates() -> None:
    """Shares lie in 0 to 1, fall, and are those of arms that are on or near the front."""
    study = read_study(SAMPLE)
    table = study_table(study)
    found = steadiness(study, table)
    shares = [one.share for one in found]
    assert shares == sorted(shares, reverse=True) and min(shares) > 0 and max(shares) <= 1
    on = [one.share for one in found if one.row.on_front]
    off = [one.share for one in found if not one.row.on_front]
    assert np.mean(on) > np.mean(off or [0.0])
    assert {r.trial for r in table.useful_front} >= {one.row.trial for one in found if one.share > 0.9}


def test_stages_and_importances_of_a_bag() -> None:
    """The evaluation's time is the evaluators' own; importances are shares of one."""
    study = read_study(SAMPLE)
    table = study_table(study)
    found = stages(study)
    at_once = [r for r in table.complete if r.attempt == study.candidate_of(r.trial).attempt]  # type: ignore[union-attr]
    seconds = [study.accepted(r.trial).seconds for r in at_once]  # type: ignore[union-attr]
    assert found.trials["evaluate"] == len(at_once) < len(table.complete)
    assert found.median["evaluate"] == pytest.approx(float(np.median(seconds)))
    assert all(value >= 0 and math.isfinite(value) for value in found.median.values())
    of = importances(study, table)
    assert set(of) == {"reach", "torque"}
    for values in of.values():
        assert sum(values.values()) == pytest.approx(1.0) and list(values.values()) == sorted(values.values())[::-1]


def test_positions_are_of_the_best_arms() -> None:
    """The first joint is at the base, none is beyond the tool."""
    for of in positions(study_table(read_study(SAMPLE))):
        assert np.all(of.places[:, 0] == 0) and np.all(np.diff(of.places) >= 0) and np.all(of.places <= 1 + 1e-12)
        assert sum(count for _, count in of.groups) == len(of.rows)


def test_a_study_goes_to_optuna_and_comes_back(tmp_path: Path) -> None:
    """A journal holds every trial with its parameters and values, failed ones too; a second time it is refused."""
    bag, journal = run_study(tmp_path / "bag", 12, rejected={3}), tmp_path / "study.journal"
    assert mobo("export", "optuna", bag, "-o", journal) == 0
    storage = optuna.storages.JournalStorage(optuna.storages.journal.JournalFileBackend(str(journal)))
    loaded = optuna.load_study(study_name="study", storage=storage)
    study = read_study(bag)
    assert [direction.name for direction in loaded.directions] == ["MAXIMIZE", "MINIMIZE"]
    for trial in loaded.trials:
        told, candidate = study.trials[trial.number], study.candidate_of(trial.number)
        assert candidate is not None and trial.params == json.loads(candidate.params_json)
        assert trial.values == ([told.reach, told.torque] if trial.number != 3 else None)
    assert len(loaded.trials) == 12 and mobo("export", "optuna", bag, "-o", journal) == 2
    assert mobo("export", "optuna", bag, "-o", "nosuch://x") == 2
    name, count = export_study(study, f"sqlite:///{tmp_path / 'study.db'}")
    assert (name, count) == ("study", 12)


@pytest.mark.slow
def test_the_notebook_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All of its code, on a bag; a study's name is no Markdown in it."""
    monkeypatch.setenv("MPLBACKEND", "agg")
    assert mobo("export", "notebook", SAMPLE, "-o", tmp_path / "n.ipynb") == 0
    cells = json.loads((tmp_path / "n.ipynb").read_text(encoding="utf-8"))["cells"]
    scope: dict[str, object] = {}
    for cell in cells:
        if cell["cell_type"] == "code":
            exec("".join(cell["source"]), scope)
    assert len(scope["table"].rows) == 60  # type: ignore[attr-defined]
    title = json.loads(notebook("![x](http://y) `<b>", "bag"))["cells"][0]["source"][0]
    assert title == "# `![x](http://y) '<b>`\n"


@pytest.mark.slow
@pytest.mark.parametrize("settings", [QUICK | {"objectives": "reach,torque,mass"}])
def test_three_objectives_are_reported(settings: dict[str, object], tmp_path: Path) -> None:
    """With every picture and table."""
    bag = run_study(tmp_path / "bag", 8, settings=settings)
    assert mobo("report", bag, "-o", tmp_path / "out") == 0
    for name in ("sampling.png", "structures.svg", "prefixes.csv", "orders.csv", "lengths.csv", "space.yaml"):
        assert (tmp_path / "out" / name).is_file()
