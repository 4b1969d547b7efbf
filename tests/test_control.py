"""Commands to a running study: recorded, in force, repeated by resume, checked by verify."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from nodes import PATIENCE_S, Nodes, control, finish, output, told_so_far, values, wait_for
from studies import mobo, run_study

from mobo_core.bag.collector import read_study
from mobo_core.coordination.control import Controls
from mobo_core.coordination.optimizer import Optimizer
from mobo_core.design import Design, DesignSpace
from mobo_core.errors import InputError

ARM = ("YPPYPY", (0.05, 0.25, 0.2, 0.05, 0.0, 0.05))
N = 24
TPE = {"sampler": "tpe", "n_startup_trials": 8, "in_flight": 4}


@given(
    mode=st.sampled_from(["fractions", "sequential"]),
    joints=st.text("RPY", min_size=1, max_size=12),
    shares=st.lists(st.floats(0, 1), min_size=11, max_size=11),
)
def test_parameters_of_any_arm_of_the_space_give_its_lengths(mode: str, joints: str, shares: list[float]) -> None:
    """To 1e-9 m, with lengths that touch their bounds and zero among them."""
    space = DesignSpace.of({"n_joints": len(joints), "lengths": mode})
    lengths: list[float] = []
    for share in shares[: len(joints) - 1]:
        lengths.append(share * min(space.max_length, max(0.0, space.total_length - sum(lengths))))
    lengths.append(max(0.0, space.total_length - sum(lengths)))
    params = json.loads(json.dumps(space.params(Design(joints, tuple(lengths)))))
    design = space.design(params)
    assert design.sampled_joints == joints
    assert design.lengths == pytest.approx(lengths, abs=1e-9)
    space.distributions(params)


@pytest.mark.parametrize(
    ("joints", "lengths", "says"),
    [
        ("YPPYP", (0.1, 0.1, 0.1, 0.1, 0.2), "5 joints"),
        ("YPPYPX", ARM[1], "'X'"),
        ("YPPYPY", (0.05, 0.25, 0.2, 0.05, 0.0, 0.06), "add up to 0.61"),
        ("YPPYPY", (0.31, 0.05, 0.09, 0.05, 0.05, 0.05), "at most 0.3"),
        ("YPPYPY", (0.3, 0.3, 0.1, -0.1, 0.0, 0.0), "-0.1"),
        ("YPPYPY", (0.1, 0.5), "2 lengths"),
    ],
)
def test_arms_outside_the_space_are_refused(joints: str, lengths: tuple[float, ...], says: str) -> None:
    """Nothing is recorded, and the reply says why."""
    recorded: list[Any] = []
    reply = Controls("s", DesignSpace(), recorded.append).enqueue(0, "me", joints, lengths, N)
    assert not reply.accepted and reply.bad_input and says in reply.message
    assert not recorded


def test_commands_are_recorded_before_they_are_in_force() -> None:
    """At the moment of recording nothing has changed; what cannot be recorded does not happen."""
    def record(command: Any) -> None:
        seen.append((command.command, command.trial, command.source, controls.paused, controls.stopped))
        if full:
            raise OSError("no room")

    seen: list[Any] = []
    full = False
    controls = Controls("s", DesignSpace(), record)
    assert controls.pause(3, "me").trial == 3 and controls.paused
    assert not controls.pause(3, "me").accepted
    assert controls.resume(3, "you").accepted and not controls.paused
    assert not controls.resume(3, "you").accepted
    full = True
    with pytest.raises(OSError):
        controls.stop(4, "me")
    assert not controls.stopped
    assert [(name, trial) for name, trial, *_ in seen] == [("pause", 3), ("resume", 3), ("stop", 4)]
    assert [tuple(rest) for _, _, *rest in seen] == [("me", False, False), ("you", True, False), ("me", False, False)]


def _enqueue_at(told: int, *, kill: bool = False) -> Any:
    """Return what enqueues two arms once ``told`` trials are told, and then kills the optimizer or lets it go on."""
    done: list[bool] = []

    def meanwhile(optimizer: Optimizer) -> bool:
        if done or len(optimizer.study.told) < told:
            return False
        done.append(True)
        for joints in ("YPPYPY", "PRRYPY"):
            reply = optimizer.controls.enqueue(len(optimizer.study.asked), "me", joints, ARM[1], optimizer.n_trials)
            assert reply.accepted, reply
        return kill

    return meanwhile


@pytest.mark.slow
@pytest.mark.parametrize("lengths", ["fractions", "sequential"])
def test_enqueued_arms_are_trials_and_part_of_the_function(tmp_path: Path, lengths: str) -> None:
    """Killed between the command's record and the candidate's, resumed: the same trials; verify accepts them."""
    settings = {**TPE, "space": {"lengths": lengths}}
    whole = run_study(tmp_path / "whole", N, settings=settings, meanwhile=_enqueue_at(8))
    killed = run_study(tmp_path / "killed", N, name="study", settings=settings, meanwhile=_enqueue_at(8, kill=True))
    commands = read_study(killed).commands
    assert [(c.command, c.source) for c in commands] == [("enqueue", "me")] * 2
    first = commands[0].trial
    assert read_study(killed).candidate_of(first) is None  # killed before
    run_study(killed, N, settings=settings, resume=True)
    assert values(killed) == values(whole)
    for trial, joints in ((first, "YPPYPY"), (first + 1, "PRRYPY")):
        candidate = read_study(whole).candidate_of(trial)
        assert candidate.sampled_joints == joints
        assert candidate.lengths == pytest.approx(ARM[1], abs=1e-9)
    plain = run_study(tmp_path / "plain", N, settings=settings)
    assert values(plain)[:first] == values(whole)[:first]
    assert values(plain)[first + 4 :] != values(whole)[first + 4 :]  # the sampler learns from them


@pytest.mark.slow
def test_verify_accepts_enqueued_arms_and_no_others(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A command whose parameters, trial or lengths were changed is found."""
    from test_verify import tampered

    settings = {"spec": {"poses_per_voxel": 1, "restarts": 0, "iterations": 5}, "sampler": "random", "in_flight": 4}
    bag = run_study(tmp_path / "bag", 16, settings=settings, meanwhile=_enqueue_at(6))
    assert mobo("verify", "--sample", 0, bag) == 0, capsys.readouterr().err

    def lengths(command: Any) -> None:
        command.arguments_json = command.arguments_json.replace("0.25", "0.24")

    def later(command: Any) -> None:
        command.trial += 5

    def params(command: Any) -> None:
        arguments = json.loads(command.arguments_json)
        arguments["params"]["J1"] = "R"
        command.arguments_json = json.dumps(arguments)

    def torn(command: Any) -> None:
        command.arguments_json = "{"

    for change in (lengths, later, params, torn):
        bad = tampered(bag, tmp_path / change.__name__, "Command", change, which=1)
        assert mobo("verify", "--sample", 0, bad) == 1
        assert "command" in capsys.readouterr().err or change is later


def test_enqueue_when_every_trial_is_asked_is_refused() -> None:
    """Counting those that are enqueued already."""
    controls = Controls("s", DesignSpace(), lambda command: None)
    assert [controls.enqueue(8, "me", *ARM, 10).accepted for _ in range(3)] == [True, True, False]
    assert not controls.enqueue(10, "me", *ARM, 10).bad_input


@pytest.mark.slow
def test_pause_outlives_the_optimizer_and_stop_does_not(tmp_path: Path) -> None:
    """Resumed, a paused study is paused: nothing is asked or sent, what was sent is told; `resume` lifts it."""
    def at(told: int, command: str) -> Any:
        def meanwhile(optimizer: Optimizer) -> bool:
            if len(optimizer.study.told) < told:
                return False
            assert getattr(optimizer.controls, command)(len(optimizer.study.asked), "me").accepted
            return True

        return meanwhile

    bag = run_study(tmp_path / "bag", N, meanwhile=at(5, "stop"))
    run_study(bag, N, resume=True, meanwhile=at(10, "pause"))
    before = len(read_study(bag).candidates)
    rounds: list[int] = []

    def wait(optimizer: Optimizer) -> bool:
        assert optimizer.controls.paused and not optimizer.controls.stopped
        rounds.append(len(optimizer.study.told))
        if len(rounds) == 20:
            assert optimizer.controls.resume(len(optimizer.study.asked), "me").accepted
            return True
        return False

    run_study(bag, N, resume=True, meanwhile=wait)
    assert len(read_study(bag).candidates) == before
    run_study(bag, N, resume=True)
    assert values(bag) == values(run_study(tmp_path / "plain", N))


def test_a_command_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    """Resume of a bag with a damaged enqueue ends in one line."""
    from mobo_core.messages import Command

    command = Command(trial=9, command="enqueue", arguments_json="[]")
    with pytest.raises(InputError, match="enqueue of trial 9"):
        Controls("s", DesignSpace(), lambda c: None).repeat([command], 3)


@pytest.mark.ros
def test_commands_over_ros(nodes: Nodes, tmp_path: Path) -> None:
    """Pause, enqueue, status, resume and stop a study, killed in between; its bag holds the commands and verifies.

    Meanwhile one who commands an empty namespace is told so in one line, with exit code 1.
    """
    bag = tmp_path / "bag"
    command = [sys.executable, "-m", "mobo.control", "pause", "--ros-args", "-r", "__ns:=/nobody"]
    lonely = subprocess.Popen(command, env=nodes.environment, stderr=subprocess.PIPE, text=True)
    optimizer = nodes.optimizer(bag, n_trials=100_000, sampler="random", in_flight=2)
    # As many workers as trials in flight: what is asked is sent.
    nodes.start("evaluator", workers=2, engine="simulated", simulated_s=0.02)
    wait_for(lambda: told_so_far(bag) >= 3, "3 trials")
    assert "paused" in control(nodes.environment, "pause")
    wait_for(lambda: told_so_far(bag) == len(read_study(bag).candidates), "what was sent to be told")
    told = told_so_far(bag)
    said = control(nodes.environment, "enqueue", "--joints", ARM[0], "--lengths", ",".join(map(str, ARM[1])))
    assert f"trial {told}" in said
    optimizer.kill()
    optimizer.wait()
    optimizer = nodes.optimizer(bag, n_trials=100_000, sampler="random", in_flight=2, resume=True)
    wait_for(lambda: "paused, as it was" in output(optimizer), "the optimizer to say that it is paused")
    status = json.loads(control(nodes.environment, "status"))
    assert [status[key] for key in ("study", "state", "told", "asked", "enqueued")] == ["s", "paused", told, told, 1]
    control(nodes.environment, "resume")
    wait_for(lambda: told_so_far(bag) > told, "more trials")
    control(nodes.environment, "stop")
    assert finish(optimizer) == 1, output(optimizer)
    study = read_study(bag)
    assert [command.command for command in study.commands] == ["pause", "enqueue", "resume", "stop"]
    assert study.candidate_of(told).sampled_joints == ARM[0]
    assert mobo("verify", "--sample", 0, bag) == 0
    said = lonely.communicate(timeout=PATIENCE_S)[1]
    assert lonely.returncode == 1 and said.count("\n") == 1 and "/nobody" in said, said


@pytest.mark.parametrize(
    "words",
    [
        ["halt"], [], ["enqueue"], ["enqueue", "--joints", "Y", "--lengths", "long"], ["pause", "--joints", "Y"],
        ["pause", "now"],
    ],
)  # fmt: skip
def test_words_that_mean_no_command(words: list[str]) -> None:
    """Refused in one line, before anything is started."""
    module = pytest.importorskip("mobo.control")
    with pytest.raises(InputError) as error:
        module.request(words)
    assert "\n" not in str(error.value) and error.value.exit_code == 2
