"""Each claim of the paper turns when what it speaks of is turned; what was hardly searched decides nothing."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np
import pytest
from studies import QUICK, mobo, mobo_json, run_study

from mobo_core.atlas.file import read_atlas
from mobo_core.bag.collector import read_study
from mobo_core.bag.record import StudyRecord
from mobo_core.design import DesignSpace, to_urdf
from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.messages import Candidate, Evaluation, Trial
from mobo_core.report.claims.check import CLAIMS, check_claims
from mobo_core.report.claims.claim import Pair
from mobo_core.report.claims.evidence import Arm, Evidence, Maps, of_study
from mobo_core.report.claims.fair import of_atlas
from mobo_core.report.claims.verdict import INCONCLUSIVE, NOT_REPRODUCED, REPRODUCED, Checked, Outcome
from mobo_core.report.claims.voxels import spearman
from mobo_core.report.compare.summary import summary_of
from mobo_core.report.figures.claims import FIGURE as CLAIMS_FIGURE
from mobo_core.report.report import Report, write_index
from mobo_core.report.table import study_table
from mobo_core.search.study import StudySettings

SAMPLES = Path(__file__).parents[1] / "bags" / "sample"
SPEC = EvaluationSpec(poses_per_voxel=120)
CENTRES = SPEC.voxel_centres()
X = CENTRES[:, 0]
NEAR = np.linalg.norm(CENTRES, axis=1) <= 0.3
SHOULDER_ELBOW_WRIST = (0.06, 0.27, 0.16, 0.11, 0.0, 0.0)


@dataclasses.dataclass
class Kind:
    """The arms of an order: the best one's values, and what sets its voxels and lengths apart."""

    joints: str
    reach: float
    torque: float
    lengths: Sequence[Sequence[float]] = (SHOULDER_ELBOW_WRIST,)
    count: int = 120
    near: float = 1.0  # reach near the body, times the mean
    along_y: float = 1.0  # torque near the y axis, times that near the x axis


ONE_TO_ONE = (0.0, 0.3, 0.0, 0.3, 0.0, 0.0, 0.0)
THREE = (0.0, 0.2, 0.0, 0.2, 0.0, 0.2, 0.0)
WAYS = [(ONE_TO_ONE,), (THREE,), (THREE,), (ONE_TO_ONE,), ((0.25, 0.25, 0.0, 0.1, 0, 0, 0),), (THREE,), (THREE,)]


def six() -> dict[str, Kind]:
    kinds = [
        Kind("PRRYPY", 54, 400, along_y=0.9), Kind("RPYPYP", 38, 220, near=0.5), Kind("YPRYPY", 44, 270),
        Kind("RPPYPY", 53.5, 402, along_y=1.1), Kind("YPPYPY", 48.5, 510), Kind("YPPPYP", 40, 440),
        Kind("YPPPRY", 20, 300, count=20), Kind("PRRYPR", 53.9, 390, count=5), Kind("YPRYPR", 43.9, 260, count=5),
    ]  # fmt: skip
    return {kind.joints: kind for kind in kinds}


def seven() -> dict[str, Kind]:
    values = {"PRRYPYP": (64, 484), "YPRRYPY": (60.5, 402), "YPRYPYP": (62, 490), "YPPPYPY": (61, 560),
              "YPPYPYP": (61.5, 555), "YPYPYPY": (61.2, 510), "YPRPYPY": (61.3, 520)}  # fmt: skip
    kinds = {joints: Kind(joints, *of, way) for (joints, of), way in zip(values.items(), WAYS, strict=True)}
    kinds["YPRRYPR"] = Kind("YPRRYPR", 60.4, 395, (ONE_TO_ONE,), 5)
    return kinds


def arms_of(kinds: dict[str, Kind], n_joints: int) -> Iterator[tuple[Arm, Maps]]:
    """Yield the arms: the best of each order first, then ever lesser ones; and their voxels."""
    chance = np.random.default_rng(0)
    n = len(CENTRES)
    for kind in kinds.values():
        for i in range(kind.count):
            share = 1 - 0.4 * i / max(kind.count - 1, 1)
            p = kind.reach * share / n * np.where(NEAR, kind.near, (n - kind.near * NEAR.sum()) / (~NEAR).sum())
            t = np.where(np.isclose(X, 0), kind.along_y, 1.0)
            p, t = np.minimum(p, 1.0), t * kind.torque * share**1.3 / t.sum()
            lengths = np.array(kind.lengths[i % len(kind.lengths)], float) + 0.001 * chance.random(n_joints)
            lengths *= 0.6 / lengths.sum()
            arm = Arm(kind.joints, tuple(lengths.tolist()), math.fsum(p), math.fsum(t))
            yield arm, (p, t, 0.2 * t)


def evidence(kinds: dict[str, Kind], n_joints: int = 6) -> Evidence:
    """Return the arms as a study holds them."""
    found = [(dataclasses.replace(arm, trial=i), maps) for i, (arm, maps) in enumerate(arms_of(kinds, n_joints))]
    maps = {arm.trial: of for arm, of in found}
    return Evidence([arm for arm, _ in found], DesignSpace(n_joints=n_joints), SPEC, maps=lambda arm: maps[arm.trial])


def made(kinds: dict[str, Kind]) -> StudyRecord:
    """Return a study of these arms, as read from a bag."""
    study = StudyRecord(Path("made"), "made", StudySettings(spec=SPEC), {})
    zeros = np.zeros(len(CENTRES))
    for trial, (arm, (p, t, deviation)) in enumerate(arms_of(kinds, 6)):
        who, values = {"trial": trial, "attempt": 1, "evaluator": "e"}, {"reach": arm.reach, "torque": arm.torque}
        study.candidates.append(
            Candidate(**who, joints=arm.joints, sampled_joints=arm.joints, lengths=np.array(arm.lengths))
        )
        study.evaluations.append(
            Evaluation(**who, **values, voxel_reach=p, voxel_torque=t, voxel_torque_sd=deviation,
                       voxel_out_of_range=zeros, voxel_not_converged=zeros, voxel_in_collision=zeros)
        )  # fmt: skip
        study.trials[trial] = Trial(**who, **values)
    return study


def verdicts(pair: Pair) -> dict[str, Checked]:
    return {one.claim: one for one in check_claims(pair, evaluate=False)}


Change = Callable[[dict[str, Kind], dict[str, Kind]], None]


def swap_torques(kinds: dict[str, Kind], a: str, b: str) -> None:
    kinds[a].torque, kinds[b].torque = kinds[b].torque, kinds[a].torque


def only_known(kinds: dict[str, Kind]) -> None:
    for joints in ("YPPYPY", "YPPPYP", "YPPPRY"):
        kinds[joints].reach, kinds[joints].torque, kinds[joints].count = 60, 200, 120


CHANGES: dict[str, Change] = {
    "C1": lambda a, b: setattr(a["YPRYPY"], "torque", 400) or setattr(a["YPRYPR"], "torque", 400),
    "C2": lambda a, b: swap_torques(a, "PRRYPY", "YPPYPY") or setattr(a["PRRYPR"], "torque", 520),
    "C4": lambda a, b: setattr(a["PRRYPY"], "along_y", 1.2),
    "C5": lambda a, b: setattr(a["RPYPYP"], "near", 1.8),
    "C6": lambda a, b: setattr(a["YPPYPY"], "torque", 250),
    "C7": lambda a, b: setattr(a["YPPPYP"], "reach", 52),
    "C8": lambda a, b: [setattr(kind, "lengths", ((0.1,) * 6,)) for kind in a.values()] and None,
    "C9": lambda a, b: setattr(b["YPYPYPY"], "torque", 300),
    "C10": lambda a, b: setattr(b["YPRRYPY"], "torque", 470) or setattr(b["YPRRYPR"], "torque", 470),
    "C11": lambda a, b: setattr(b["PRRYPYP"], "torque", 350),
    "C12": lambda a, b: setattr(b["YPYPYPY"], "torque", 700),
    "C13": lambda a, b: setattr(b["YPPPYPY"], "reach", 40),
    "C14": lambda a, b: [setattr(kind, "lengths", ((0.1,) * 7,)) for kind in b.values()] and None,
    "C18": lambda a, b: only_known(a),
}


def test_all_hold_where_arms_are_as_the_paper_says() -> None:
    """Of those that evaluate nothing."""
    found = verdicts(Pair(evidence(six()), evidence(seven(), 7)))
    assert set(found) == {claim.name for claim in CLAIMS if not claim.evaluates}
    assert not {name: one.to_dict() for name, one in found.items() if one.outcome.verdict != REPRODUCED}


@pytest.mark.parametrize("claim", CHANGES)
def test_a_bag_that_says_otherwise_turns_the_claim(claim: str) -> None:
    """Each has one; the margin changes its sign."""
    a, b = six(), seven()
    CHANGES[claim](a, b)
    found = next(one for one in CLAIMS if one.name == claim)
    outcome = Outcome(tuple(found.check(Pair(evidence(a), evidence(b, 7)))))
    assert outcome.verdict == NOT_REPRODUCED
    assert outcome.deciding is not None and (outcome.deciding.margin or 0) < 0


def test_swapped_torques_of_the_two_best_turn_c2_in_a_study() -> None:
    """Told and answered values of a record, by its table."""
    kinds = six()
    found = []
    for swap in (False, True):
        if swap:
            CHANGES["C2"](kinds, {})
        study = made(kinds)
        pair = Pair(of_study(study, study_table(study)), evidence(seven(), 7))
        found.append(Outcome(tuple(next(one for one in CLAIMS if one.name == "C2").check(pair))).verdict)
    assert found == [REPRODUCED, NOT_REPRODUCED]


def test_arms_that_cannot_be_count_for_nothing() -> None:
    """Names that are no joint orders, reach beyond the voxels, torque beyond measure: nothing changes."""
    study = made({joints: kind for joints, kind in six().items() if joints[:4] in ("PRRY", "YPPY", "RPYP")})
    before = of_study(study, study_table(study))
    odd = [("\x1b[31m<b>", 60.0, 1.0), ("PRRYP\n", 60.0, 1.0), ("YPPYPY", 1e300, 0.0), ("YPPYPY", 60.0, -1e300),
           ("YPPYPY", 70.0, 1e300), ("P" * 4000, 60.0, 1.0), ("", 60.0, 1.0)]  # fmt: skip
    for joints, reach, torque in odd:
        trial = len(study.trials)
        study.candidates.append(Candidate(trial=trial, attempt=1, evaluator="e", joints=joints, sampled_joints=joints))
        study.trials[trial] = Trial(trial=trial, attempt=1, evaluator="e", reach=reach, torque=torque)
    delattr(study, "_first")
    after = of_study(study, study_table(study))
    assert after.arms == before.arms
    compared_with = summary_of(study, "s")
    assert max(reach for reach, _ in compared_with.front) <= 75 and 0 < compared_with.volume < 1


@pytest.mark.parametrize(("claim", "prefix"), [("C1", "YPPYPY"), ("C5", "RPYPYP"), ("C7", "YPPPYP"), ("C6", "YPPYPY")])
def test_what_was_hardly_searched_is_not_worse(claim: str, prefix: str) -> None:
    """With few trials, or a best that still rises, of the prefix that would have to be the worse one."""
    for still_rising in (False, True):
        kinds = six()
        kinds[prefix].reach *= 0.6
        kinds[prefix].torque *= 0.6
        kinds[prefix].count = 120 if still_rising else 20
        kinds.pop("YPPPRY")
        of = evidence(kinds)
        if still_rising:
            of = Evidence(of.arms[::-1], of.space, of.spec, maps=of.maps)
        parts = next(one for one in CLAIMS if one.name == claim).check(Pair(of))
        spoken = [part for part in parts if part.name.startswith(prefix[:4])]
        assert spoken and all(part.verdict == INCONCLUSIVE and prefix[:4] in part.unsure for part in spoken[:1])


CHAIN = (0.0, 0.3, 0.3, 0.0, 0.0, 0.0)
QUICK_SPEC = EvaluationSpec(poses_per_voxel=10)


def evaluated(prry: str, chain: str, spec: EvaluationSpec = QUICK_SPEC, **space: object) -> Evidence:
    """Return evidence whose arms of PRRY and YPP chains are really these, whatever their names say."""
    of = DesignSpace.of(space)
    arms = [Arm("PRRYPY", SHOULDER_ELBOW_WRIST, 50.0 - i / 100, 300.0, i) for i in range(100)]
    arms += [Arm(joints, CHAIN, 40.0 - i / 100, 300.0, 100 + i) for joints in ("YPPYPY",) for i in range(100)]
    built = {"PRRYPY": to_urdf(of.arm(prry, SHOULDER_ELBOW_WRIST), of), "YPPYPY": to_urdf(of.arm(chain, CHAIN), of)}
    return Evidence(arms, of, spec, urdf=lambda arm: (built[arm.joints], ""))


def of_claim(name: str, six_joints: Evidence) -> Outcome:
    return Outcome(tuple(next(one for one in CLAIMS if one.name == name).check(Pair(six_joints))))


def test_claims_that_evaluate_turn_with_space_and_spec() -> None:
    """C3 on a base that leans; C15 where gravity pulls sideways; C16 where it is weak; C17 where arms are exchanged."""
    few = QUICK_SPEC.model_copy(update={"poses_per_voxel": 3})
    sideways, weak = (few.model_copy(update={"gravity": gravity}) for gravity in ((0.0, -9.81, 0.0), (0.0, 0.0, -3.0)))
    upright, coarse = evaluated("PRRYPY", "YPPYPY"), evaluated("PRRYPY", "YPPYPY", few)
    for name, good, otherwise in (
        ("C3", upright, evaluated("PRRYPY", "YPPYPY", base_tilt=0.6)),
        ("C15", coarse, evaluated("PRRYPY", "YPPYPY", sideways)),
        ("C16", coarse, evaluated("PRRYPY", "YPPYPY", weak)),
    ):
        assert (name, of_claim(name, good).verdict) == (name, REPRODUCED)
        assert (name, of_claim(name, otherwise).verdict) == (name, NOT_REPRODUCED)
    assert of_claim("C17", upright).verdict == REPRODUCED
    assert of_claim("C17", evaluated("YPPYPY", "PRRYPY")).verdict == NOT_REPRODUCED


def test_the_command_on_bags(capsys: pytest.CaptureFixture[str]) -> None:
    """Every claim, by the contract; short studies decide nothing of prefixes; one bag has its own claims alone."""
    found = mobo_json(capsys, "claims", SAMPLES / "paper_6", SAMPLES / "mobo_7", "--json")
    assert [one["claim"] for one in found] == [f"C{i}" for i in range(1, 19)]
    for one in found:
        assert {"verdict", "margin", "interval", "numbers", "fair"} < set(one) and one["fair"] is None
        low, high = one["interval"] or (-math.inf, math.inf)
        assert one["verdict"] == INCONCLUSIVE or (low > 0 if one["verdict"] == REPRODUCED else high < 0)
        assert one["margin"] is None or low <= one["margin"] <= high
        assert one["verdict"] == INCONCLUSIVE or one["claim"] in ("C15", "C16")
    alone = [claim.name for claim in CLAIMS if claim.needs == (7,)]
    assert mobo("claims", SAMPLES / "mobo_7", "--parts") == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines if line.startswith("C") and "  " in line][: len(alone)] == alone
    assert lines[-1] == f"{len(alone)} claims: 0 reproduced, 0 not reproduced, {len(alone)} inconclusive"


def test_an_atlas_gives_second_verdicts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Of claims that it can speak of; what it holds decides, and how far its orders were searched."""
    atlas = tmp_path / "seven.parquet"
    assert mobo("atlas", SAMPLES / "mobo_7", "-o", atlas) == 0
    found = mobo_json(capsys, "claims", SAMPLES / "mobo_7", "--atlas", atlas, "--json")
    assert all(set(one["fair"]) == {"verdict", "margin", "interval"} for one in found)
    assert mobo("claims", SAMPLES / "mobo_7", "--atlas", atlas, atlas) == 2
    assert "expected one atlas of 6 joints" in capsys.readouterr().err
    made_of = read_atlas(atlas)
    for trials, prefixes in ((1000, 3), (10, 0)):
        counts = np.full(len(made_of), trials)
        gains = np.full(len(made_of), 0.5)
        of = of_atlas(dataclasses.replace(made_of, trials_of_order=counts, expected_gain=gains))
        assert of.fair and sum(one.known for one in of.prefixes.values()) >= prefixes
        assert prefixes or not any(one.known for one in of.prefixes.values())


@pytest.mark.parametrize(
    ("bags", "said"),
    [
        (("paper_6", "paper_6"), "of 6 joints as"),
        (("mobo_7", "paper_6"), "the study of 6 joints first"),
        (("paper_6", "nosuch"), "nosuch"),
    ],
)
def test_bags_that_do_not_fit_are_named(bags: tuple[str, str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    """In one line, exit code 2."""
    assert mobo("claims", *(SAMPLES / bag for bag in bags)) == 2
    error = capsys.readouterr().err
    assert said in error and len(error.splitlines()) == 1


def test_a_study_without_trials_or_of_five_joints_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """With what would do."""
    bag = run_study(tmp_path / "five", 2, settings=QUICK | {"space": {"n_joints": 5}})
    assert mobo("claims", bag) == 2
    assert "arms of 5 joints; expected a study of 6 or 7 joints" in capsys.readouterr().err
    bag = run_study(tmp_path / "none", 1, rejected={0})
    assert mobo("claims", bag) == 2
    assert "no complete trial" in capsys.readouterr().err


def test_reports_of_6_and_7_joints_lead_to_the_claims(tmp_path: Path) -> None:
    """The page that leads to both holds those that evaluate nothing; a study's own page those on it alone."""
    reports = []
    for name in ("paper_6", "mobo_7"):
        study = read_study(SAMPLES / name)
        table = study_table(study)
        reports.append(Report(tmp_path / name, study, table, []))
        drawn = list(CLAIMS_FIGURE.draw(study, table))
        own = [one["claim"] for one in CLAIMS_FIGURE.view.data(study, table)]  # type: ignore[union-attr]
        assert len(drawn) == 1
        assert own == [c.name for c in CLAIMS if c.needs == (table.n_joints,) and not c.evaluates]
    page = write_index(reports, tmp_path).read_text(encoding="utf-8")
    assert "Values of the two studies do not compare: spec: ik_mode" in page
    assert all(f"<td class=\"\">{claim.name}</td>" in page for claim in CLAIMS if not claim.evaluates)
    assert "data:image/png" in page
    write_index(reports[:1] * 2, tmp_path)
    assert "claims" not in (tmp_path / "index.html").read_text(encoding="utf-8")


def test_spearman_is_that_of_ranks() -> None:
    """Monotonic: 1; ties at their mean, against the textbook's formula of Pearson's on ranks."""
    x = np.array([3.0, 1.0, 2.0, 2.0, 5.0])
    assert spearman(x, np.exp(x)) == pytest.approx(1.0) and spearman(x, -x) == pytest.approx(-1.0)
    y = np.array([1.0, 1.0, 4.0, 3.0, 0.0])
    ranks = np.array([4, 1, 2.5, 2.5, 5]), np.array([2.5, 2.5, 5, 4, 1])
    assert spearman(x, y) == pytest.approx(np.corrcoef(*ranks)[0, 1])
