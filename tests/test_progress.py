"""How far a command has come, where standard error is no terminal."""

from __future__ import annotations

from pathlib import Path

import pytest
from studies import mobo

from mobo_core.commands import progress, reading

SAMPLE = Path(__file__).parents[1] / "bags" / "sample" / "paper_6"


def test_a_line_after_two_seconds_and_then_every_ten(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """On standard error, by the clock; nothing of what is done sooner, and none at the end."""
    monkeypatch.setattr(progress, "FIRST_S", 2.0)
    now = 100.0
    with progress.bar("evaluating", clock=lambda: now) as show:
        for second in range(30):
            now = 100.0 + second
            show(second + 1, 30)
    captured = capsys.readouterr()
    assert captured.err.splitlines() == ["evaluating 3/30", "evaluating 13/30", "evaluating 23/30"]
    assert captured.out == ""


def test_quiet_is_quiet(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """However long it takes."""
    monkeypatch.setattr(progress, "FIRST_S", 0.0)
    with progress.bar("evaluating", quiet=True) as show:
        show(1, 2)
    assert capsys.readouterr().err == ""


def test_a_long_reading_is_told(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """In one line, by a timer, since reading itself reports nothing."""

    class Timer:
        def __init__(self, seconds: float, function: object, arguments: object, keywords: object) -> None:
            self.start = lambda: function(*arguments, **keywords)  # type: ignore[operator,misc]
            self.cancel = lambda: None

    monkeypatch.setattr(reading.threading, "Timer", Timer)
    with reading.notice("reading a bag"):
        pass
    assert capsys.readouterr().err == "reading a bag …\n"


def test_verify_says_that_it_reads(monkeypatch: pytest.MonkeyPatch) -> None:
    """As every command that takes a bag does."""
    told: list[str] = []
    whole = reading.notice
    monkeypatch.setattr(reading, "notice", lambda text: (told.append(text), whole(text))[1])
    assert mobo("verify", SAMPLE, "--sample", 0) == 0
    assert told == [f"reading {SAMPLE}"]
