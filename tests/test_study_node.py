"""Whole studies over ROS 2: real nodes, real messages, real signals."""

from __future__ import annotations

import hashlib
import os
import shlex
import signal
import subprocess
from pathlib import Path

import pytest
from nodes import Nodes, children_of, finish, output, told_so_far, values, wait_for
from rosbags.highlevel import AnyReader

from mobo_core.bag.collector import read_study

pytestmark = [pytest.mark.ros, pytest.mark.timeout(240)]

N = 40


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> list[tuple[object, ...]]:
    """The trials of the study that all others here must equal."""
    from nodes import own_domain

    folder = tmp_path_factory.mktemp("undisturbed")
    with own_domain() as environment:
        nodes = Nodes(environment, folder)
        study = nodes.study(folder / "bag", n_trials=N, n_startup_trials=15, evaluators=1)
        assert finish(study) == 0, output(study)
        return values(folder / "bag")


@pytest.mark.parametrize(("evaluators", "workers"), [(1, 2), (3, 1)])
def test_trials_do_not_depend_on_evaluators(
    nodes: Nodes, tmp_path: Path, undisturbed: list[object], evaluators: int, workers: int
) -> None:
    bag = tmp_path / "bag"
    study = nodes.study(bag, n_trials=N, n_startup_trials=15, evaluators=evaluators, workers=workers)
    assert finish(study) == 0, output(study)
    assert values(bag) == undisturbed


def test_bag_reads_with_rosbags_and_holds_each_trial_once(nodes: Nodes, tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    assert finish(nodes.study(bag, n_trials=12, sampler="random")) == 0
    with AnyReader([bag]) as reader:
        told = [
            reader.deserialize(data, connection.msgtype).trial
            for connection, _, data in reader.messages()
            if connection.topic == "/trials"
        ]
        topics = {name: info.msgcount for name, info in reader.topics.items()}
    assert told == list(range(12))
    assert topics["/candidates"] >= 12
    assert topics["/evaluations"] >= 12


def test_evaluator_killed_midway_changes_nothing(nodes: Nodes, tmp_path: Path, undisturbed: list[object]) -> None:
    bag = tmp_path / "bag"
    optimizer = nodes.optimizer(bag, n_trials=N, n_startup_trials=15)
    evaluators = [nodes.start("evaluator", workers=1) for _ in range(2)]
    wait_for(lambda: told_so_far(bag) >= 8, "8 trials")
    # Stopped first, so that it surely holds a candidate when it dies.
    evaluators[0].send_signal(signal.SIGSTOP)
    wait_for(lambda: told_so_far(bag) >= 9 or optimizer.poll() is not None, "another trial")
    evaluators[0].kill()
    assert finish(optimizer) == 0, output(optimizer)
    assert values(bag) == undisturbed


def test_more_trials_later_are_the_trials_of_one_go(nodes: Nodes, tmp_path: Path, undisturbed: list[object]) -> None:
    bag = tmp_path / "bag"
    assert finish(nodes.study(bag, n_trials=N - 12, n_startup_trials=15)) == 0
    assert finish(nodes.study(bag, n_trials=N, n_startup_trials=15, resume=True)) == 0
    assert values(bag) == undisturbed
    again = nodes.optimizer(bag, n_trials=N, n_startup_trials=15, resume=True)  # nobody is needed
    assert finish(again) == 0, output(again)
    assert values(bag) == undisturbed


def _digest(folder: Path) -> str:
    return hashlib.sha256(
        b"".join(path.name.encode() + path.read_bytes() for path in sorted(folder.iterdir()))
    ).hexdigest()


def test_existing_bag_is_refused_and_not_touched(nodes: Nodes, tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    assert finish(nodes.study(bag, n_trials=4, sampler="random")) == 0
    before = _digest(bag)
    for parameters, says in (
        ({}, "exists already"),
        ({"resume": True, "seed": 1}, "seed"),
        ({"resume": True, "study_name": "other"}, "holds study 's'"),
    ):
        optimizer = nodes.optimizer(bag, **{"n_trials": 8, "sampler": "random", **parameters})
        assert finish(optimizer) == 2
        lines = [line for line in output(optimizer).splitlines() if line]
        assert len(lines) == 1 and says in lines[0], lines
        assert _digest(bag) == before


def test_bag_that_cannot_be_is_refused(nodes: Nodes, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("text")
    for bag, says in (
        (tmp_path / "file", "Not a directory"),
        (Path("/proc/none/bag"), "No such file"),
        (tmp_path, "not a bag"),
    ):
        optimizer = nodes.optimizer(bag, n_trials=4, resume=True)
        assert finish(optimizer) == 2
        lines = [line for line in output(optimizer).splitlines() if line]
        assert len(lines) == 1 and says in lines[0] and str(bag) in lines[0], lines


def test_ctrl_c_leaves_a_usable_bag_and_no_process(nodes: Nodes, tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    study = nodes.study(bag, n_trials=100_000, sampler="random", evaluators=2)
    wait_for(lambda: told_so_far(bag) >= 5, "5 trials")
    family = children_of(study.pid)
    assert len(family) == 5  # optimizer, two evaluators, a worker each
    study.send_signal(signal.SIGINT)
    assert finish(study, 20) == 1
    assert not [pid for pid in family if Path(f"/proc/{pid}").exists()]
    with AnyReader([bag]) as reader:
        assert reader.topics["/trials"].msgcount >= 5
    assert not read_study(bag).faults
    last = output(study).splitlines()[-1]
    assert f"stopped at {told_so_far(bag)} of 100,000 trials, {bag}; go on: ros2 run mobo study --ros-args " in last


def test_resume_of_a_study_whose_files_are_gone(nodes: Nodes, tmp_path: Path) -> None:
    """The command that its last line names goes on with its spec, its space and its total."""
    space, bag = tmp_path / "space.yaml", tmp_path / "bags" / "seven"
    space.write_text("{n_joints: 7, total_length: 0.7}")
    first = nodes.start(
        "study", study_name="seven", n_trials=30, sampler="random", space=space, spec=nodes.spec, evaluators=1,
        engine="simulated", simulated_s=0.3, workers=1,
    )  # fmt: skip
    wait_for(lambda: told_so_far(bag) >= 2, "2 trials")
    first.send_signal(signal.SIGTERM)
    assert finish(first) == 1
    space.unlink()
    nodes.spec.unlink()
    command = output(first).splitlines()[-1].split("; go on: ")[1]
    second = nodes.start("study", arguments=shlex.split(command)[5:], simulated_s=0.0)
    assert finish(second) == 0, output(second)
    assert len(read_study(bag).trials) == 30
    last = output(second).splitlines()[-1]
    assert "done: 30 trials, best reach " in last and last.endswith("next: mobo report bags/seven -o report")


def test_killed_study_leaves_no_process(nodes: Nodes, tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    study = nodes.study(bag, n_trials=100_000, sampler="random", evaluators=2)
    wait_for(lambda: told_so_far(bag) >= 3, "3 trials")
    family = children_of(study.pid)
    assert len(family) == 5
    study.kill()
    wait_for(lambda: not [pid for pid in family if Path(f"/proc/{pid}").exists()], "all children to end", 20)
    assert not read_study(bag).faults  # the optimizer had the time to finish its bag


def test_study_restarts_a_dead_evaluator(nodes: Nodes, tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    study = nodes.study(bag, n_trials=30, sampler="random", evaluators=1, engine="simulated", simulated_s=0.1)
    wait_for(lambda: told_so_far(bag) >= 3, "3 trials")
    names = {pid: Path(f"/proc/{pid}/cmdline").read_bytes() for pid in children_of(study.pid)}
    (evaluator,) = [pid for pid, name in names.items() if b"mobo.evaluator" in name]
    os.kill(evaluator, signal.SIGKILL)
    assert finish(study) == 0, output(study)
    assert len({e.evaluator for e in read_study(bag).evaluations}) == 2


def test_ros2_run_and_help(nodes: Nodes) -> None:
    for executable in ("optimizer", "evaluator", "study", "replay", "control"):
        command = ["ros2", "run", "mobo", executable, "--help"]
        done = subprocess.run(command, env=nodes.environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0
        assert f"ros2 run mobo {executable}" in done.stdout


@pytest.mark.parametrize(
    ("parameter", "value", "says"),
    [
        ("n_trials", "many", "a whole number"),
        ("n_trials", 0, "from 1"),
        ("n_trails", 5, "unknown parameter"),
        ("sampler", "best", "'tpe'"),
        ("spec", "papers", "paper_fine"),
        ("space", "nowhere.yaml", "nowhere.yaml"),
        ("lengths", "long", "sequential"),
        ("evaluators", -1, "from 1"),
        ("seed", -1, "from 0 to 2^63 - 1"),
        ("must_resume", True, "no such bag"),
    ],
)
def test_bad_parameters_are_refused_in_one_line(
    nodes: Nodes, tmp_path: Path, parameter: str, value: object, says: str
) -> None:
    executable = "study" if parameter == "evaluators" else "optimizer"
    node = nodes.start(executable, **{"bag": tmp_path / "bag", parameter: value})
    assert finish(node) == 2
    lines = [line for line in output(node).splitlines() if line]
    assert len(lines) == 1 and says in lines[0], lines
    assert not (tmp_path / "bag").exists()


@pytest.mark.parametrize(
    ("parameters", "says"),
    [
        ({"engine": "gpu"}, "'kernel', 'reference' or 'simulated'"),
        ({"sampler": "best"}, "'tpe'"),
        ({"spec": "papers"}, "paper_fine"),
        ({"workers": 1000}, "2 x 1000 = 2000"),
    ],
)
def test_a_study_checks_everything_before_it_starts_anything(
    nodes: Nodes, tmp_path: Path, parameters: dict[str, object], says: str
) -> None:
    """One line, from the study node itself."""
    study = nodes.start("study", **{"bag": tmp_path / "bag", **parameters})
    assert finish(study) == 2
    (line,) = [line for line in output(study).splitlines() if line]
    assert line.startswith("mobo study: ") and says in line
    assert not (tmp_path / "bag").exists()
