"""What people type behind a node's name: refused where it means nothing, with the command that they meant."""

from __future__ import annotations

import shlex
import signal
import subprocess
import sys

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from nodes import Nodes

from mobo_core.coordination.arguments import check_arguments, command_line, nearest, parameter_word
from mobo_core.coordination.options import StudyOptions
from mobo_core.errors import InputError

KNOWN = tuple(StudyOptions.model_fields)


def refusal(line: str) -> str:
    with pytest.raises(InputError) as error:
        check_arguments("study", shlex.split(line), KNOWN)
    assert error.value.exit_code == 2 and "\n" not in str(error.value)
    return str(error.value)


@pytest.mark.parametrize(
    "line",
    [
        "",
        "--ros-args -p study_name:=t9 --param seed:=3",
        "--ros-args -r __ns:=/left --log-level warn --disable-rosout-logs --",
        "--ros-args --params-file x.yaml -p use_sim_time:=true -p optimizer:seed:=3",
    ],
)
def test_what_ros_and_the_node_know_is_taken(line: str) -> None:
    """Nothing is said of it."""
    check_arguments("study", shlex.split(line), KNOWN)


@pytest.mark.parametrize(
    ("line", "fault", "meant"),
    [
        ("-p study_name:=t9", "-p comes after --ros-args", "-p study_name:=t9"),
        ("--n_trials 3", "unknown argument '--n_trials'", "-p n_trials:=3"),
        ("--n-trials=3 --resume", "unknown argument '--n-trials=3'", "-p n_trials:=3 -p resume:=true"),
        ("n_trials:=3", "unknown argument 'n_trials:=3'", "-p n_trials:=3"),
        ("--n_trials 3 --bogus", "unknown argument", "-p n_trials:=3"),
        ("--bogus -p seed:=3", "unknown argument '--bogus'", "-p seed:=3"),
        ("--ros-args -p seed=3", "-p seed=3, without :=", "-p seed:=3"),
        ("--ros-args -p seed 3", "-p seed, without :=", "-p seed:=3"),
        ("--ros-args -p seed:= -p n_trials:=3", "-p seed:=, without a value", "-p n_trials:=3"),
        ("--ros-args -p n_trails:=3", "unknown parameter 'n_trails'", "-p n_trials:=3"),
        ("--ros-args -p sed:=3 -p study_name:='a b'", "unknown parameter 'sed'", "-p seed:=3 -p 'study_name:=a b'"),
        ("-r __ns:=/left -p seed:=1", "-r comes after --ros-args", "-r __ns:=/left -p seed:=1"),
    ],
)
def test_what_was_meant_is_named(line: str, fault: str, meant: str) -> None:
    """As a command that can be copied, and that is taken."""
    said = refusal(line)
    assert said.startswith(f"arguments: {fault}")
    command = said.split("; expected ", 1)[1]
    assert command == f"ros2 run mobo study --ros-args {meant}"
    check_arguments("study", shlex.split(command)[4:], KNOWN)


@pytest.mark.parametrize("line", ["--bogus", "first", "--ros-args -p", "--ros-args -p zzz:=3", "--ros-args -p"])
def test_what_nothing_can_be_made_of_leads_to_the_help(line: str) -> None:
    """There all parameters are."""
    assert refusal(line).endswith("expected what study --help shows")


def test_a_node_with_words_of_its_own_reads_them_itself() -> None:
    """Between --ros-args and -- it knows what ROS knows."""
    check_arguments("control", ["enqueue", "--joints", "Y", "--ros-args", "-r", "__ns:=/left", "--", "--more"], None)
    with pytest.raises(InputError, match="without :="):
        check_arguments("control", ["pause", "--ros-args", "-p", "a=b"], None)


@given(st.sampled_from(KNOWN), st.data())
def test_a_slip_of_one_letter_is_understood(name: str, data: st.DataObject) -> None:
    """Whichever letter of a name is left out, as long as five remain."""
    left_out = data.draw(st.integers(0, len(name) - 1))
    typed = name[:left_out] + name[left_out + 1 :]
    if len(typed) >= 5 and typed not in KNOWN:
        assert nearest(typed, KNOWN) == name


@given(st.one_of(st.text(min_size=1).filter(str.isprintable), st.integers(0, 2**63), st.booleans(), st.floats(0, 1e6)))
def test_a_printed_parameter_is_read_as_it_was(value: str | int | float | bool) -> None:
    """Through a shell and YAML, as ROS reads it."""
    command = command_line("study", ["-p", parameter_word("study_name", value)])
    name, read = shlex.split(command)[-1].split(":=", 1)
    assert (name, yaml.safe_load(read)) == ("study_name", value)


@pytest.mark.ros
@pytest.mark.parametrize("executable", ["optimizer", "evaluator", "study", "replay"])
def test_nodes_refuse_unknown_words(nodes: Nodes, executable: str) -> None:
    """With exit code 2 and one line."""
    command = [sys.executable, "-m", f"mobo.{executable}", "-p", "seed:=1", "--bogus"]
    done = subprocess.run(command, env=nodes.environment, capture_output=True, text=True, check=False)
    (line,) = done.stderr.splitlines()
    assert done.returncode == 2 and line.startswith(f"mobo {executable}: arguments: "), line


@pytest.mark.ros
@pytest.mark.parametrize("executable", ["optimizer", "evaluator", "study", "control"])
def test_ctrl_c_at_the_start_leaves_no_traceback(nodes: Nodes, executable: str) -> None:
    """Whatever it was just loading, started as `ros2 run` starts it; and no bag."""
    words = ["status"] if executable == "control" else []
    for after_s in (0.15, 0.6):
        node = subprocess.Popen(
            [sys.executable, "-m", f"mobo.{executable}", *words], env=nodes.environment, cwd=nodes.folder,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            preexec_fn=lambda: signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT}),
        )  # fmt: skip
        with pytest.raises(subprocess.TimeoutExpired):
            node.wait(after_s)
        node.send_signal(2)
        said, _ = node.communicate(timeout=300)
        assert "Traceback" not in said and "Interrupt" not in said
        assert node.returncode in (-2, 1, 0)
    assert not (nodes.folder / "bags").exists()
