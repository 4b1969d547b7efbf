"""What the README says is so: parameters, commands, and the ten lines that read a bag."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

import pytest
from studies import run_study

from mobo_core.commands.cli import VERBS
from mobo_core.coordination.options import EvaluatorOptions, OptimizerOptions, ReplayOptions, StudyOptions
from mobo_core.coordination.parameters import parameters
from mobo_core.messages import TOPICS

README = (Path(__file__).parent.parent / "README.md").read_text(encoding="utf-8")


def test_lists_every_parameter_of_every_node_with_its_default() -> None:
    """In rows of node, name, default and description, the node named once."""
    rows = re.findall(r"^\| (\w*) \| `(\w+)` \| ([^|]*) \| ([^|]*) \|$", README, re.MULTILINE)
    listed: dict[tuple[str, str], tuple[str, str]] = {}
    node = ""
    for named, name, default, description in rows:
        node = named or node
        listed[node, name] = (default.strip(), description.strip())
    for node, options in (
        ("optimizer", OptimizerOptions),
        ("evaluator", EvaluatorOptions),
        ("study", StudyOptions),
        ("replay", ReplayOptions),
    ):
        for parameter in parameters(options):
            if node == "study" and parameter.name != "evaluators":
                continue  # the optimizer's and the evaluator's
            default, description = listed.pop((node, parameter.name))
            assert description == parameter.description
            if parameter.name != "workers":  # the cores of the machine
                assert default == parameter.shown_default
    assert not listed


def test_names_every_command_and_topic() -> None:
    """Each verb of mobo, each topic and its message."""
    for verb in VERBS:
        assert f"`mobo {verb}" in README
    for topic, kind in ((topic, cls.kind) for topic, cls in TOPICS.items()):
        assert f"| `{topic}` | `{kind}` |" in README


def test_ten_lines_read_a_bag(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The Python of the README, run as it stands."""
    blocks = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    (code,) = [block for block in blocks if "AnyReader" in block]
    assert len(code.strip().splitlines()) <= 10
    run_study(tmp_path / "bags" / "demo_001", 5)
    monkeypatch.chdir(tmp_path)
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(code, "README.md", "exec"), {})
    assert [int(line.split()[0]) for line in printed.getvalue().splitlines()] == list(range(5))
