"""The stand-in for the command ros2, on prefixes made up for each test."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

STANDIN = Path(__file__).parent.parent / "ros_pkgs" / "ros2_standin"
PRINT_ARGS = "printf '%s\\n' \"$@\"; exit 7"

# As the console script does it, but with another place for a real ROS 2 than this machine's.
START = """
import sys, mobo_ros2_standin
mobo_ros2_standin.SYSTEM_ROS = mobo_ros2_standin.Path(sys.argv.pop(1))
sys.exit(mobo_ros2_standin.main())
"""


def script(path: Path, text: str, mode: int = 0o755) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(mode)
    return path


class Machine:
    """A folder with prefixes, a PATH and a place for a real ROS 2."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.system_ros = folder / "opt" / "ros"
        self.path = ["/usr/bin", "/bin"]
        self.prefixes: list[Path] = []

    def install(self, package: str, prefix: str = "install") -> Path:
        """Register a package; return the folder of its executables."""
        root = self.folder / prefix
        if root not in self.prefixes:
            self.prefixes.append(root)
        marker = root / "share/ament_index/resource_index/packages" / package
        marker.parent.mkdir(parents=True, exist_ok=True)
        marker.touch()
        return root / "lib" / package

    def start(self, *args: str) -> subprocess.Popen[str]:
        environment = {
            **os.environ,
            "PATH": os.pathsep.join(self.path),
            "PYTHONPATH": str(STANDIN),
            "AMENT_PREFIX_PATH": os.pathsep.join(map(str, self.prefixes)),
        }
        command = [sys.executable, "-c", START, str(self.system_ros), *args]
        return subprocess.Popen(
            command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )

    def ros2(self, *args: str) -> tuple[int, str, str]:
        """Return exit code, stdout and stderr of ``ros2 ARGS``."""
        process = self.start(*args)
        out, err = process.communicate(timeout=300)
        return process.returncode, out, err


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    return Machine(tmp_path)


def test_run_passes_arguments_and_exit_code_on(machine: Machine) -> None:
    script(machine.install("arm") / "show", PRINT_ARGS)
    args = ["--ros-args", "-p", "name:=two words", "--", "--help", "-h"]
    assert machine.ros2("run", "arm", "show", *args) == (7, "\n".join(args) + "\n", "")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_run_becomes_the_executable_so_signals_reach_it(machine: Machine, number: signal.Signals) -> None:
    script(machine.install("arm") / "wait", "echo $$; exec sleep 60")
    process = machine.start("run", "arm", "wait")
    assert process.stdout is not None
    assert int(process.stdout.readline()) == process.pid
    process.send_signal(number)
    process.communicate(timeout=300)
    assert process.returncode == -number


def test_first_prefix_takes_precedence(machine: Machine) -> None:
    script(machine.install("arm", "overlay") / "which", "echo overlay")
    script(machine.install("arm", "underlay") / "which", "echo underlay")
    assert machine.ros2("run", "arm", "which")[1] == "overlay\n"


def test_executables_are_those_real_ros2_finds(machine: Machine) -> None:
    folder = machine.install("arm")
    found = [script(folder / "b", ""), script(folder / "deep" / "a", "")]
    script(folder / "data.txt", "", mode=0o644)
    script(folder / ".hidden" / "c", "")
    script(machine.install("leg", "other") / "d", "")
    machine.install("messages_only")
    assert machine.ros2("pkg", "executables", "arm") == (0, "arm b\narm a\n", "")
    assert machine.ros2("pkg", "executables")[1] == "arm b\narm a\nleg d\n"
    assert machine.ros2("pkg", "executables", "arm", "--full-path")[1] == "".join(f"{p}\n" for p in found)
    assert machine.ros2("pkg", "executables", "messages_only") == (0, "", "")


@pytest.mark.parametrize(
    ("args", "named"),
    [
        (["run", "amr", "show"], ["'amr'", "arm"]),
        (["run", "arm", "shwo"], ["'shwo'", "'arm'", "show"]),
        (["run", "arm", "twin"], ["'twin'", "lib/arm/twin", "lib/arm/deep/twin"]),
        (["run", "arm"], ["'run arm'", "ros2 run PKG EXE"]),
        (["pkg", "executables", "amr"], ["'amr'", "arm"]),
        (["pkg", "executables", "arm", "--paths"], ["--paths", "--full-path"]),
        (["topic", "list"], ["'topic'", "stand-in", "ros2 run PKG EXE", "ros2 pkg executables"]),
        (["pkg", "list"], ["'pkg list'", "stand-in", "ros2 pkg executables"]),
    ],
)
def test_what_it_cannot_do_is_one_line_and_exit_code_2(
    machine: Machine, args: list[str], named: list[str]
) -> None:
    for name in ("show", "twin", "deep/twin"):
        script(machine.install("arm") / name, "")
    code, out, err = machine.ros2(*args)
    assert (code, out) == (2, "")
    assert len(err.splitlines()) == 1
    assert all(name in err for name in named), err


def test_without_ament_prefix_path_it_says_what_to_source(machine: Machine) -> None:
    code, _, err = machine.ros2("run", "arm", "show")
    assert code == 2
    assert "install/setup.bash" in err


def test_hands_over_to_another_ros2_on_path(machine: Machine) -> None:
    script(machine.install("arm") / "show", PRINT_ARGS)
    script(machine.folder / "bin" / "ros2", "echo real $_ROS_WHEELS_BOOTSTRAP_COMPLETE; " + PRINT_ARGS)
    machine.path.append(str(machine.folder / "bin"))
    assert machine.ros2("topic", "list", "-t") == (7, "real\ntopic\nlist\n-t\n", "")
    assert machine.ros2("run", "arm", "show")[1] == "real\nrun\narm\nshow\n"


def test_does_not_hand_over_to_another_standin(machine: Machine) -> None:
    script(machine.install("arm") / "show", PRINT_ARGS)
    script(machine.folder / "bin" / "ros2", "# from mobo_ros2_standin import main\necho not asked")
    machine.path.insert(0, str(machine.folder / "bin"))
    assert machine.ros2("run", "arm", "show", "x")[:2] == (7, "x\n")


def test_hands_over_to_an_installed_ros2_in_its_own_environment(machine: Machine) -> None:
    script(machine.system_ros / "bin" / "ros2", "echo $FROM_SETUP; " + PRINT_ARGS)
    script(machine.system_ros / "setup.bash", "export FROM_SETUP=sourced")
    assert machine.ros2("bag", "play", "a b") == (7, "sourced\nbag\nplay\na b\n", "")
