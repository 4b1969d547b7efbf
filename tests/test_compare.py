"""Studies side by side: what attained means, what differs, what must not be compared."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from studies import QUICK, mobo, mobo_json, run_study

from mobo_core.bag.collector import read_study
from mobo_core.report.compare.comparison import Comparison, labels_of
from mobo_core.report.compare.figures.fronts import attained
from mobo_core.report.compare.summary import summary_of

SAMPLES = Path(__file__).parents[1] / "bags" / "sample"
Bags = list[Path]


@pytest.fixture(scope="module")
def bags(tmp_path_factory: pytest.TempPathFactory) -> Bags:
    """Two seeds of one study, one of other limits, and one of another question, of invented values."""
    folder = tmp_path_factory.mktemp("compare")
    others: dict[str, dict[str, object]] = {
        "<b>zero": {},
        "one": {"seed": 1},
        "wide": {"space": {"joint_limit": 4.0}},
        "fine": {"spec": {"poses_per_voxel": 7}},
    }
    return [run_study(folder / name, 6, settings=QUICK | other) for name, other in others.items()]


def front(chance: random.Random) -> list[tuple[float, float]]:
    points = sorted((chance.randint(1, 30), chance.randint(1, 200)) for _ in range(12))
    return [(r, t) for r, t in points if not any(a >= r and b <= t and (a, b) != (r, t) for a, b in points)]


@pytest.mark.parametrize("seed", range(10))
def test_attained_is_what_so_many_fronts_dominate(seed: int) -> None:
    """Counted point by point over a grid."""
    chance = random.Random(seed)
    fronts = [front(chance) for _ in range(chance.randint(1, 5))]
    for share, needed in ((0.0, 1), (0.5, len(fronts) // 2 + 1), (1.0, len(fronts))):
        bound = attained(fronts, share)
        assert bound == sorted(bound) and [t for _, t in bound] == sorted(t for _, t in bound)
        for reach in range(1, 31):
            for torque in range(1, 201, 7):
                count = sum(any(r >= reach and t <= torque for r, t in points) for points in fronts)
                assert (count >= needed) == any(r >= reach and t <= torque for r, t in bound)


def test_what_differs_and_what_belongs_together(bags: Bags, capsys: pytest.CaptureFixture[str]) -> None:
    """Seeds make a group with an interval; other settings are listed; another spec is warned of."""
    found = mobo_json(capsys, "compare", *bags[:3], "--json")
    assert found["comparable"] is True and not any("must not" in line for line in found["warnings"])
    assert found["differ"] == {"space.joint_limit": [0.75 * 3.141592653589793] * 2 + [4.0], "seed": [0, 1, 0]}
    assert [group["studies"] for group in found["groups"]] == [["<b>zero", "one"], ["wide"]]
    values = [one["hypervolume"] for one in found["studies"]]
    low, high = found["groups"][0]["interval"]
    assert found["groups"][0]["hypervolume"] == pytest.approx(sum(values[:2]) / 2)
    assert low < sum(values[:2]) / 2 < high
    assert found["groups"][1]["interval"] is None
    for one in found["studies"]:
        assert one["interval"][0] <= one["hypervolume"] <= one["interval"][1]
        assert one["hypervolume_at_least_trials"] == one["hypervolume"] and one["least_trials"] == 6
    assert mobo("compare", *bags) == 0
    told = capsys.readouterr()
    assert "values must not be compared: spec.poses_per_voxel differs" in told.err and "invented" in told.err
    assert "fine" in told.out and "spec.poses_per_voxel" in told.out


def test_the_page_shows_all_and_runs_nothing(bags: Bags, tmp_path: Path) -> None:
    """Pictures, tables, warnings; names stay text."""
    assert mobo("compare", *bags, "-o", tmp_path / "a") == 0
    written = {file.name for file in (tmp_path / "a").iterdir()}
    pictures = {f"{name}.{kind}" for name in ("fronts", "progress", "structures") for kind in ("png", "svg")}
    assert written == pictures | {"index.html", "studies.csv", "differences.csv", "prefixes.csv"}
    page = (tmp_path / "a" / "index.html").read_text(encoding="utf-8")
    assert "&lt;b&gt;zero" in page and "<b>zero" not in page and "must not be compared" in page
    assert page.count("<figure>") == 3 and "default-src 'none'" in page


def test_a_study_and_itself_do_not_differ() -> None:
    """Under two names."""
    study = read_study(SAMPLES / "paper_6")
    comparison = Comparison(tuple(summary_of(study, label) for label in labels_of(["s", "s"])))
    assert [one.label for one in comparison.studies] == ["s", "s (2)"]
    assert comparison.differing == {} and len(comparison.groups) == 1
    mean, interval = comparison.groups[0].volume
    assert interval == (mean, mean) == (comparison.studies[0].volume,) * 2
    assert comparison.studies[0].volume == pytest.approx(comparison.studies[0].table.hypervolume(10**6))
    assert comparison.studies[0].volumes[-1] == comparison.studies[0].volume


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (["paper_6"], "1 bag; expected 2 to 40"),
        (["paper_6", "paper_6"], "named twice"),
        (["paper_6", "nosuch"], "nosuch"),
    ],
)
def test_bags_that_do_not_do_are_named(names: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    """In one line, exit code 2."""
    assert mobo("compare", *(SAMPLES / name for name in names)) == 2
    error = capsys.readouterr().err
    assert said in error and len(error.splitlines()) == 1
