"""Figures of the report: mobo's own, and those of other distributions."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from distributions import install
from studies import mobo, run_study

from mobo_core.report.figures.figure import Figure
from mobo_core.report.figures.registry import FIGURES

SOURCE = """
from matplotlib.figure import Figure as Canvas

from mobo_core.report.figures.figure import Figure, Picture


def draw(study, table):
    for state, rows in (("good", table.complete), ("a/b", table.rows)):
        canvas = Canvas(figsize=(6, 3))
        canvas.add_subplot().hist([row.seconds for row in rows if row.complete])
        yield Picture(canvas, state, f"Seconds of the {state} <ones>.")


def fail(study, table):
    yield Picture(Canvas())
    raise KeyError("no such\\nthing")


SECONDS = Figure("seconds", "How long it took", "Seconds of each evaluation.", draw, parts="STATE", svg=True)
BROKEN = Figure("broken", "Broken", "Nothing.", fail)
WRONG = Figure("wrong", "Wrong", "No picture.", lambda study, table: [7])
TWICE = Figure("twice", "Twice", "Twice the same.", lambda study, table: [Picture(Canvas()), Picture(Canvas())])
NONE = Figure("nothing", "Nothing to show", "Nothing.", lambda study, table: [])
"""


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two trials, one of which failed: all figures have something to show."""
    return run_study(tmp_path_factory.mktemp("bags") / "two", 2, rejected={0})


@pytest.fixture(scope="module")
def plain(bag: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The report without any other distribution."""
    folder = tmp_path_factory.mktemp("plain")
    assert mobo("report", bag, "-o", folder) == 0
    return folder


def names(folder: Path) -> set[str]:
    return {file.name for file in folder.iterdir()}


@pytest.mark.slow
def test_a_figure_of_another_distribution(
    bag: Path, plain: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """It is in folder, page and help; one that raises is told in a line, and all else is as without it."""
    entries = {"seconds": "SECONDS", "a_broken": "BROKEN", "wrong": "WRONG", "twice": "TWICE", "nothing": "NONE"}
    install(tmp_path, monkeypatch, FIGURES, "more_figures", SOURCE, **entries)
    out = tmp_path / "out"
    shutil.copytree(plain, out)
    (out / "seconds_of_old.png").write_bytes(b"of an older report")
    (out / "secondsight.png").write_bytes(b"mine")
    assert mobo("report", bag, "-o", out) == 0
    lines = capsys.readouterr().err.splitlines()
    assert [line.split(": ")[:3] for line in lines] == [
        ["mobo", "figure 'broken' left out", "KeyError"],
        ["mobo", "figure 'twice' left out", "ValueError"],
        ["mobo", "figure 'wrong' left out", "AttributeError"],
    ]
    added = {"seconds_good.png", "seconds_good.svg", "seconds_a_b.png", "seconds_a_b.svg"}
    assert names(out) == names(plain) | added | {"secondsight.png"}
    for file in names(plain) - {"index.html"}:
        assert (out / file).read_bytes() == (plain / file).read_bytes()
    page = (out / "index.html").read_text(encoding="utf-8")
    assert "<h2>How long it took</h2>" in page and "Seconds of the a/b &lt;ones&gt;." in page
    assert '<a href="seconds_good.svg">' in page
    assert not any(heading in page for heading in ("<h2>Broken", "<h2>Wrong", "<h2>Twice", "<h2>Nothing"))
    assert mobo("report", "--help") == 0
    assert "  seconds_<STATE>.png and .svg  Seconds of each evaluation.\n" in capsys.readouterr().out


def test_help_names_every_figure_and_its_files(capsys: pytest.CaptureFixture[str]) -> None:
    """With no list of its own."""
    assert mobo("report", "--help") == 0
    text = capsys.readouterr().out
    for figure in FIGURES.values():
        assert figure.files in text and figure.caption.split(".")[0] in " ".join(text.split())


def test_an_own_figure_that_raises_is_not_hidden(bag: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Mobo's own faults are found, not passed over."""

    def fail(study: object, table: object) -> list[object]:
        raise ZeroDivisionError

    broken = Figure("sampling", "", "caption", fail)  # type: ignore[arg-type]
    monkeypatch.setattr(FIGURES, "_entries", {**dict(FIGURES), "sampling": broken})
    with pytest.raises(ZeroDivisionError):
        mobo("report", bag, "-o", tmp_path)
    assert not names(tmp_path)


@pytest.mark.parametrize("name", ["", "Sampling", "a/b", "../a", "1", "a b"])
def test_a_name_that_is_no_part_of_a_file_name_is_refused(name: str) -> None:
    """When the entry is made, hence before anything is drawn."""
    with pytest.raises(ValueError, match="not lower-case letters"):
        Figure(name, "", "", lambda study, table: [])
