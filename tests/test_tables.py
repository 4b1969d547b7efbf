"""A study's table for Python users."""

from __future__ import annotations

import csv
import io
import json
import re
import sys
from pathlib import Path

import pytest
from rich.console import Console
from studies import mobo

from mobo_core.bag.collector import read_study
from mobo_core.errors import InputError
from mobo_core.report.console import console_for, front_table, prefix_table
from mobo_core.report.page.study_page import study_page
from mobo_core.report.prefixes import groups
from mobo_core.report.table import StudyTable, study_table

SAMPLE = Path(__file__).parents[1] / "bags" / "sample" / "paper_6"


@pytest.fixture(scope="module")
def table() -> StudyTable:
    return study_table(read_study(SAMPLE))


def test_repr_says_what_it_is(table: StudyTable) -> None:
    """In one short line, not a screenful of rows."""
    assert repr(table) == "<StudyTable: 60 trials of 6 joints, 1 failed, 15 on the front, best reach 34.70 of 75>"
    assert repr(StudyTable((), 7, 75)) == "<StudyTable: 0 trials of 7 joints, 0 failed, 0 on the front>"


def test_to_dict_is_the_csv_as_plain_values(table: StudyTable, tmp_path: Path) -> None:
    """Same columns in the same order, same values; fit for JSON."""
    assert mobo("export", "table", SAMPLE, "-o", tmp_path / "t.csv") == 0
    with (tmp_path / "t.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    columns = json.loads(json.dumps(table.to_dict()))
    assert list(columns) == list(rows[0])
    for name in ("reach", "torque", "length_1", "length_6"):
        assert columns[name] == [float(row[name]) if row[name] else None for row in rows]
    assert columns["joints"] == [row["joints"] for row in rows]


def test_to_pandas_has_a_row_a_trial(table: StudyTable) -> None:
    """Indexed by trial; what a failed trial lacks is missing."""
    pandas = pytest.importorskip("pandas")
    frame = table.to_pandas()
    assert frame.index.name == "trial" and list(frame.index) == list(range(60))
    assert frame["reach"].max() == max(row.reach for row in table.complete)
    assert list(frame.index[pandas.isna(frame["reach"])]) == [row.trial for row in table.failed]
    assert frame["on_front"].sum() == 15


def test_without_pandas_it_says_what_to_install(table: StudyTable, monkeypatch: pytest.MonkeyPatch) -> None:
    """One line: what, where, what was expected."""
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(InputError, match="pandas is not installed; expected pip install pandas$"):
        table.to_pandas()


def test_objectives_beyond_reach_and_torque_have_columns(tmp_path: Path) -> None:
    """In the table, on the page and on the terminal, by name and with their unit; others have none."""
    study = read_study(SAMPLE)
    study.settings = study.settings.model_copy(update={"objectives": ("reach", "torque", "mass")})
    for trial in study.trials.values():
        trial.extra_names, trial.extra_values = ["mass"], [3.25]
    table = study_table(study)
    assert table.further == {"mass": "mass [kg]"} and study_table(read_study(SAMPLE)).further == {}
    assert [value for value in table.to_dict()["mass"] if value is not None] == [3.25] * 59
    page = study_page(study, table, groups(table), [])
    assert '<th class="n">mass [kg]</th>' in page and '<td class="n">3.25</td>' in page
    assert "searched for high reach, low joint torque and low mass:" in page
    console = Console(width=200, file=io.StringIO())
    console.print(front_table(table), prefix_table(groups(table), 75))
    shown = console.file.getvalue()
    assert "mass kg" in shown and shown.count(" 3.25 ") == len(table.front)


@pytest.mark.parametrize("columns", ["20", "80", "300"])
@pytest.mark.parametrize("terminal", [True, False])
def test_numbers_are_never_broken_over_lines(
    table: StudyTable, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], columns: str, terminal: bool
) -> None:
    """However narrow it is; off a terminal a row is a line."""
    monkeypatch.setenv("COLUMNS", columns)
    monkeypatch.setenv("FORCE_COLOR" if terminal else "NO_COLOR", "1")
    front = front_table(table)
    console_for(front, prefix_table(groups(table), 75)).print(front)
    shown = re.sub(r"\x1b[^m]*m", "", capsys.readouterr().out)
    words = set(shown.split())
    for row in table.front:
        cells = [f"{row.reach:.2f}", f"{row.torque:.1f}", row.joints, *(f"{length:.3f}" for length in row.lengths)]
        assert words.issuperset(cells[:3])
        assert terminal or any(set(cells[:3]) <= set(line.split()) for line in shown.splitlines())
    assert "…" not in shown
