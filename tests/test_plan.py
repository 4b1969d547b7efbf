"""Which study a node's parameters mean, what becomes of bags of which nothing came, and a study's last line."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any

import pytest
from studies import run_study

from mobo_core.bag.blank import is_blank
from mobo_core.bag.collector import past_study
from mobo_core.bag.lock import LOCK_FILE
from mobo_core.bag.study_bag import StudyBag
from mobo_core.coordination.arguments import check_arguments
from mobo_core.coordination.closing import closing_line, go_on_command
from mobo_core.coordination.dispatch import Dispatcher
from mobo_core.coordination.optimizer import Optimizer
from mobo_core.coordination.options import EvaluatorOptions, OptimizerOptions, StudyOptions
from mobo_core.coordination.plan import plan_study, total_trials
from mobo_core.errors import InputError
from mobo_core.messages import EvaluatorStatus, StudyStatus, encode
from mobo_core.search.study import StudySettings
from mobo_core.version import __version__

SEVEN: dict[str, Any] = {
    "space": {"n_joints": 7, "lengths": "sequential", "motor_mass": 0.7}, "spec": {"poses_per_voxel": 3},
    "sampler": "random", "seed": 4, "in_flight": 5, "n_startup_trials": 9,
}  # fmt: skip


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study of 7 joints whose optimizer was killed after 12 of 40 trials."""
    return run_study(tmp_path_factory.mktemp("plan") / "s", 40, name="s", settings=SEVEN, kill_after=12)


def options(**given: Any) -> OptimizerOptions:
    return OptimizerOptions.of({name: str(v) if isinstance(v, Path) else v for name, v in given.items()})


def test_resume_takes_what_is_not_named_from_the_bag(bag: Path) -> None:
    """Space, spec, sampler and all; the study's name too."""
    plan = plan_study(options(bag=bag, resume=True))
    assert plan.settings == StudySettings.of(SEVEN)
    assert (plan.name, plan.goes_on) == ("s", True)


def test_what_is_named_as_it_was_is_taken(bag: Path, tmp_path: Path) -> None:
    """From files too; a space file's joints that were named otherwise when the study began need no naming."""
    (tmp_path / "space.yaml").write_text("{motor_mass: 0.7}")
    (tmp_path / "spec.yaml").write_text("poses_per_voxel: 3")
    given = {"space": tmp_path / "space.yaml", "spec": tmp_path / "spec.yaml", "objectives": "reach,torque"}
    given |= {"study_name": "s", "n_joints": 7, "lengths": "sequential", "sampler": "random", "in_flight": 5}
    for name, value in given.items():
        assert plan_study(options(bag=bag, resume=True, **{name: value})).settings == StudySettings.of(SEVEN)
    assert plan_study(options(bag=bag, resume=True, **given)).settings == StudySettings.of(SEVEN)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"n_joints": 6}, "space.n_joints is 7 in the bag; expected 6, as asked for now"),
        ({"lengths": "fractions"}, "space.lengths is 'sequential'"),
        ({"sampler": "paper"}, "sampler is 'random'"),
        ({"sampler": "como"}, "sampler is 'random'"),
        ({"spec": "paper"}, "spec.poses_per_voxel is 3"),
        ({"space": ""}, "space.motor_mass is 0.7"),
        ({"objectives": "reach,mass"}, "objectives is ['reach', 'torque']"),
        ({"seed": 5, "in_flight": 4}, "seed is 4"),
        ({"study_name": "t"}, "holds study 's'; expected study 't'"),
        ({"spec": "nowhere.yaml"}, "nowhere.yaml"),
        ({"resume": False}, "exists already"),
    ],
)  # fmt: skip
def test_the_first_named_difference_is_refused(bag: Path, given: dict[str, Any], says: str) -> None:
    """In a line that names it, nothing touched."""
    before = {file.name: file.read_bytes() for file in bag.iterdir()}
    with pytest.raises(InputError) as error:
        plan_study(options(**{"bag": bag, "resume": True, **given}))
    assert says in str(error.value)
    assert {file.name: file.read_bytes() for file in bag.iterdir()} == before


def test_a_bag_that_is_not_there(tmp_path: Path) -> None:
    """resume:=true begins one, and says so; must_resume:=true does not."""
    new = options(bag=tmp_path / "none", resume=True, n_joints=5)
    plan = plan_study(new)
    assert not plan.goes_on and plan.settings.space.n_joints == 5
    assert str(tmp_path / "none") in plan.notice(new) and "new study" in plan.notice(new)
    with pytest.raises(InputError, match="no such bag"):
        plan_study(options(bag=tmp_path / "none", must_resume=True))
    assert not (tmp_path / "none").exists()


def test_must_resume_resumes(bag: Path) -> None:
    """Without resume:=true being named as well."""
    assert plan_study(options(bag=bag, must_resume=True)).goes_on


@pytest.mark.parametrize(
    ("given", "recorded", "told", "total"),
    [({}, 0, 0, 1000), ({}, 40, 12, 40), ({"n_trials": 60}, 40, 12, 60), ({"n_trials": 120}, 150, 150, 150)],
)
def test_the_total_is_the_bags_unless_named(given: dict[str, Any], recorded: int, told: int, total: int) -> None:
    """And never less than what is there."""
    assert total_trials(options(**given), recorded, told) == total


def begun(folder: Path, *, killed: bool, **more: Any) -> Path:
    """Begin a study, record that it runs, and end it."""
    bag = StudyBag(folder, "first", StudySettings.of({"seed": 1}), resume=False)
    bag.append("study", StudyStatus(study="first", state=StudyStatus.RUNNING, n_trials=77))
    if killed:
        assert bag._lock is not None
        bag._lock.release()
    else:
        bag.close()
    return folder


@pytest.mark.parametrize("killed", [True, False])
def test_a_bag_without_a_trial_does_not_block_its_name(tmp_path: Path, killed: bool) -> None:
    """Another study takes its place; resume still knows what it was to be."""
    folder = begun(tmp_path / "a", killed=killed)
    assert is_blank(folder) and past_study(folder).n_trials == 77
    assert plan_study(options(bag=folder, resume=True)).settings.seed == 1
    plan = plan_study(options(bag=folder, study_name="second", seed=2))
    assert not plan.goes_on
    run_study(folder, 5, name="second")
    assert len(past_study(folder).trials) == 5
    assert sorted(file.name for file in folder.iterdir()) == [LOCK_FILE, "a_0.mcap", "metadata.yaml"]


def test_what_people_put_there_is_never_blank(bag: Path, tmp_path: Path) -> None:
    """A file beside the bag, a bag with a candidate, an empty folder, a folder of something else."""
    assert not is_blank(bag) and not is_blank(tmp_path) and not is_blank(tmp_path / "none")
    folder = begun(tmp_path / "a", killed=True)
    (folder / "notes.txt").write_text("mine")
    assert not is_blank(folder)
    with pytest.raises(InputError, match="exists already"):
        plan_study(options(bag=folder))
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "b_0.mcap").write_text("not a bag")
    assert not is_blank(tmp_path / "b")


def test_the_last_line_of_a_stopped_study(bag: Path) -> None:
    """How far it came, where it is, and the command that goes on, which means this study."""
    given = StudyOptions.of({"bag": str(bag), "seed": 4, "evaluators": 3, "n_trials": 2000})
    status = StudyStatus(state=StudyStatus.STOPPED, asked=13, told=12, n_trials=2000)
    line = closing_line(status, bag, go_on_command(given, "s", "/left"))
    assert line.startswith(f"stopped at 12 of 2,000 trials, {bag}; go on: ros2 run mobo study --ros-args -r ")
    words = shlex.split(line.split("; go on: ")[1])
    check_arguments("study", words[4:], StudyOptions.model_fields)
    named = dict(word.split(":=", 1) for word in words if ":=" in word)
    assert named == {
        "__ns": "/left", "study_name": "s", "bag": str(bag), "evaluators": "3", "resume": "true",
    }  # fmt: skip


@pytest.mark.parametrize("heard", [None, StudyStatus(state=StudyStatus.RUNNING, told=3, n_trials=40)])
def test_without_a_last_word_the_bag_is_asked(bag: Path, heard: StudyStatus | None) -> None:
    """Of an optimizer that was killed."""
    assert closing_line(heard, bag, "…").startswith("stopped at 12" + (" of 40" if heard else "") + " trials")


def test_a_study_that_is_done_is_known_from_its_bag(tmp_path: Path) -> None:
    """With the same words as from the optimizer's last one."""
    last = []
    folder = run_study(tmp_path / "s", 20, meanwhile=lambda optimizer: bool(last.append(optimizer)))
    from_bag, from_optimizer = (
        closing_line(last[-1].status(state), folder, "") for state in (StudyStatus.RUNNING, StudyStatus.DONE)
    )
    assert from_bag.startswith("done: 20 trials, best reach") and from_bag == from_optimizer


def test_the_last_line_of_a_study_that_is_done(tmp_path: Path) -> None:
    """What came of it, and the report; names are quoted as a shell wants them."""
    folder = tmp_path / "my bag"
    folder.mkdir()
    status = StudyStatus(
        state=StudyStatus.DONE, asked=9, told=2000, failed=1, n_trials=2000, best_reach=53.94, front_size=12
    )
    assert closing_line(status, folder, "…") == (
        f"done: 2,000 trials, 1 of them failed, best reach 53.9, 12 arms on the front, {folder}; "
        f"next: mobo report '{folder}' -o report"
    )


def test_the_last_line_before_a_trial(tmp_path: Path) -> None:
    """Nothing hinders a new start."""
    for folder in (tmp_path / "none", begun(tmp_path / "a", killed=False)):
        assert closing_line(None, folder, "…").startswith("stopped before the first trial")


def test_a_machine_is_not_asked_for_more_than_it_can_bear() -> None:
    """Evaluators, workers and threads multiplied; simulated ones sleep."""
    EvaluatorOptions.of({"workers": 64}).check_load(cores=2)
    EvaluatorOptions.of({"workers": 1000, "engine": "simulated"}).check_load(cores=2)
    StudyOptions.of({"workers": 32, "threads": 2}).check_load(evaluators=1, cores=2)
    StudyOptions.of({"workers": 16, "threads": 4}).check_load(evaluators=4, cores=16)
    with pytest.raises(InputError, match="workers: 1000; expected at most 64 on 2 cores"):
        EvaluatorOptions.of({"workers": 1000}).check_load(cores=2)
    with pytest.raises(InputError, match="evaluators x workers: 3 x 32 = 96; expected at most 64 on 4 cores"):
        StudyOptions.of({"workers": 32}).check_load(evaluators=3, cores=4)


def test_an_evaluator_of_another_version_is_named_once(tmp_path: Path) -> None:
    """When it joins; one of this version without a word on it."""
    said: list[str] = []
    settings = StudySettings.of({"sampler": "random"})
    bag = StudyBag(tmp_path / "s", "s", settings, resume=False)
    warned: list[str] = []
    optimizer = Optimizer(
        bag, settings, 5, Dispatcher(), lambda topic, data: None, log=said.append, warn=warned.append
    )
    for now in (0.0, 1.0):
        for version in (__version__, "9.9", ""):
            status = EvaluatorStatus(evaluator=f"e{version}", workers=1, mobo_version=version, host_id="here")
            optimizer.on_evaluator(encode(status), now)
    bag.close()
    here = f", another than here ({__version__})"
    joined = [line for line in said + warned if " joined: " in line]
    assert len(warned) == 2  # a study shows them too
    assert [line.split("mobo ")[-1] for line in joined] == [__version__, f"9.9{here}", f"of an unknown version{here}"]
