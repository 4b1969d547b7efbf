"""The report's page in a browser: it loads, filters, shows arms as they are, and takes nothing a bag says for HTML."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from studies import mobo, run_study

from mobo_core.bag.collector import read_study
from mobo_core.design import Design, DesignSpace, to_urdf
from mobo_core.evaluation.chain import chain_from_urdf
from mobo_core.evaluation.kernel.configuration import forward, gravity_torque
from mobo_core.evaluation.kernel.geometry import any_pair_collides
from mobo_core.report.table import study_table

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
if CHROMIUM is None:
    pytest.skip("no chromium: apt-get install chromium", allow_module_level=True)

SAMPLE = Path(__file__).parents[1] / "bags" / "sample" / "paper_6"
HOSTILE = '</script><img src=x onerror="window.hit=1"><b>&amp;'


PICTURE = "document.querySelector('#arm canvas.arm3d').toDataURL()"
SHOWN = "(trial) => document.querySelector('#arm .trial').textContent === `trial ${trial}`"
PLACE = """(trial) => {
  const picture = mobo.mainScatter, row = mobo.study.rowOf.get(trial);
  return [picture.toX(picture.x.values[row]), picture.toY(picture.y.values[row])];
}"""
URDFS = """async () => {
  const study = mobo.study, rows = [...study.raw.trial.keys()];
  return Promise.all(rows.map(async (row) => [study.raw.trial[row], await mobo.urdf.of(study, row)]));
}"""
POSTURES = """([urdf, all]) => {
  const robot = new mobo.Robot(urdf);
  return all.map((q) => {
    const placed = robot.place(q);
    return [robot.colliding(placed).size > 0, robot.torques(placed, [0, 0, -9.81]), placed.at(-1).frame[1]];
  });
}"""
VOXELS = """async () => {
  const study = mobo.study, plain = (values) => Array.from(values, (x) => (Number.isNaN(x) ? null : x));
  return Promise.all([...study.raw.trial.keys()].map(async (row) => [study.raw.trial[row],
    Object.fromEntries(Object.entries(await study.voxels(row)).map(([name, values]) => [name, plain(values)]))]));
}"""
# Texts whose colour stands out less than 4.5 to 1 from the nearest colour behind them, as WCAG 2 reckons.
CONTRAST = """() => {
  const parse = (colour) => colour.match(/[\\d.]+/g).map(Number);
  const linear = (v) => (v / 255 <= 0.04045 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4);
  const luminance = ([r, g, b]) => 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
  const behind = (node) => {
    for (; node; node = node.parentElement) {
      const colour = parse(getComputedStyle(node).backgroundColor);
      if ((colour[3] ?? 1) > 0.99) return colour;
    }
    return [255, 255, 255];
  };
  const bad = new Set();
  for (const node of document.querySelectorAll("body *")) {
    const said = [...node.childNodes].some((child) => child.nodeType === 3 && child.textContent.trim());
    if (!said || node.closest("svg, script, style, noscript, option, [disabled]")) continue;
    if (!node.getClientRects().length) continue;
    const both = [luminance(parse(getComputedStyle(node).color)), luminance(behind(node))].sort((x, y) => y - x);
    const ratio = (both[0] + 0.05) / (both[1] + 0.05);
    if (ratio < 4.5) bad.add(`${node.tagName} ${node.className} ${ratio.toFixed(2)} ${node.textContent.slice(0, 20)}`);
  }
  return [...bad];
}"""


class Errors(list[str]):
    """What a page complains of."""


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with sync_api.sync_playwright() as play:
        flags = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        running = play.chromium.launch(executable_path=CHROMIUM, args=flags)
        yield running
        running.close()


def opened(browser: Any, page_file: Path, **options: Any) -> tuple[Any, Errors]:
    page, errors = browser.new_page(**options), Errors()
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("console", lambda said: errors.append(said.text) if said.type in ("error", "warning") else None)
    own = ("file:", "data:", "blob:")
    page.on("request", lambda request: None if request.url.startswith(own) else errors.append(request.url))
    page.goto(page_file.as_uri())
    page.wait_for_function("document.documentElement.dataset.ready", timeout=120_000)
    return page, errors


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("report")
    assert mobo("report", SAMPLE, "-o", folder) == 0
    return folder / "index.html"


@pytest.fixture
def page(browser: Any, report: Path) -> Iterator[Any]:
    shown, errors = opened(browser, report, viewport={"width": 1300, "height": 900})
    yield shown
    shown.close()
    assert not errors


def test_it_filters_opens_a_point_moves_a_joint_and_pins_two(page: Any) -> None:
    """By mouse and by keyboard, with no script error and nothing loaded."""
    table = study_table(read_study(SAMPLE))
    page.get_by_label("above the reach floor").check()
    useful = sum(row.above_floor for row in table.complete)
    assert page.evaluate("mobo.study.nShown") == useful < len(table.complete)
    page.get_by_label("above the reach floor").uncheck()
    order = table.complete[5].joints
    page.locator("input.order").fill(order[:2])
    assert page.evaluate("mobo.study.nShown") == sum(row.joints.startswith(order[:2]) for row in table.complete)
    page.locator("input.order").fill("")
    best = table.useful_front[0]
    second = table.useful_front[1].trial
    x, y = page.evaluate(PLACE, second)
    page.locator("canvas.points").click(position={"x": x, "y": y})
    page.wait_for_function(SHOWN, arg=second)
    page.wait_for_selector("#arm input[type=range]")
    before = page.evaluate(PICTURE)
    page.locator("#arm input[type=range]").nth(1).focus()
    for _ in range(20):
        page.keyboard.press("ArrowRight")
    page.wait_for_function(f"(old) => {PICTURE} !== old", arg=before)
    page.locator("#arm button.pin").click()
    page.locator("#front button.arm", has_text=str(best.trial)).first.press("Enter")
    page.wait_for_function(SHOWN, arg=best.trial)
    page.locator("#arm button.pin").press("Enter")
    page.wait_for_function("document.querySelectorAll('#pins .card').length === 2")
    assert page.locator("#pinned").is_visible()
    written = page.locator("main").inner_text()
    assert not [word for word in ("null", "undefined", "NaN", "[object") if word in written]


def test_arrows_go_from_arm_to_arm_and_enter_opens(page: Any) -> None:
    """The picture can be used with the keyboard alone."""
    page.locator("canvas.points").focus()
    before = page.evaluate("mobo.study.chosen")
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("Enter")
    after = page.evaluate("mobo.study.chosen")
    reach = page.evaluate("(rows) => rows.map((row) => mobo.study.raw.reach[row])", [before, after])
    assert reach[1] < reach[0]


def test_urdfs_made_in_the_page_are_the_recorded_ones(page: Any) -> None:
    """Byte for byte, of every arm."""
    study = read_study(SAMPLE)
    made = page.evaluate(URDFS)
    assert len(made) == len(study.complete_trials())
    for trial, text in made:
        assert text == study.candidate_of(trial).urdf


def test_numbers_are_written_as_python_writes_them(page: Any) -> None:
    """The shortest decimal that reads back, of floats of all sizes."""
    chance = np.random.default_rng(3)
    numbers = [0.0, -0.0, 1.0, 0.1, 1e15, 1e16, 123456789012345680.0, 1e-4, 9.999e-5, 5e-324, 1.7976931348623157e308]
    numbers += (chance.standard_normal(300) * 10.0 ** chance.integers(-20, 20, 300)).tolist()
    assert page.evaluate("(all) => all.map((text) => mobo.urdf.repr(Number(text)))", [repr(n) for n in numbers]) == [
        repr(number) for number in numbers
    ]


def test_collisions_and_torques_of_a_posture_are_the_kernels(page: Any) -> None:
    """Of random postures of several arms, one with slides."""
    study, chance = read_study(SAMPLE), np.random.default_rng(1)
    both = set()
    sliding = to_urdf(Design("SPSRPR", (0.1, 0.1, 0.2, 0.1, 0.05, 0.05)), DesignSpace(joint_types="RPYS"))
    for urdf in [study.candidate_of(trial.trial).urdf for trial in study.complete_trials()[::9]] + [sliding]:
        chain = chain_from_urdf(urdf)
        n = chain.n
        postures = chance.uniform(chain.lower, chain.upper, (20, n))
        found = page.evaluate(POSTURES, [urdf, postures.tolist()])
        axes, origins, rotations, tip = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3, 3)), np.empty((4, 3))
        torque, ends = np.empty(n), np.empty((len(chain.capsule_joint), 2, 3))
        for q, (hits, torques, at) in zip(postures, found, strict=True):
            placed = (chain.placement_r, chain.placement_p, chain.tip_r, chain.tip_p)
            forward(*placed, chain.slide, q, axes, origins, rotations, tip)
            gravity_torque(
                chain.mass, chain.com, chain.slide, np.array([0, 0, -9.81]), axes, origins, rotations, torque
            )  # fmt: skip
            expected = any_pair_collides(
                chain.capsule_joint, chain.capsule_a, chain.capsule_b, chain.capsule_radius, chain.pairs, origins,
                rotations, ends,
            )  # fmt: skip
            assert hits == expected
            both.add(hits)
            np.testing.assert_allclose(torques, torque, atol=1e-9)
            np.testing.assert_allclose(at, tip[3], atol=1e-12)
    assert both == {True, False}


def test_voxels_are_the_recorded_ones(page: Any) -> None:
    """Of every arm: reach, failures by reason, and torque to half a step."""
    study = read_study(SAMPLE)
    shown = page.evaluate(VOXELS)
    poses = study.settings.spec.poses_per_voxel
    for trial, found in shown:
        answer = study.accepted(trial)
        np.testing.assert_allclose(found["reach"], answer.voxel_reach, atol=1e-12)
        for name in ("out_of_range", "not_converged", "in_collision"):
            np.testing.assert_allclose(found[name], getattr(answer, f"voxel_{name}") / poses, atol=1e-12)
        for torque, reach, recorded in zip(found["torque"], answer.voxel_reach, answer.voxel_torque, strict=True):
            assert (torque is None) == (reach == 0) and (torque is None or abs(torque - recorded) <= 0.00501)


def test_what_a_hostile_bag_says_stays_text(browser: Any, tmp_path: Path) -> None:
    """Names of studies and evaluators, reasons, joints."""
    bag = run_study(tmp_path / "bag", 12, name=HOSTILE.replace("/", "|"), evaluators=(HOSTILE, "e1"), rejected={3})
    assert mobo("report", bag, "-o", tmp_path / "out") == 0
    page, errors = opened(browser, tmp_path / "out" / "index.html")
    assert not errors and page.evaluate("window.hit") is None
    assert page.locator("h1").text_content() == HOSTILE.replace("/", "|")
    assert page.locator("img[src=x]").count() == 0
    assert "onerror" not in page.evaluate("[...document.querySelectorAll('*')].flatMap((e) => e.getAttributeNames())")
    page.close()


def test_on_a_phone_nothing_is_wider_than_the_screen(browser: Any, report: Path) -> None:
    """In the dark, too."""
    page, errors = opened(browser, report, viewport={"width": 375, "height": 740}, color_scheme="dark")
    assert page.evaluate("document.documentElement.scrollWidth") <= 375
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(16, 19, 22)"
    page.close()
    assert not errors


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_stands_out_from_what_is_behind_it(browser: Any, report: Path, scheme: str) -> None:
    """By WCAG's AA, 4.5 to 1."""
    page, errors = opened(browser, report, color_scheme=scheme)
    assert page.evaluate(CONTRAST) == [] and not errors
    page.close()
