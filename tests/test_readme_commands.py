"""Every command of README and docs is run, or its reason not to be is given; stable output is compared."""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from arms import arm
from nodes import PATIENCE_S, ends_with_tests, own_domain, wait_for
from studies import mobo

from mobo_core.bag.collector import read_study
from mobo_core.commands.cli import VERBS, parser
from mobo_core.coordination.options import EvaluatorOptions, OptimizerOptions, ReplayOptions, StudyOptions
from mobo_core.coordination.parameters import parameters

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]

# What makes a command short enough for a test.
SHORT = {
    "n_trials:=1000": "n_trials:=6",
    "n_trials:=2000": "n_trials:=8",
    "n_trials:=500": "n_trials:=12",
    "--trial 10": "--trial 4",
    "n_trials=300": "n_trials=6",
    "sample=20": "sample=2",
}
# Commands of blocks that are run below, by the test that runs them.
RUN = {
    "test_a_study_its_report_and_going_on": (
        "ros2 run mobo study --ros-args -p study_name:=first -p n_trials:=1000",
        "mobo report bags/first -o report",
        "mobo verify bags/first",
        "ros2 run mobo study --ros-args -p study_name:=first -p n_trials:=2000 -p resume:=true",
        "mobo evaluate bags/first --trial 10",
        "mobo export urdf bags/first --trial 10 -o arm.urdf",
    ),
    "test_nodes_by_hand_and_commands_to_a_running_study": (
        "ros2 run mobo optimizer --ros-args -p study_name:=second -p n_trials:=500",
        "ros2 run mobo evaluator",
        "ros2 run mobo control pause",
        "ros2 run mobo control enqueue --joints YPPYPY --lengths 0.05,0.25,0.2,0.05,0,0.05",
    ),
    "test_an_atlas_is_made_and_asked": (
        "mobo atlas bags/long -o atlas.parquet",
        "mobo atlas ask atlas.parquet --order YPPYPY",
        "mobo atlas ask atlas.parquet --without R",
        "mobo atlas ask atlas.parquet --reach-at-least 30 --min torque",
        "mobo atlas ask atlas.parquet --max torque=400 --top 3 -o arms",
        "mobo atlas ask atlas.parquet --near 0.05,0.25,0.2,0.05,0,0.05 --json",
    ),
    "test_arms_are_evaluated": (
        "mobo evaluate --joints YPPYPY --lengths 0.05,0.25,0.2,0.05,0,0.05",
        "mobo evaluate robot.urdf --tip tool0 --spec paper_fine --json",
    ),
}
# Those that are not run: checked for the shell's syntax, and make's for their targets.
NOT_RUN = {
    "make demo": "sets a machine up: .ci does so on a fresh one",
    "make test": "runs this test",
    "make setup": "sets a machine up",
    "make check": "runs the tests",
    "make test-faults": "takes two hours",
    "make docs": "writes into build/: the page of the API is no part of the tests",
    "make arms": "evaluates 81 arms: test_the_commands of test_catalogue.py does so with two",
    "mobo arms list": "the same test",
    "mobo arms show iiwa14": "the same test",
    "mobo arms evaluate Panda UR5 my.urdf": "the same test; test_sliding_arms.py does so with a file",
    "mobo arms place UR5e": "takes ten seconds: test_arms_place.py does so with another arm",
    "mobo arms place my.urdf --tip tool0 --in bags/long": "needs the file: test_arms_place.py reads arms of its own",
    "mobo arms place Z1 --what-if own --by peak": "takes ten seconds: test_arms_place.py tries the changes",
    "mobo arms place xArm6 --what-if none -o xarm6.png": "test_the_command of test_arms_place.py does so",
    "mobo size my.urdf --tip tool0 --payload 1.0": "needs the file: test_size.py sizes arms of its own",
    "mobo size my.urdf --payload 1.0 --motors motors.yaml --use 0.5 -o payload.png": "the same",
    "mobo size --joints PRRYPY --lengths 0.05,0.2,0.2,0.1,0,0.05 --payload 0.5 --motors examples/motors.yaml": (
        "test_the_command of test_size.py does so with another arm"
    ),
    "mobo evaluate panda.urdf": "needs the file: test_real_arms.py writes one of its own",
    "mobo evaluate ur.urdf.xacro --xacro ur_type:=ur5e --package-dir ~/ws/src": "the same",
    "mobo evaluate tiago.urdf --tip arm_tool_link --set torso_lift_joint=0.1 --srdf tiago.srdf": "the same",
    "pip install mjcf-urdf-simple-converter": "is no part of mobo",
    "python -c \"from mjcf_urdf_simple_converter import convert; convert('arm.xml', 'arm.urdf')\"": "the same",
    "source .venv/bin/activate && source install/setup.bash": "the tests run in what it gives",
    "export ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET": "needs a second machine: tests/faults/test_network.py",
    "ros2 run mobo optimizer --ros-args -p study_name:=third -p n_trials:=5000 -p in_flight:=64": "the same",
    "export ROS_STATIC_PEERS=10.0.0.5": "the same",
    "fast-discovery-server -i 0 -l 10.0.0.5 -p 11811": "the same",
    "export ROS_DISCOVERY_SERVER=10.0.0.5:11811": "the same",
}

# What the first arm's evaluation prints, its seconds left out.
EVALUATED = """\
reach   40.53 of 75 voxels (54.0% of 2250 poses)
torque  367.1 N m, summed over the voxels' means; 6.80 N m a reached voxel
failed  120 out of range, 914 not converged, 0 in collision
chain   joint_1, joint_2, joint_3, joint_4, joint_5, joint_6 to tool
joint       mean     95 %     peak   N m, held against gravity at the poses reached
joint_1     0.00     0.00     0.00
joint_2     6.17     8.79     9.16
joint_3     2.58     3.72     3.74
joint_4     0.00     0.01     0.01
joint_5     0.00     0.01     0.01
joint_6     0.00     0.00     0.00
"""


def blocks(page: Path, language: str = "") -> list[str]:
    """Return the fenced blocks of a page in one language; those without one are commands, drawings left out."""
    found = re.findall(r"^```([^\n]*)\n(.*?)^```", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    return [text for named, text in found if named.strip() == language and "──" not in text]


def command_lines() -> list[str]:
    """Return the commands of all blocks, without their comments."""
    lines = [line for page in PAGES for block in blocks(page) for line in block.splitlines()]
    return [command for line in lines if (command := re.sub(r"(^|\s+)#.*", "", line).strip())]


def code_spans() -> list[str]:
    """Return the commands between backquotes in running text that have arguments, placeholders filled in."""
    filled = {"BAG…": "BAG", "[": "", "]": "", " N": " 3", "FILE.csv|.parquet": "FILE.csv"}
    spans = []
    for page in PAGES:
        text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
        for span in re.findall(r"`((?:mobo|ros2 run mobo|make) [^`]+)`", text):
            command = " ".join(span.split())
            for old, new in filled.items():
                command = command.replace(old, new)
            spans.append(re.sub(r"(\w+)(\|\w+)+", r"\1", command))
    return spans


def shortened(command: str) -> str:
    """Return a command with what makes it short."""
    for long, short in SHORT.items():
        command = re.sub(rf"{re.escape(long)}\b", short, command)
    return command


class Shell:
    """A folder in which commands are run, and a ROS domain for them."""

    def __init__(self, folder: Path, environment: dict[str, str]) -> None:
        self.folder, self.environment = folder, environment
        self.started: list[subprocess.Popen[str]] = []

    def start(self, command: str) -> subprocess.Popen[str]:
        """Start a command as it stands, but short; what it prints goes to a file."""
        with (self.folder / f"log_{len(self.started)}").open("w") as log:
            words = shlex.split(shortened(command))
            process = subprocess.Popen(
                words, cwd=self.folder, env=self.environment | ends_with_tests(), stdout=log, stderr=log, text=True
            )
        self.started.append(process)
        return process

    def ros2(self, command: str) -> None:
        """Run a command that must end well; on a busy machine `control` may give up before it finds its optimizer."""

        def ended() -> tuple[int, str] | None:
            log = self.folder / f"log_{len(self.started)}"
            code, said = self.start(command).wait(PATIENCE_S), log.read_text()
            return None if "no optimizer in" in said else (code, said)

        code, said = wait_for(ended, command)
        assert code == 0, said

    def mobo(self, command: str) -> str:
        """Run a command of mobo in this process, which must end well, and return what it prints."""
        program, *arguments = shlex.split(shortened(command))
        printed = io.StringIO()
        with contextlib.chdir(self.folder), contextlib.redirect_stdout(printed):
            assert (program, mobo(*arguments)) == ("mobo", 0)
        return printed.getvalue()


@pytest.fixture(scope="module")
def shell(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Shell]:
    with own_domain() as environment:
        made = Shell(tmp_path_factory.mktemp("work"), environment)
        try:
            yield made
        finally:
            for process in made.started:
                if process.poll() is None:
                    process.kill()
                process.wait()


def test_every_command_is_run_or_has_a_reason() -> None:
    """A new line of README or docs has to be added here; one that is gone is taken out."""
    run = {command for commands in RUN.values() for command in commands}
    assert run.isdisjoint(NOT_RUN)
    assert set(command_lines()) == run | set(NOT_RUN)
    assert all(callable(globals()[name]) for name in RUN)


def test_blocks_are_shell() -> None:
    """All of them, by bash itself, which runs nothing; and make knows its targets."""
    for page in PAGES:
        for block in blocks(page):
            done = subprocess.run(["bash", "-n"], input=block, capture_output=True, text=True, timeout=PATIENCE_S)
            assert done.returncode == 0 and not done.stderr, (page.name, done.stderr)
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for command in [*command_lines(), *code_spans()]:
        if command.startswith("make "):
            assert re.search(rf"^{command.split()[1]}:", makefile, re.MULTILINE), command


def test_commands_in_the_text_are_commands() -> None:
    """Verbs, options, nodes and parameters that are named between backquotes exist."""
    known = {
        "optimizer": OptimizerOptions, "evaluator": EvaluatorOptions, "replay": ReplayOptions, "study": StudyOptions,
        "control": None,
    }  # fmt: skip
    top = parser()
    checked = 0
    for command in code_spans():
        program, *words = shlex.split(command)
        if program == "ros2":
            options = known[words[2]]
            names = {parameter.name for parameter in parameters(options)} if options else set()
            assert set(re.findall(r"-p (\w+):=", command)) <= names, command
        elif program == "mobo" and len(words) > 1 and any(word.startswith("-") for word in words):
            if "--help" not in words:
                top.parse_args(words)  # exits with 2 if it does not fit
        elif program == "mobo":
            assert words[0] in {*VERBS, "claims"}, command  # the glossary has a word that is to come
        checked += 1
    assert checked > 20


@pytest.mark.ros
@pytest.mark.slow
def test_a_study_its_report_and_going_on(shell: Shell) -> None:
    """The block of studies, line by line, and the commands on one of its trials."""
    study, report, verify, go_on, evaluate, export = RUN["test_a_study_its_report_and_going_on"]
    shell.ros2(study)
    assert len(read_study(shell.folder / "bags" / "first").trials) == 6
    said = shell.mobo(report)
    assert said.startswith("first: 6 trials told, ") and said.endswith("page       report/index.html\n")
    assert {"front.csv", "trials.csv", "joint_torques.csv", "index.html"} <= set(os.listdir(shell.folder / "report"))
    assert shell.mobo(verify) == (
        "good: 6 trials told (0 failed), 6 candidates, 6 designs asked again, 6 evaluations made again\n"
        "hash chain whole\n"
    )
    assert shell.mobo(evaluate).endswith("bag     the same, to the bit\n")
    assert shell.mobo(export) == "arm.urdf\n"
    assert (shell.folder / "arm.urdf").read_text().startswith("<?xml")
    shell.ros2(go_on)
    assert sorted(read_study(shell.folder / "bags" / "first").trials) == list(range(8))


@pytest.mark.ros
@pytest.mark.slow
def test_nodes_by_hand_and_commands_to_a_running_study(shell: Shell) -> None:
    """An optimizer waits for its evaluators, takes commands meanwhile, and ends when all is told."""
    optimizer, evaluator, pause, enqueue = RUN["test_nodes_by_hand_and_commands_to_a_running_study"]
    running = shell.start(optimizer)
    bag = shell.folder / "bags" / "second"
    wait_for(lambda: running.poll() is not None or list(bag.glob("*.mcap")), "the bag")
    shell.ros2(pause)
    shell.ros2(enqueue)
    shell.ros2("ros2 run mobo control resume")  # the block's comment names it
    evaluators = [shell.start(evaluator), shell.start(evaluator)]
    assert running.wait(PATIENCE_S) == 0
    for process in evaluators:
        process.send_signal(signal.SIGINT)
    assert [process.wait(PATIENCE_S) for process in evaluators] == [0, 0]
    study = read_study(bag)
    assert sorted(study.trials) == list(range(12))
    assert [command.command for command in study.commands][:3] == ["pause", "enqueue", "resume"]


def test_arms_are_evaluated(shell: Shell) -> None:
    """One by joints and lengths, to the digits shown, and one from a robot's own description."""
    by_lengths, by_urdf = RUN["test_arms_are_evaluated"]
    (shell.folder / "robot.urdf").write_text(arm("PRRYPY").replace('"tool"', '"tool0"'))
    lines = shell.mobo(by_lengths).splitlines()
    assert [line for line in lines if not line.startswith("effort")] == EVALUATED.splitlines()
    assert '"tip": "tool0"' in shell.mobo(by_urdf)


def test_an_atlas_is_made_and_asked(shell: Shell) -> None:
    """The block of docs/atlas.md, on a sample bag."""
    made, *asked = RUN["test_an_atlas_is_made_and_asked"]
    (shell.folder / "bags").mkdir(exist_ok=True)
    (shell.folder / "bags" / "long").symlink_to(ROOT / "bags" / "sample" / "paper_6")
    assert "trials" in shell.mobo(made)
    for command in asked:
        assert shell.mobo(command)
    assert len(list((shell.folder / "arms").glob("*.urdf"))) == 3


@pytest.mark.slow
def test_python_of_the_readme_runs_as_a_script(tmp_path: Path) -> None:
    """The public face in five lines, saved as a file, on a shorter study."""
    (code,) = [block for block in blocks(ROOT / "README.md", "python") if "import mobo_core" in block]
    (tmp_path / "script.py").write_text(shortened(code))
    command = [sys.executable, "script.py"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE_S)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("StudyRecord('third': 6 trials told; ") and "<Result: reach " in done.stdout
    assert (tmp_path / "report" / "index.html").is_file()
