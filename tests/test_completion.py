"""Tab completes mobo and ros2 run in a shell, and mobo alone says where to begin."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest
from studies import mobo

from mobo_core.commands.cli import VERBS

ENVIRONMENT = Path(__file__).parents[1] / "ros_pkgs" / "mobo" / "environment"


def tab(line: str, setup: str, function: str, **environment: str) -> list[str]:
    """Return what bash would offer for a line whose end has just been typed, by calling the function as bash does."""
    words = line.split(" ")
    script = f"""
{setup}
COMP_LINE={line!r} COMP_POINT={len(line)} COMP_TYPE=9 COMP_CWORD={len(words) - 1}
COMP_WORDS=({" ".join(repr(word) for word in words)})
{function} {words[0]} {words[-1]!r} {words[-2]!r}
echo "code $?"
printf '%s\\n' "${{COMPREPLY[@]}}"
"""
    done = subprocess.run(
        ["bash", "--norc", "--noprofile", "-i", "-c", script],
        env={**os.environ, **environment}, capture_output=True, text=True, timeout=300, start_new_session=True,
    )  # fmt: skip
    code, *offered = done.stdout.splitlines()
    return [code, *sorted(word.strip() for word in offered if word.strip())]


@pytest.mark.parametrize(
    ("line", "offered"),
    [
        ("mobo v", ["verify"]),
        ("mobo evaluate --ik ", ["complete", "irteus", "paper"]),
        ("mobo export urdf --tri", ["--trial"]),
        ("mobo completion b", ["bash"]),
    ],
)
def test_bash_completes_mobo(line: str, offered: list[str]) -> None:
    """By what `mobo completion bash` prints."""
    assert tab(line, 'eval "$(mobo completion bash)"', "_python_argcomplete") == ["code 0", *offered]


def test_bash_asks_mobo_at_the_first_tab_only() -> None:
    """What setup.bash sources starts no Python; the first Tab does, and has bash begin again with what it got."""
    source = f"source {ENVIRONMENT / 'completion.bash'}"
    assert tab("mobo v", source, "_mobo_first_tab") == ["code 124"]
    assert tab("mobo v", source, "_mobo_first_tab mobo v mobo; _python_argcomplete")[1:] == ["verify"]
    assert tab("mobo v", f"{source}; mobo() {{ return 1; }}", "_mobo_first_tab") == ["code 1"]  # no mobo, no loop


def test_bash_completes_ros2_run(tmp_path: Path) -> None:
    """Packages that have something to run, and what that is, of all prefixes."""
    for prefix, package, names in (("a", "arm", ["look", "lift"]), ("b", "leg", ["walk"]), ("b", "words", [])):
        marker = tmp_path / prefix / "share/ament_index/resource_index/packages" / package
        marker.parent.mkdir(parents=True, exist_ok=True)
        marker.touch()
        for name in names:
            path = tmp_path / prefix / "lib" / package / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.touch(0o755)
    (tmp_path / "a/lib/arm/notes.txt").touch(0o644)

    def ros2(line: str) -> list[str]:
        prefixes = os.pathsep.join(str(tmp_path / name) for name in "ab")
        source = f"source {ENVIRONMENT / 'completion.bash'}"
        return tab(line, source, "_mobo_ros2", AMENT_PREFIX_PATH=prefixes)[1:]

    assert ros2("ros2 ") == ["pkg", "run"]
    assert ros2("ros2 run ") == ros2("ros2 pkg executables ") == ["arm", "leg"]
    assert ros2("ros2 run arm ") == ["lift", "look"] and ros2("ros2 run arm lo") == ["look"]
    assert ros2("ros2 run arm look ") == []


def test_scripts_are_silent_in_shells_that_are_not_interactive() -> None:
    """They change nothing there, and an existing completion of ros2 stays."""
    file = ENVIRONMENT / "completion.bash"
    script = f"set -eu; source {file}; complete -p mobo ros2 || true; declare -F"
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0 and done.stdout == ""
    script = f"complete -W own ros2; source {file}; complete -p ros2"
    done = subprocess.run(["bash", "--norc", "-i", "-c", script], capture_output=True, text=True, timeout=300,
                          start_new_session=True)  # fmt: skip
    assert done.stdout == "complete -W 'own' ros2\n"


@pytest.mark.skipif(shutil.which("zsh") is None, reason="zsh is not installed")
def test_zsh_registers_both() -> None:
    """Once zsh's own completion is on."""
    file = ENVIRONMENT / "completion.zsh"
    script = f"autoload -U compinit; compinit -u -D; source {file}; print $_comps[mobo] $_comps[ros2]"
    done = subprocess.run(["zsh", "-f", "-i", "-c", script], capture_output=True, text=True, timeout=300)
    assert done.stdout.split() == ["_mobo_first_tab", "_mobo_ros2"], done.stderr


def test_completion_of_zsh_and_of_other_shells(capsys: pytest.CaptureFixture[str]) -> None:
    """Code for zsh; what there is none for is refused."""
    assert mobo("completion", "zsh") == 0
    assert "compdef _python_argcomplete mobo" in capsys.readouterr().out
    assert mobo("completion", "fish") == 2


def test_mobo_alone_says_where_to_begin(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """Five commands, each of which there is."""
    assert mobo() == 0
    said = capsys.readouterr().out
    commands = [line.split() for line in said.splitlines() if line.startswith("  ")]
    assert len(commands) == 5 and commands[0][:4] == ["ros2", "run", "mobo", "study"]
    assert {words[1] for words in commands[1:]} < set(VERBS) and all(words[0] == "mobo" for words in commands[1:])
    assert "mobo --help" in said and max(map(len, said.splitlines())) <= 80
