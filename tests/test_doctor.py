"""mobo doctor: a line for each thing it looks at, and whether all of them are good."""

from __future__ import annotations

from pathlib import Path

import pytest

from mobo_core.commands import doctor
from mobo_core.commands.cli import main
from mobo_core.jit.cache import Cache

CHECKS = ["python", "libraries", "compiler", "kernel", "sampler", "ros", "dds", "disk"]


def test_looks_at_everything_and_fails_if_one_does(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A line each, also after a failure; the exit code is 1 if any failed."""
    monkeypatch.setattr(doctor, "_dds", lambda: (False, "no answer"))  # no nodes here
    monkeypatch.setattr(doctor, "_kernel", lambda: (True, "loaded"))
    assert main(["doctor"]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[1] for line in lines] == CHECKS
    assert "FAIL  dds        no answer" in lines and "ok    kernel     loaded" in lines
    for check in ("_compiler", "_disk", "_dds", "_libraries", "_python", "_ros", "_sampler"):
        monkeypatch.setattr(doctor, check, lambda: (True, "fine"))
    assert main(["doctor"]) == 0


def test_says_where_compiled_functions_are_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Compiled at first, loaded later; a folder that cannot be written is a fault, and named."""
    monkeypatch.setenv("MOBO_CACHE", str(tmp_path))
    cache = Cache("some", [__file__])

    def load() -> int:
        return cache.once("some functions", "all", lambda: 1, say=lambda _: None)

    for how in ("compiled", "loaded"):
        good, text = doctor.loaded(cache, "all", load)
        assert good and text.startswith(how) and text.endswith(f"kept in {cache.folder()}")
    (tmp_path / "file").touch()
    monkeypatch.setenv("MOBO_CACHE", str(tmp_path / "file"))
    cache = Cache("some", [__file__])
    good, text = doctor.loaded(cache, "all", load)
    assert not good and text.startswith("compiled") and str(cache.folder()) in text and "MOBO_CACHE" in text
