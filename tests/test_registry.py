"""Registries: built-in entries, those of other distributions, and broken ones."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from mobo_core.errors import InputError
from mobo_core.registry import Registry


@dataclass(frozen=True)
class Thing:
    name: str


def registry() -> Registry[Thing]:
    return Registry("thing", "mobo.test_things", Thing, (Thing("one"), Thing("two")))


@pytest.fixture
def distribution(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A distribution that offers one good entry and some bad ones."""
    info = tmp_path / "things-1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: things\nVersion: 1\n")
    (info / "entry_points.txt").write_text(
        "[mobo.test_things]\na_missing = no_such_module:THING\nb_other = things_here:OTHER\n"
        "c_taken = things_here:TAKEN\nthree = things_here:THREE\n"
    )
    (tmp_path / "things_here.py").write_text(
        "from test_registry import Thing\nTHREE, TAKEN, OTHER = Thing('three'), Thing('one'), 7\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "things_here", raising=False)
    return tmp_path


def test_built_in_entries_need_no_entry_points(monkeypatch: pytest.MonkeyPatch) -> None:
    """Asking for a built-in name reads nothing of what is installed."""
    monkeypatch.setattr("mobo_core.registry.entry_points", lambda group: pytest.fail("read"))
    assert registry()["two"] == Thing("two")
    assert registry().built_in == (Thing("one"), Thing("two"))


def test_entries_of_other_distributions(distribution: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Good ones are there by name; each bad one is told in a line, once, and left out."""
    things = registry()
    assert list(things) == ["one", "two", "three"] and things.of("three") == Thing("three")
    lines = capsys.readouterr().err.splitlines()
    assert [line.split(" left out: ")[0] for line in lines] == [
        f"mobo: thing {name!r} of things" for name in ("a_missing", "b_other", "c_taken")
    ]
    assert "the name 'one' is taken" in lines[2]
    assert len(things) == 3 and not capsys.readouterr().err


def test_an_unknown_name_says_which_there_are() -> None:
    """One line: what, where, what was expected."""
    with pytest.raises(InputError, match="parameter thing: 'four'; expected one or two$"):
        registry().of("four", "parameter thing")
