"""What an arm is worth: scores, their bits, the audit, and the kernel that is compiled once."""

from __future__ import annotations

import dataclasses
import fcntl
import hashlib
import json
import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from arms import HANDED_ARM, LENGTHS, arm, random_arm, small_spec

from mobo_core.errors import InputError
from mobo_core.evaluation import PRESETS, EvaluationSpec
from mobo_core.evaluation import evaluate as evaluate_module
from mobo_core.evaluation.audit import Audit
from mobo_core.evaluation.chain import Array, Chain, chain_from_urdf
from mobo_core.evaluation.evaluate import Configurations, Result, evaluate
from mobo_core.evaluation.kernel import CACHE
from mobo_core.evaluation.kernel.load import is_compiled
from mobo_core.evaluation.reference import ReferenceModel
from mobo_core.jit.cache import Cache
from mobo_core.jit.numerics import STREAM_AUDIT, pick

PAPER = EvaluationSpec()
PRRYPY = arm("PRRYPY")


def bits(result: Result) -> dict[str, Any]:
    """Return all that must not depend on how a result was computed."""
    values = {f.name: getattr(result, f.name) for f in dataclasses.fields(result) if f.name != "seconds"}
    configurations = values.pop("configurations")
    if configurations is not None:
        values |= {f"configuration {name}": array for name, array in vars(configurations).items()}
    return {
        name: (str(v.dtype), v.shape, v.tobytes()) if isinstance(v, np.ndarray) else v for name, v in values.items()
    }


def fingerprint() -> str:
    """Return a hash of everything that the evaluation of several arms gives."""
    text = hashlib.sha256()
    for urdf, tip, values in (
        (PRRYPY, "", {}),
        (PRRYPY, "", PRESETS["mobo"]),
        (arm("YPPYPY"), "", {"solution": "least_torque", "payload_kg": 0.7, "seed": 2**63 - 1}),
        (arm("YPPRPP", (0.1,) * 6, link_radius=0.03, joint_limit=3.0), "", {"gravity": (1.0, 2.0, -9.0)}),
        (random_arm(1), "flange", {"self_collision": False}),
    ):
        result = evaluate(urdf, small_spec(**values), tip=tip, configurations=True)
        text.update(repr(sorted(bits(result).items())).encode())
    return text.hexdigest()


def test_known_values() -> None:
    """The paper's question gives, on this machine too, the bits it gave when this test was written."""
    result = evaluate(PRRYPY, PAPER)
    assert (result.reach, result.torque) == (48.300000000000004, 334.30186800562905)
    assert (result.attempts, result.iterations) == (7414, 308898)


def test_nothing_beyond_the_arm_is_reached() -> None:
    """Voxels farther away than the arm is long and the tolerance are out of range at once, and cost nothing."""
    spec = EvaluationSpec(workspace_min=(0.5, -0.5, 0.3), workspace_max=(0.9, 0.5, 0.7))
    result = evaluate(PRRYPY, spec)
    distance = np.linalg.norm(spec.voxel_centres(), axis=1)
    assert distance.min() > 0.601
    assert (result.reach, result.torque, result.attempts, result.iterations) == (0, 0, 0, 0)
    assert result.out_of_range.tolist() == [30] * spec.n_voxels
    assert not result.voxel_torque.any()
    assert not result.voxel_torque_sd.any()


def test_full_stretch_is_in_range() -> None:
    """In the paper's grid 4 voxels are out of range for all poses, the 12 at exactly 0.6 m for none, and reached."""
    arm_of_two_links = arm("PRRYPY", (0.0, 0.3, 0.2, 0.1, 0.0, 0.0))
    result = evaluate(arm_of_two_links, PAPER)
    distance = np.linalg.norm(PAPER.voxel_centres(), axis=1)
    at_full_stretch = np.abs(distance - 0.6) < 1e-9
    assert at_full_stretch.sum() == 12
    assert result.out_of_range[distance > 0.61].tolist() == [30] * 4
    assert not result.out_of_range[distance < 0.61].any()
    assert result.voxel_reach[at_full_stretch].sum() > 8
    above = EvaluationSpec(workspace_min=(-0.1, -0.1, 0.5), workspace_max=(0.1, 0.1, 0.7), rotation_tolerance=math.pi)
    assert evaluate(PRRYPY, above).reach > 0.5  # straight up, any orientation


@pytest.mark.parametrize("joints", sorted(LENGTHS))
def test_counts_add_up(joints: str) -> None:
    """In every voxel the poses reached and those failed, by reason, make up all poses; totals are sums."""
    result = evaluate(arm(joints), PAPER, configurations=True)
    reached = result.voxel_reach * 30
    assert reached == pytest.approx(np.round(reached), abs=1e-12)
    failures = result.out_of_range + result.not_converged + result.in_collision
    assert np.array_equal(np.round(reached).astype(int) + failures, np.full(75, 30))
    assert result.reach == math.fsum(result.voxel_reach)
    assert result.torque == math.fsum(result.voxel_torque)
    assert np.all((result.voxel_torque > 0) == (result.voxel_reach > 0))
    assert result.attempts <= 6 * (75 * 30 - result.out_of_range.sum())
    assert 0 < result.iterations <= 50 * result.attempts


def test_configurations_are_those_the_scores_are_made_of() -> None:
    """They come on request, in order of voxel and pose, and give reach, mean torque and spread of each voxel."""
    assert evaluate(PRRYPY, PAPER).configurations is None
    result = evaluate(PRRYPY, PAPER, configurations=True)
    found = result.configurations
    assert found is not None
    assert found.q.shape == (len(found.voxel), 6)
    where = list(zip(found.voxel, found.pose, strict=True))
    assert where == sorted(set(where))
    for voxel in range(75):
        torque = found.torque[found.voxel == voxel]
        assert len(torque) / 30 == result.voxel_reach[voxel]
        if len(torque):
            assert result.voxel_torque[voxel] == pytest.approx(torque.mean(), rel=1e-13)
            assert result.voxel_torque_sd[voxel] == pytest.approx(torque.std(), rel=1e-9, abs=1e-13)


@pytest.mark.parametrize(("urdf", "tip"), [(PRRYPY, ""), (HANDED_ARM, "tcp")])
def test_same_bits_however_it_is_computed(urdf: str, tip: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The result is the same to the bit again, with 1, 2 or 3 threads, and in chunks of any size."""
    expected = bits(evaluate(urdf, PAPER, tip=tip, configurations=True))
    for threads in (1, 2, 3, 200):
        assert bits(evaluate(urdf, PAPER, tip=tip, configurations=True, threads=threads)) == expected, threads
    for chunk in (1, 100, 30 * 74, 30 * 75, 10**9):
        monkeypatch.setattr(evaluate_module, "_CHUNK_POSES", chunk)
        assert bits(evaluate(urdf, PAPER, tip=tip, configurations=True)) == expected, chunk
        assert bits(evaluate(urdf, PAPER, tip=tip, configurations=True, threads=2)) == expected, chunk


def test_chunks_of_the_reference() -> None:
    """The reference engine gives the same bits in chunks of any size."""
    spec = small_spec(poses_per_voxel=2, restarts=1)
    expected = bits(evaluate(PRRYPY, spec, engine="reference", configurations=True))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(evaluate_module, "_CHUNK_POSES", 5)
        assert bits(evaluate(PRRYPY, spec, engine="reference", configurations=True)) == expected


def test_progress() -> None:
    """Progress tells the voxels done and the voxels in all, and ends with all."""
    told: list[tuple[int, int]] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(evaluate_module, "_CHUNK_POSES", 600)
        evaluate(PRRYPY, PAPER, progress=lambda done, total: told.append((done, total)))
    assert told == [(20, 75), (40, 75), (60, 75), (75, 75)]


@pytest.mark.parametrize("joints", ["PRRYPY", "YPYPYPR"])
def test_least_torque(joints: str) -> None:
    """The solution of least torque reaches the same poses as the first one, none at more torque, some at less."""
    first = evaluate(arm(joints), PAPER, configurations=True)
    least = evaluate(arm(joints), EvaluationSpec(solution="least_torque"), configurations=True)
    assert first.configurations is not None
    assert least.configurations is not None
    assert np.array_equal(least.voxel_reach, first.voxel_reach)
    assert np.all(least.configurations.torque <= first.configurations.torque)
    assert np.all(least.voxel_torque <= first.voxel_torque)
    assert least.torque < 0.97 * first.torque
    assert least.attempts > first.attempts


def test_without_self_collision() -> None:
    """With self-collision allowed no voxel is reached less, and no pose fails for it."""
    urdf = arm("YPPRPP", (0.1,) * 6, link_radius=0.03, joint_limit=3.0)
    on, off = evaluate(urdf, PAPER), evaluate(urdf, EvaluationSpec(self_collision=False))
    assert on.in_collision.sum() > 20
    assert off.in_collision.sum() == 0
    assert np.all(off.voxel_reach >= on.voxel_reach)
    assert off.reach > on.reach
    assert off.attempts < on.attempts


def test_more_attempts_reach_more() -> None:
    """No voxel is reached less with more restarts: the first attempts stay the same."""
    reaches = [evaluate(PRRYPY, EvaluationSpec(restarts=n)).voxel_reach for n in (0, 1, 5, 12)]
    for fewer, more in zip(reaches, reaches[1:], strict=False):
        assert np.all(more >= fewer)
        assert more.sum() > fewer.sum() + 1


def test_wider_tolerances_reach_more() -> None:
    """With 5 mm and 5 degrees more is reached than with 1 and 1, in total."""
    wide = EvaluationSpec(position_tolerance=5e-3, rotation_tolerance=math.radians(5))
    assert evaluate(PRRYPY, wide).reach > evaluate(PRRYPY, PAPER).reach


def test_payload_and_gravity() -> None:
    """Weight changes torque alone: none without gravity, twice as much under twice of it, more with a payload."""
    plain = evaluate(PRRYPY, PAPER)
    floating = evaluate(PRRYPY, EvaluationSpec(gravity=(0, 0, 0)))
    heavy = evaluate(PRRYPY, EvaluationSpec(gravity=(0, 0, -19.62)))
    sideways = evaluate(PRRYPY, EvaluationSpec(gravity=(9.81, 0, 0)))
    loaded = evaluate(PRRYPY, EvaluationSpec(payload_kg=1.0))
    for other in (floating, heavy, sideways, loaded):
        assert np.array_equal(other.voxel_reach, plain.voxel_reach)
    assert floating.torque == 0
    assert heavy.torque == pytest.approx(2 * plain.torque, rel=1e-12)
    assert np.abs(sideways.voxel_torque - plain.voxel_torque).max() > 1
    assert loaded.torque > 1.2 * plain.torque
    assert np.all(loaded.voxel_torque_sd[loaded.voxel_reach == 0] == 0)


def test_seed_changes_the_poses() -> None:
    """Another seed asks for other poses, and scores differ a little."""
    first, second = (evaluate(PRRYPY, EvaluationSpec(seed=seed)) for seed in (0, 1))
    assert not np.array_equal(first.voxel_reach, second.voxel_reach)
    assert first.reach == pytest.approx(second.reach, abs=4)


def test_result_in_other_forms() -> None:
    """A result is one line, plain values that JSON takes, and a table of voxels with their centres."""
    spec = small_spec()
    result = evaluate(PRRYPY, spec, configurations=True, objectives=("mass",))
    assert repr(result) == (
        f"<Result: reach {result.reach:.2f} of 12 voxels, torque {result.torque:.1f} N m, mass 3.424; "
        "6 joints to 'tool'>"
    )
    values = json.loads(json.dumps(result.to_dict()))
    assert values["reach"] == result.reach and values["voxel_torque"] == result.voxel_torque.tolist()
    assert sum(values["failures"].values()) + 10 * values["reach"] == pytest.approx(120)
    assert values["extra"] == result.extra and "extra" not in evaluate(PRRYPY, spec).to_dict()
    table = result.to_pandas()
    assert np.array_equal(table[["x", "y", "z"]], spec.voxel_centres())
    assert table["reach"].sum() == pytest.approx(result.reach)
    found = result.configurations
    assert found is not None and f"{len(found.voxel)} of 6 joints" in repr(found)
    assert np.array_equal(found.to_pandas()[[f"q{i}" for i in range(1, 7)]], found.q)
    assert json.loads(json.dumps(found.to_dict()))["pose"] == found.pose.tolist()


def test_tables_need_pandas(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where pandas is not installed it says so in one line."""
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(InputError, match="pandas is not installed; expected pip install pandas"):
        evaluate(PRRYPY, small_spec(poses_per_voxel=1)).to_pandas()


def test_result_names_the_chain() -> None:
    """A result names joints and tip, and counts the shapes that were left out."""
    result = evaluate(HANDED_ARM, small_spec(poses_per_voxel=1), tip="tcp")
    assert (result.joints[0], len(result.joints), result.tip) == ("joint1", 7, "tcp")
    box = HANDED_ARM.replace(
        '<link name="tcp"/>',
        '<link name="tcp"><collision><geometry><box size="1 1 1"/></geometry></collision></link>',
    )
    assert evaluate(box, small_spec(poses_per_voxel=1), tip="tcp").ignored_shapes == 1
    with pytest.raises(InputError, match="no link 'hook'"):
        evaluate(HANDED_ARM, small_spec(), tip="hook")


def audit(chain: Chain, spec: EvaluationSpec, found: Configurations, count: int, number: int) -> tuple[int, float, str]:
    check = Audit(chain, spec, count, number)
    check.add(found)
    return check.result(spec.voxel_centres())


class TestAudit:
    """The check of accepted poses by Pinocchio and Coal."""

    spec = small_spec()
    chain = chain_from_urdf(PRRYPY)

    def configurations(self, **changes: Any) -> Configurations:
        found = evaluate(PRRYPY, self.spec, configurations=True).configurations
        assert found is not None
        return dataclasses.replace(found, **changes)

    def test_finds_nothing_wrong_with_the_kernel(self) -> None:
        """Every configuration of the kernel passes, its torque within 1e-9 N m."""
        found = self.configurations()
        checked, worst, fault = audit(self.chain, self.spec, found, 10**6, 0)
        assert (checked, fault) == (len(found.voxel), "")
        assert checked > 50
        assert 0 <= worst < 1e-9

    def test_number_of_poses(self) -> None:
        """As many different poses are checked as asked for, or all there are; none if none was accepted."""
        found = self.configurations()
        for number in range(40):
            assert audit(self.chain, self.spec, found, 8, number)[0] == 8
        assert evaluate(PRRYPY, self.spec, audit_poses=8).audit_poses == 8
        few = Configurations(found.voxel[:3], found.pose[:3], found.q[:3], found.torque[:3])
        assert audit(self.chain, self.spec, few, 8, 0)[0] == 3
        none = Configurations(found.voxel[:0], found.pose[:0], found.q[:0], found.torque[:0])
        assert audit(self.chain, self.spec, none, 8, 0) == (0, 0.0, "")

    def test_number_of_poses_in_many_parts(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """In parts of any size as many are checked as in one: 8, or all there are."""
        few = small_spec(poses_per_voxel=1, restarts=0)
        reached = round(evaluate(PRRYPY, few).reach)
        assert 0 < reached < 8
        for chunk in (1, 20, 40):
            monkeypatch.setattr(evaluate_module, "_CHUNK_POSES", chunk)
            assert evaluate(PRRYPY, self.spec, audit_poses=8).audit_poses == 8
            assert evaluate(PRRYPY, few, audit_poses=8).audit_poses == reached

    def test_no_configuration_is_favoured(self) -> None:
        """Over many numbers each configuration is chosen about as often, whichever part it comes in."""
        found = self.configurations()
        m = 30
        counts = np.zeros(m)
        for number in range(1000):
            check = Audit(self.chain, self.spec, 8, number)
            for low, high in ((0, 4), (4, 20), (20, m)):
                part = slice(low, high)
                check.add(Configurations(found.voxel[part], found.pose[part], found.q[part], found.torque[part]))
            chosen = {(one.voxel, one.pose) for one in check._chosen}
            assert len(chosen) == 8
            counts += [(v, p) in chosen for v, p in zip(found.voxel[:m], found.pose[:m], strict=True)]
        expected = 1000 * 8 / m
        chi_squared = np.sum((counts - expected) ** 2) / (expected * (1 - 8 / m))
        assert chi_squared < 62  # one in 3,000 for 29 degrees of freedom; the draw is fixed

    def test_one_part_is_chosen_from_as_ever(self) -> None:
        """Where all configurations come at once, the ones checked are the first 8 different draws among them."""
        found = self.configurations()
        for number in range(20):
            check = Audit(self.chain, self.spec, 8, number)
            check.add(found)
            draws = [pick(self.spec.seed, STREAM_AUDIT, number, k, len(found.voxel)) for k in range(30)]
            first = list(dict.fromkeys(draws))[:8]
            assert [(one.voxel, one.pose) for one in check._chosen] == [(found.voxel[i], found.pose[i]) for i in first]

    def test_other_trials_check_other_poses(self) -> None:
        """The poses depend on the number given: over many numbers each configuration is checked at some time."""
        found = self.configurations()
        for i in (0, len(found.voxel) // 2, len(found.voxel) - 1):
            torque = found.torque.copy()
            torque[i] += 1e-6
            wrong = dataclasses.replace(found, torque=torque)
            faults = [audit(self.chain, self.spec, wrong, 8, number)[2] for number in range(150)]
            assert any(faults)
            assert not all(faults)
            again = [audit(self.chain, self.spec, wrong, 8, number)[2] for number in range(20)]
            assert again == faults[:20]

    def fault(self, found: Configurations, spec: EvaluationSpec | None = None) -> tuple[float, str]:
        _, worst, fault = audit(self.chain, spec or self.spec, found, 10**6, 0)
        return worst, fault

    def changed(self, i: int, q: Array) -> Configurations:
        """Return the configurations with one replaced, its torque right."""
        found = self.configurations()
        found.q[i] = q
        found.torque[i] = np.linalg.norm(ReferenceModel(self.chain).torque(q))
        return found

    def test_finds_a_wrong_torque(self) -> None:
        """A torque off by 1e-8 N m is found, with voxel, pose and amount."""
        found = self.configurations()
        found.torque[5] += 1e-8
        worst, fault = self.fault(found)
        assert fault.startswith(f"audit: voxel {found.voxel[5]}, pose {found.pose[5]}: torque off by 1e-08")
        assert worst == pytest.approx(1e-8, rel=0.01)
        found.torque[5] = math.nan
        assert "torque off by nan" in self.fault(found)[1]

    def test_finds_a_tip_out_of_place(self) -> None:
        """A joint turned by 0.01 rad takes the tip out of its tolerance."""
        q = self.configurations().q[7].copy()
        q[0] += 0.01
        worst, fault = self.fault(self.changed(7, q))
        assert "m outside its tolerance" in fault
        assert 1e-3 < worst < 0.01

    def test_finds_a_tip_turned(self) -> None:
        """The last joint turned by 0.05 rad, which leaves the tip in its place, turns it out of its tolerance."""
        q = self.configurations().q[7].copy()
        q[5] += 0.05
        worst, fault = self.fault(self.changed(7, q))
        assert "tip turned" in fault
        assert 0.01 < worst < 0.07

    def test_finds_a_joint_beyond_its_limit(self) -> None:
        """The same configuration a whole turn on is beyond its limit, if by nothing else wrong."""
        q = self.configurations().q[7].copy()
        q[3] += 2 * math.pi if q[3] < 0 else -2 * math.pi
        _, fault = self.fault(self.changed(7, q))
        assert "beyond its limit" in fault

    def test_finds_a_collision(self) -> None:
        """A configuration in self-collision is found, unless the spec allows it."""
        urdf = arm("YPPRPP", (0.1,) * 6, link_radius=0.03, joint_limit=3.0)
        chain, allowing = chain_from_urdf(urdf), small_spec(self_collision=False, voxel_size=0.15)
        found = evaluate(urdf, allowing, configurations=True).configurations
        assert found is not None
        assert audit(chain, allowing, found, 10**6, 0)[2] == ""
        _, worst, fault = audit(chain, small_spec(voxel_size=0.15), found, 10**6, 0)
        assert "links overlap by" in fault
        assert 1e-4 < worst < 0.06

    def test_is_part_of_an_evaluation(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """An evaluation reports its audit, over all chunks."""
        monkeypatch.setattr(evaluate_module, "_CHUNK_POSES", 40)
        result = evaluate(PRRYPY, self.spec, audit_poses=9)
        assert (result.audit_poses, result.audit_fault) == (9, "")
        assert result.audit_max_error < 1e-9
        monkeypatch.setattr(Audit, "result", lambda *_: (9, 0.5, "audit: wrong"))
        result = evaluate(PRRYPY, self.spec, audit_poses=9)
        assert (result.audit_poses, result.audit_max_error, result.audit_fault) == (9, 0.5, "audit: wrong")


def start(code: str, **environment: str) -> subprocess.Popen[str]:
    path = os.pathsep.join([str(Path(__file__).parent), *filter(None, sys.path)])
    return subprocess.Popen(
        [sys.executable, "-c", code],
        env={**os.environ, "PYTHONPATH": path, **environment},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.mark.slow
def test_bits_of_the_plainest_processor(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is compiled for the plainest of processors gives, to the bit, what is compiled for this one."""
    plainest = {"MOBO_CACHE": str(tmp_path), "NUMBA_CPU_NAME": "x86-64-v2"}
    compiling = start("import test_evaluate; print(test_evaluate.fingerprint())", **plainest)
    expected = fingerprint()
    stdout, stderr = compiling.communicate()
    assert (compiling.returncode, stdout) == (0, expected + "\n"), stderr
    assert stderr == "mobo: compiling the evaluation kernel for 6 joints, once per machine …\n"
    for name, value in plainest.items():
        monkeypatch.setenv(name, value)
    assert is_compiled() and list(CACHE.folder().rglob("*evaluate_voxels*.nbc"))


_TINY = """
from mobo_core.jit.cache import Cache

CACHE = Cache("tiny", [__file__])


@CACHE.compiled
def half(x):
    return 0.5 * x


def main():
    print(CACHE.once("half of it", "part", lambda: half(1.0)))
"""


def test_two_processes_compile_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of two processes with an empty cache one compiles, both wait for whoever does, and say so."""
    (tmp_path / "tiny.py").write_text(_TINY)
    monkeypatch.setenv("MOBO_CACHE", str(tmp_path))
    cache = Cache("tiny", [tmp_path / "tiny.py"])
    run = f"import sys; sys.path.insert(0, {str(tmp_path)!r}); import tiny; tiny.main()"
    cache.folder().mkdir(parents=True)
    with (cache.folder() / "lock").open("a") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # as if a third process compiled
        both = [start(run) for _ in range(2)]
        said = [process.stderr.readline() if process.stderr else "" for process in both]
        assert not cache.is_complete("part")
    assert said == ["mobo: waiting for another process that compiles half of it …\n"] * 2
    ends = [process.communicate() for process in both]
    assert [(process.returncode, stdout) for process, (stdout, _) in zip(both, ends, strict=True)] == [(0, "0.5\n")] * 2
    assert sorted(stderr for _, stderr in ends) == ["", "mobo: compiling half of it, once per machine …\n"]
    assert cache.is_complete("part") and list(cache.folder().rglob("*half*.nbc"))
    assert start(run).communicate() == ("0.5\n", "")


def test_cache_folder_follows_what_is_compiled(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Another processor, Numba feature set or cache folder means another folder."""
    monkeypatch.setenv("MOBO_CACHE", str(tmp_path))
    folders = {CACHE.folder()}
    for name, value in (
        ("NUMBA_CPU_NAME", "x86-64-v2"),
        ("NUMBA_CPU_FEATURES", "+sse4.2"),
        ("MOBO_CACHE", "elsewhere"),
    ):
        monkeypatch.setenv(name, value)
        folders.add(CACHE.folder())
    assert len(folders) == 4
    monkeypatch.delenv("MOBO_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert CACHE.folder().parent == tmp_path / "xdg" / "mobo"


def test_numba_keeps_the_kernel_in_that_folder() -> None:
    """Every compiled function is kept in mobo's folder, which its sources name, not beside the sources."""
    code = (
        "from mobo_core.evaluation.kernel import CACHE, geometry, configuration, starts\n"
        "functions = [f for m in (configuration, geometry, starts) for f in vars(m).values() if hasattr(f, 'py_func')"
        " and f.__module__.startswith('mobo_core.evaluation.kernel')]\n"
        "assert len(functions) > 8\n"
        "places = {f.stats.cache_path for f in functions}\n"
        "print(all(p.startswith(str(CACHE.folder())) for p in places), places)\n"
    )
    output, errors = start(code).communicate()
    assert output.startswith("True"), output + errors


@pytest.mark.slow
def test_without_a_cache_folder(tmp_path: Path) -> None:
    """Where nothing can be kept, functions are compiled for the process alone, and it says so."""
    (tmp_path / "file").touch()
    code = (
        "from mobo_core.evaluation.kernel import load\n"
        "from mobo_core.jit import numerics\n"
        "load._load = lambda n: 'loaded'\n"  # which takes long
        "print(load.kernel(), numerics.sin_cos(0.0))\n"
    )
    output, errors = start(code, MOBO_CACHE=str(tmp_path / "file"), TMPDIR=str(tmp_path)).communicate()
    assert output == "loaded (0.0, 1.0)\n"
    assert errors.startswith("mobo: cannot keep the evaluation kernel for 6 joints compiled (Not a directory:")
    assert errors.count("\n") == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file"]  # and leaves no trace
