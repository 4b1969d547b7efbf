"""What came from outside speaks to nobody's terminal or spreadsheet, and a command that cannot print says so."""

from __future__ import annotations

import csv
import io
import os
import subprocess
import sys
from pathlib import Path

import pytest
from studies import mobo, run_study

from mobo_core.errors import InputError, StudyError, visible
from mobo_core.report.table_files import to_csv
from mobo_core.verify.fault import Fault

HOSTILE = "a\x1b[2J\nb\r\u202ec\x07"


def test_what_cannot_be_printed_is_made_visible() -> None:
    """In errors, faults and lines; other text stays as it is, umlauts too."""
    for said in (visible(HOSTILE), StudyError(HOSTILE), InputError(HOSTILE), Fault(3, "reason", HOSTILE)):
        text = str(said)
        assert text.isprintable() and "\\x1b[2J" in text and "\\u202e" in text
    assert visible("Größe 3 µm") == "Größe 3 µm"


def test_cells_that_spreadsheets_would_run_are_quoted() -> None:
    """Texts alone: numbers keep their signs."""
    columns = {"reason": ["=1+1", "+x", "-x", "@x", "x=1", "a\nb"], "torque": [-1.5, 2.0, 0.0, 1e300, -0.0, 3.0]}
    columns["reason"].append("\x1b[2J")
    columns["torque"].append(0.5)
    cells = list(csv.reader(io.StringIO(to_csv(columns))))[1:]
    assert [cell for cell, _ in cells] == ["'=1+1", "'+x", "'-x", "'@x", "x=1", "a\nb", "\\x1b[2J"]
    assert [float(number) for _, number in cells] == columns["torque"]


def test_a_hostile_reason_is_shown_and_not_obeyed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Of an evaluator whose name and reason hold escapes: bag info and the table print none."""
    bag = run_study(tmp_path / "bag", 3, evaluators=["e0"], name="s\x1b[31m")
    assert mobo("bag", "info", bag) == 0
    assert "\x1b" not in capsys.readouterr().out


@pytest.mark.parametrize("how", ["full", "home", "files"])
def test_a_command_without_means_ends_in_one_line(tmp_path: Path, how: str) -> None:
    """No room behind its output, no home, hardly a file to open: no traceback."""
    bag = run_study(tmp_path / "bag", 2)
    command = [sys.executable, "-m", "mobo_core.commands.cli", "bag", "info", str(bag)]
    environment = {name: value for name, value in os.environ.items() if name != "HOME"}
    if how == "files":
        command = ["bash", "-c", 'ulimit -n 20; exec "$@"', "-", *command]
    with open("/dev/full" if how == "full" else os.devnull, "w") as out:
        run = subprocess.run(command, stdout=out, stderr=subprocess.PIPE, text=True, env=environment, check=False)
    assert run.returncode == (1 if how == "full" else 0)
    assert run.stderr == ("mobo bag: No space left on device\n" if how == "full" else "")
