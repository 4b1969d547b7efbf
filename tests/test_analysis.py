"""Tables, pictures and report of a study, against what rosbags reads from its bag."""

from __future__ import annotations

import csv
import io
import math
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.image import imread
from studies import messages, mobo, run_study

from mobo_core.bag.collector import read_study
from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.report.columns import table_columns
from mobo_core.report.console import console_for, front_table, prefix_table
from mobo_core.report.figures.drawing import has_dark_text, looks, picture, red_to_green
from mobo_core.report.figures.registry import FIGURES
from mobo_core.report.figures.voxel_layers import panels, voxel_figure
from mobo_core.report.prefixes import PAPER_COLOURS, groups, prefix_of, styles
from mobo_core.report.row import Row
from mobo_core.report.table import REACH_FLOOR_SHARE, StudyTable, running_hypervolume, study_table
from mobo_core.report.table_files import to_csv
from mobo_core.search.front import aims_of, hypervolume

REJECTED = {3, 17}
N = 60


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return run_study(tmp_path_factory.mktemp("bags") / "sixty", N, name="a <b> & $c", rejected=REJECTED)


@pytest.fixture(scope="module")
def report(bag: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("report") / "deep" / "er"
    assert mobo("report", bag, "-o", folder) == 0
    return folder


def read_csv(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def row(trial: int, joints: str, reach: float, torque: float, *, on_front: bool = False) -> Row:
    return Row(
        trial=trial, complete=True, joints=joints, sampled_joints=joints, lengths=(0.1,) * len(joints), reach=reach,
        torque=torque, on_front=on_front, above_floor=reach >= 7.5, known_as=(), attempt=1, evaluator="e",
        seconds=0.1, reason="",
    )  # fmt: skip


def test_trials_csv_holds_what_rosbags_reads(bag: Path, report: Path) -> None:
    rows = read_csv(report / "trials.csv")
    told = {message.trial: message for message in messages(bag, "/trials")}
    candidates = {message.trial: message for message in messages(bag, "/candidates")}
    assert [int(line["trial"]) for line in rows] == sorted(told) == list(range(N))
    # Evaluators are numbered: their names tell hosts.
    pairs = {(line["evaluator"], told[int(line["trial"])].evaluator) for line in rows}
    assert {number for number, _ in pairs} == {"evaluator 1", "evaluator 2"} and len(pairs) == 2
    for line in rows:
        message, candidate = told[int(line["trial"])], candidates[int(line["trial"])]
        assert line["joints"] == candidate.joints and line["sampled_joints"] == candidate.sampled_joints
        assert [float(line[f"length_{i + 1}"]) for i in range(6)] == candidate.lengths.tolist()
        assert int(line["attempt"]) == message.attempt
        if message.trial in REJECTED:
            assert (line["state"], line["reach"], line["torque"]) == ("FAIL", "", "")
            assert line["reason"] == message.reason == 'rejected: no good <arm> & "so" on'
        else:
            assert line["state"] == "COMPLETE" and line["reason"] == ""
            assert float(line["reach"]) == message.reach and float(line["torque"]) == message.torque


def test_front_csv_is_the_front_by_falling_reach(bag: Path, report: Path) -> None:
    told = [message for message in messages(bag, "/trials") if message.state == 0]
    best = {
        a.trial
        for a in told
        if not any(b.reach >= a.reach and b.torque <= a.torque and b.trial != a.trial for b in told)
    }
    rows = read_csv(report / "front.csv")
    assert {int(line["trial"]) for line in rows} == best
    reaches = [float(line["reach"]) for line in rows]
    assert reaches == sorted(reaches, reverse=True)
    assert [line["above_floor"] for line in rows] == [str(int(reach >= 7.5)) for reach in reaches]


def test_front_above_the_floor_is_the_front_of_the_arms_above_the_floor(bag: Path) -> None:
    table = study_table(read_study(bag))
    high = [r for r in table.complete if r.reach >= REACH_FLOOR_SHARE * table.n_voxels]
    front = [
        a for a in high if not any(b.reach >= a.reach and b.torque <= a.torque and b.trial != a.trial for b in high)
    ]
    assert {r.trial for r in table.useful_front} == {r.trial for r in front}


def test_running_hypervolume_rises_to_that_of_all_trials(bag: Path) -> None:
    table = study_table(read_study(bag))
    counts, volumes = running_hypervolume(table, steps=20)
    assert len(counts) == 20 and counts[-1] == N
    assert all(a <= b for a, b in zip(volumes, volumes[1:], strict=False))
    arms = [(r.reach, r.torque) for r in table.complete]
    assert volumes[-1] == hypervolume(arms, aims_of(("reach", "torque"), EvaluationSpec()))


def test_best_of_a_prefix_is_its_highest_reach_and_the_papers_come_first() -> None:
    rows = (
        row(0, "YPPYPY", 30.0, 300.0),
        row(1, "YPPYPR", 31.0, 310.0),
        row(2, "YPPYRR", 31.0, 305.0),
        row(3, "RRRRRR", 50.0, 100.0, on_front=True),
        row(4, "PPPPPP", 60.0, 200.0, on_front=True),
    )
    of = groups(StudyTable(rows, 6, 75))
    assert [group.prefix for group in of] == [*PAPER_COLOURS[6], "PPPP", "RRRR"]
    best = {group.prefix: group.best.trial for group in of if group.best}
    assert best == {"YPPY": 2, "PPPP": 4, "RRRR": 3}
    assert [group.n_on_front for group in of][-2:] == [1, 1]


def test_prefixes_have_the_papers_colours() -> None:
    six = {style.prefix: style.colour for style in styles(StudyTable((), 6, 75))}
    assert six == {"PRRY": "#ff00ff", "RPYP": "#ff0000", "YPRY": "#0000ff", "RPPY": "#00ffff", "YPPY": "#008000",
                   "YPPP": "#ff8000"}  # fmt: skip
    seven = {style.prefix: style.colour for style in styles(StudyTable((), 7, 75))}
    assert seven == {"PRRY": "#ff00ff", "YPRR": "#00ffff", "YPRY": "#0000ff", "YPPP": "#ff8000", "YPPY": "#008000",
                     "YPYP": "#ff0000", "YPRP": "#00ff00"}  # fmt: skip
    for named in PAPER_COLOURS.values():
        assert len({marker for _, marker in named.values()}) == len(named)


def test_known_arms_are_named_in_the_table() -> None:
    columns = table_columns([row(0, "YPPYPY", 30.0, 300.0)], 6)
    assert columns["known_as"] == [""]
    named = SimpleNamespace(**{**row(0, "YPPYPY", 30.0, 300.0).__dict__, "known_as": ("A", "B"), "state": "COMPLETE"})
    assert table_columns([named], 6)["known_as"] == ["A; B"]


def test_csv_numbers_read_back_exactly() -> None:
    value = 0.1 + 0.2
    text = to_csv({"a": [value, None, True], "b": ["x,y", 'say "hi"', "two\nlines"]})
    lines = list(csv.reader(text.splitlines(keepends=True)))
    assert float(lines[1][0]) == value
    assert lines[1:] == [[repr(value), "x,y"], ["", 'say "hi"'], ["1", "two\nlines"]]


def test_pictures_show_something(report: Path) -> None:
    for name in ("sampling.png", "hypervolume.png", *(path.name for path in report.glob("voxels_*.png"))):
        image = imread(report / name)[..., :3]
        assert image.shape[0] > 400 and image.shape[1] > 800, name
        colours = (image[::3, ::3] * 255).astype(int) @ [1, 256, 65536]
        assert len(np.unique(colours)) > 30, name
        assert np.all(image[:3] == 1) and np.all(image[-3:] == 1), f"{name}: something is cut off at the border"


def test_svg_is_well_formed_and_holds_every_arm(report: Path) -> None:
    text = (report / "sampling.svg").read_text(encoding="utf-8")
    root = ElementTree.fromstring(text)
    assert root.tag.endswith("svg")
    assert len(root.findall(".//{*}use")) > N - len(REJECTED)
    assert 'href="http' not in text and "url(http" not in text


def test_voxel_maps_are_of_the_best_arms(bag: Path, report: Path) -> None:
    table = study_table(read_study(bag))
    drawn = {path.stem.removeprefix("voxels_") for path in report.glob("voxels_*.png")}
    present = {prefix_of(r) for r in table.complete}
    assert drawn <= present and present & set(PAPER_COLOURS[6]) <= drawn and len(drawn) >= 4


def test_the_colour_scale_runs_from_red_to_green_with_rising_lightness() -> None:
    colours = [red_to_green()(i)[:3] for i in range(256)]
    assert colours[0][0] > 0.8 > 0.3 > max(colours[0][1:])
    assert colours[-1][1] > 0.85 and colours[-1][1] > 1.5 * colours[-1][0]

    def luminance(colour: tuple[float, ...]) -> float:
        linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in colour]
        return float(np.dot([0.2126, 0.7152, 0.0722], linear))

    assert np.all(np.diff([luminance(colour) for colour in colours]) > 0)
    assert has_dark_text(colours[-1]) and not has_dark_text(colours[0])


def test_voxels_lie_in_the_map_where_they_lie_in_the_workspace() -> None:
    spec, dpi = EvaluationSpec(), 40
    centres = spec.voxel_centres()
    reach = np.zeros(spec.n_voxels)
    marked = int(np.argmin(np.linalg.norm(centres - [0.4, -0.2, 0.2], axis=1)))
    reach[marked] = 0.5
    evaluation = SimpleNamespace(voxel_reach=reach, voxel_torque=reach * 10)
    with looks():
        canvas = voxel_figure(row(0, "YPPYPY", 0.5, 5.0), evaluation, spec, "title")
        image = imread(io.BytesIO(picture(canvas, "png", dpi)))
    drawn, _, height = panels(spec)
    amber, grey = red_to_green()(0.5)[:3], (0xEC / 255,) * 3
    layers = [round((z - spec.workspace_min[2]) / spec.voxel_size - 0.5) for z in centres[:, 2]]
    for panel in drawn:
        for voxel, (x, y, _) in enumerate(centres):
            if layers[voxel] == panel.layer:
                # Below the number, above the edge.
                at = panel.at(x, y - 0.07) * dpi
                colour = image[int(height * dpi - at[1]), int(at[0]), :3]
                expected = amber if voxel == marked else red_to_green()(0.0)[:3] if panel.name == "reach" else grey
                same = np.abs(colour - expected).max() < 0.08
                if voxel == marked:
                    assert same if panel.name == "reach" else not np.allclose(colour, grey, atol=0.08)
                else:
                    assert not np.allclose(colour, amber, atol=0.08)


@pytest.mark.slow
@pytest.mark.parametrize(
    "values",
    [
        {"workspace_min": (0, 0, 0), "workspace_max": (0.1, 0.1, 0.1), "voxel_size": 0.1},
        {"workspace_min": (-0.1, -0.2, 0), "workspace_max": (0.1, 0.2, 2.0), "voxel_size": 0.1},
        {"voxel_size": 0.02},
    ],
    ids=["one voxel", "twenty layers", "75,000 voxels"],
)
def test_voxel_maps_of_other_workspaces(values: dict[str, object]) -> None:
    spec = EvaluationSpec.of(values)
    reach = np.linspace(0, 1, spec.n_voxels)
    evaluation = SimpleNamespace(voxel_reach=reach, voxel_torque=reach * 12)
    with looks():
        png = picture(voxel_figure(row(0, "RP", 1.0, 1.0), evaluation, spec, "title"), "png", dpi=30)
    assert png.startswith(b"\x89PNG") and len(png) > 3000


class Page(HTMLParser):
    """Checks that tags are balanced, and keeps text and addresses."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.addresses: list[str] = []
        self.text = ""
        self.feed(text)
        assert not self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.addresses += [value or "" for name, value in attrs if name in ("src", "href")]
        if tag not in ("meta", "img", "br"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


def test_page_is_well_formed_and_loads_nothing_from_elsewhere(report: Path) -> None:
    page = Page((report / "index.html").read_text(encoding="utf-8"))
    for address in page.addresses:
        assert address.startswith("data:image/png;base64,") or (report / address).is_file()
    assert sum(address.startswith("data:") for address in page.addresses) == len(list(report.glob("*.png")))


def test_page_shows_names_as_they_are_and_the_reasons_of_failures(report: Path) -> None:
    page = Page((report / "index.html").read_text(encoding="utf-8"))
    assert "a <b> & $c" in page.text and 'rejected: no good <arm> & "so" on' in page.text
    for word in ("58arms evaluated", "2failed", "space.n_joints", "n_startup_trials", "optuna"):
        assert word in page.text


@pytest.mark.slow
def test_again_it_gives_the_same_files_and_prints_the_front_and_paths(
    bag: Path, report: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = {path.name: path.read_bytes() for path in report.iterdir()}
    (report / "voxels_XXXX.png").write_bytes(b"of an older report")
    assert mobo("report", bag, "-o", report) == 0
    assert {path.name: path.read_bytes() for path in report.iterdir()} == before
    out = capsys.readouterr().out
    assert "60 trials told, 2 failed" in out
    for line in read_csv(report / "front.csv"):
        assert re.search(rf"^ *{line['trial']} +{line['joints']} +{float(line['reach']):.2f} ", out, re.M)
    for name in ("front.csv", "sampling.png", "index.html"):
        assert str(report / name) in out


@pytest.mark.slow
@pytest.mark.parametrize("n", [1, 2])
def test_report_of_studies_with_hardly_a_trial(n: int, tmp_path: Path) -> None:
    """One trial that failed, and one that failed with one that did not."""
    bag = run_study(tmp_path / "bag", n, rejected={0})
    assert mobo("report", bag, "-o", tmp_path / "out") == 0
    assert len(read_csv(tmp_path / "out" / "front.csv")) == n - 1
    assert len(read_csv(tmp_path / "out" / "trials.csv")) == n
    Page((tmp_path / "out" / "index.html").read_text(encoding="utf-8"))


@pytest.mark.filterwarnings("error::UserWarning")
def test_report_of_a_study_that_told_nothing_and_has_an_odd_name(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bag = run_study(tmp_path / "bag", 5, kill_after=0, name=r"$\frac{腕}$[red]" + 200 * "x")
    assert mobo("report", bag, "-o", tmp_path / "out") == 0
    assert read_csv(tmp_path / "out" / "front.csv") == []
    assert "no complete trial" in capsys.readouterr().out


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return run_study(tmp_path_factory.mktemp("bags") / "small", 8)


@pytest.mark.slow
def test_report_of_a_damaged_bag_says_so_and_goes_on(
    small: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = (small / "small_0.mcap").read_bytes()
    (tmp_path / "torn").mkdir()
    torn = tmp_path / "torn" / "torn_0.mcap"
    torn.write_bytes(data[: len(data) // 2])
    n = len(read_study(tmp_path / "torn").contents[0].entries)
    assert mobo("report", tmp_path / "torn", "-o", tmp_path / "out") == 0
    assert capsys.readouterr().err == f"{torn}: cut off; {n} messages read\n"
    assert 0 < len(read_csv(tmp_path / "out" / "trials.csv")) < 8
    Page((tmp_path / "out" / "index.html").read_text(encoding="utf-8"))


@pytest.mark.slow
def test_report_of_several_bags_has_a_folder_for_each(
    small: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(FIGURES, "_entries", {"claims": FIGURES["claims"], "stages": FIGURES["stages"]})
    seven = {"space": {"n_joints": 7, "lengths": "sequential"}, "sampler": "random"}
    other = run_study(tmp_path / "one" / "small", 3, name="seven", settings=seven)
    assert mobo("report", small, other, "-o", tmp_path / "out") == 0
    page = Page((tmp_path / "out" / "index.html").read_text(encoding="utf-8"))
    links = [address for address in page.addresses if not address.startswith("data:image/png;")]  # of the claims
    assert links == ["small/index.html", "small_2/index.html"]
    assert "length_7" in (tmp_path / "out" / "small_2" / "front.csv").read_text(encoding="utf-8")
    assert all((tmp_path / "out" / address).is_file() for address in links)


def test_no_text_of_a_bag_speaks_to_the_terminal(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    hostile = replace(study_table(read_study(bag)).front[0], joints="\x1b]0;me\x07[red]PY")
    table = StudyTable((hostile,), 6, 75)
    console_for(front_table(table)).print(front_table(table))
    console_for(prefix_table(groups(table), 75)).print(prefix_table(groups(table), 75))
    out = capsys.readouterr().out
    assert out.count("\\x1b]0;me\\x07[red]PY") == 2 and "\x1b" not in out and "\x07" not in out


def test_report_of_no_bag_writes_nothing(bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert mobo("report", bag, tmp_path / "none", "-o", tmp_path / "out") == 2
    assert capsys.readouterr().err == (
        f"mobo report: {tmp_path}/none: no such bag; expected the folder of a bag, or an .mcap file\n"
    )
    assert not (tmp_path / "out").exists()


def test_report_into_a_file_is_refused(bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("mine")
    assert mobo("report", bag, "-o", tmp_path / "file") == 2
    assert f"{tmp_path}/file: is a file; expected a folder" in capsys.readouterr().err
    assert (tmp_path / "file").read_text() == "mine"


def test_values_that_are_no_numbers_count_as_none(bag: Path) -> None:
    study = read_study(bag)
    study.trials[5].reach = math.nan
    table = study_table(study)
    assert 5 not in {r.trial for r in table.complete}
    assert len(table.rows) == N
