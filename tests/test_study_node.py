"""Whole studies over ROS 2: real nodes, real messages, real signals."""

from __future__ import annotations

import hashlib
import json
import os
import shlex
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest
import yaml
from nodes import PATIENCE_S, QUICK_SPEC, Nodes, alive, children_of, finish, output, told_so_far, values, wait_for
from rosbags.highlevel import AnyReader
from studies import run_study

from mobo_core.bag.collector import read_study
from mobo_core.coordination.arguments import parameter_word

pytestmark = pytest.mark.ros

N = 40


def word_of(name: str, value: Any) -> str:
    return parameter_word(name, str(value) if isinstance(value, Path) else value)


def refused(nodes: Nodes, executable: str, cases: Sequence[Mapping[str, Any]]) -> list[str]:
    """Start a node in one process again and again, with these parameters; return the only line that each start said."""
    program = (
        "import json, sys\n"
        f"from mobo.{executable} import main\n"
        "for words in json.loads(sys.argv[1]):\n"
        "    sys.argv[1:] = words\n"
        "    print('ends with', main(), flush=True)\n"
    )
    words = [
        ["--ros-args", *(w for name, value in case.items() for w in ("-p", word_of(name, value)))]
        for case in cases
    ]
    command = [sys.executable, "-c", program, json.dumps(words)]
    done = subprocess.run(
        command, env=nodes.environment, cwd=nodes.folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        timeout=PATIENCE_S, check=False,
    )  # fmt: skip
    lines = [line for line in done.stdout.splitlines() if line]
    assert lines[1::2] == ["ends with 2"] * len(cases), done.stdout
    return lines[::2]


def test_trials_depend_neither_on_evaluators_nor_on_stops(nodes: Nodes, tmp_path: Path) -> None:
    """Three evaluators, then one of two workers for more trials: those of one go; rosbags reads each of them once."""
    settings = {"spec": yaml.safe_load(QUICK_SPEC), "n_startup_trials": 15, "sampler": "structured"}  # as nodes have it
    undisturbed = values(run_study(tmp_path / "undisturbed", N, name="s", engine="kernel", settings=settings))
    bag, others = tmp_path / "bag", {"n_startup_trials": 15}
    study = nodes.study(bag, n_trials=N - 12, evaluators=3, **others)
    assert finish(study) == 0, output(study)
    study = nodes.study(bag, n_trials=N, evaluators=1, workers=2, resume=True, **others)
    assert finish(study) == 0, output(study)
    assert values(bag) == undisturbed
    again = nodes.optimizer(bag, n_trials=N, resume=True, **others)  # nobody is needed
    assert finish(again) == 0, output(again)
    assert values(bag) == undisturbed
    with AnyReader([bag]) as reader:
        told = [
            reader.deserialize(data, connection.msgtype).trial
            for connection, _, data in reader.messages()
            if connection.topic == "/trials"
        ]
        topics = {name: info.msgcount for name, info in reader.topics.items()}
    assert told == list(range(N))
    assert topics["/candidates"] >= N
    assert topics["/evaluations"] >= N


def _digest(folder: Path) -> str:
    return hashlib.sha256(
        b"".join(path.name.encode() + path.read_bytes() for path in sorted(folder.iterdir()))
    ).hexdigest()


def test_existing_bag_is_refused_and_not_touched(nodes: Nodes, tmp_path: Path) -> None:
    bag = run_study(tmp_path / "bag", 4, name="s", settings={"spec": yaml.safe_load(QUICK_SPEC), "sampler": "random"})
    before = _digest(bag)
    given = {"bag": bag, "study_name": "s", "n_trials": 8, "sampler": "random", "spec": nodes.spec}
    cases: dict[str, dict[str, Any]] = {
        "exists already": {},
        "seed": {"resume": True, "seed": 1},
        "holds study 's'": {"resume": True, "study_name": "other"},
        "baselines is '' in the bag": {"resume": True, "baselines": "known"},
    }
    lines = refused(nodes, "optimizer", [given | case for case in cases.values()])
    for line, says in zip(lines, cases, strict=True):
        assert says in line
    (line,) = refused(nodes, "study", [given | {"resume": True, "baselines": "known"}])
    assert line.startswith("mobo study: ") and "baselines is '' in the bag" in line
    assert _digest(bag) == before


def test_bad_parameters_are_refused_in_one_line(nodes: Nodes, tmp_path: Path) -> None:
    """What is wrong is named, also of a bag that cannot be; nothing is made."""
    (tmp_path / "file").write_text("text")
    cases: dict[str, dict[str, Any]] = {
        "a whole number": {"n_trials": "many"},
        "from 1": {"n_trials": 0},
        "unknown parameter": {"n_trails": 5},
        "'tpe'": {"sampler": "best"},
        "paper_fine": {"spec": "papers"},
        "nowhere.yaml": {"space": "nowhere.yaml"},
        "sequential": {"lengths": "long"},
        "from 0 to 2^63 - 1": {"seed": -1},
        "no such bag": {"must_resume": True},
        f"{tmp_path / 'file'}: Not a directory": {"bag": tmp_path / "file", "resume": True},
        "/proc/none/bag: No such file": {"bag": "/proc/none/bag", "resume": True},
        f"{tmp_path}: not a bag": {"bag": tmp_path, "resume": True},
    }
    lines = refused(nodes, "optimizer", [{"bag": tmp_path / "bag", **case} for case in cases.values()])
    for line, says in zip(lines, cases, strict=True):
        assert line.startswith("mobo optimizer: ") and says in line, (says, line)
    assert not (tmp_path / "bag").exists()


def test_a_study_checks_everything_before_it_starts_anything(nodes: Nodes, tmp_path: Path) -> None:
    """One line, from the study node itself."""
    cases: dict[str, dict[str, Any]] = {
        "from 1": {"evaluators": -1},
        "'kernel', 'reference' or 'simulated'": {"engine": "gpu"},
        "'tpe'": {"sampler": "best"},
        "paper_fine": {"spec": "papers"},
        "2 x 1000 = 2000": {"workers": 1000},
    }
    lines = refused(nodes, "study", [{"bag": tmp_path / "bag", **case} for case in cases.values()])
    for line, says in zip(lines, cases, strict=True):
        assert line.startswith("mobo study: ") and says in line, (says, line)
    assert not (tmp_path / "bag").exists()


def test_a_dead_evaluator_is_replaced_and_ctrl_c_leaves_a_usable_bag_and_no_process(
    nodes: Nodes, tmp_path: Path
) -> None:
    bag, simulated = tmp_path / "bag", {"engine": "simulated", "simulated_s": 0.1}
    study = nodes.study(bag, n_trials=100_000, sampler="random", evaluators=2, **simulated)
    wait_for(lambda: told_so_far(bag) >= 5, "5 trials")
    names = {pid: Path(f"/proc/{pid}/cmdline").read_bytes() for pid in children_of(study.pid)}
    dead, _ = [pid for pid, name in names.items() if b"mobo.evaluator" in name]
    os.kill(dead, signal.SIGKILL)
    wait_for(lambda: len({e.evaluator for e in read_study(bag).evaluations}) == 3, "answers of another")
    family = children_of(study.pid)
    assert len(family) == 5 and dead not in family  # optimizer, two evaluators, a worker each
    study.send_signal(signal.SIGINT)
    assert finish(study) == 1
    assert not [pid for pid in family if alive(pid)]
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
    wait_for(lambda: not [pid for pid in family if alive(pid)], "all children to end")
    assert not read_study(bag).faults  # the optimizer had the time to finish its bag


def test_ros2_run_and_help(nodes: Nodes) -> None:
    for executable in ("optimizer", "evaluator", "study", "replay", "control"):
        command = ["ros2", "run", "mobo", executable, "--help"]
        done = subprocess.run(command, env=nodes.environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0
        assert f"ros2 run mobo {executable}" in done.stdout
