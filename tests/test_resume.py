"""Resume refuses a bag that does not say how its study went, in one line, and touches nothing of it."""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from studies import run_study
from test_verify import tampered

from mobo_core.bag.lock import LOCK_FILE
from mobo_core.coordination.optimizer import Optimizer
from mobo_core.errors import InputError

N, TOLD = 24, 6


@pytest.fixture(scope="module")
def killed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study whose optimizer was killed when an arm was enqueued and a pause had ended."""
    def meanwhile(optimizer: Optimizer) -> bool:
        if len(optimizer.study.told) < TOLD:
            return False
        controls, asked = optimizer.controls, len(optimizer.study.asked)
        lengths = (0.05, 0.25, 0.2, 0.05, 0.0, 0.05)
        return all((
            controls.pause(asked, "me").accepted, controls.resume(asked, "me").accepted,
            controls.enqueue(asked, "me", "YPPYPY", lengths, N).accepted,
        ))  # fmt: skip

    return run_study(tmp_path_factory.mktemp("resume") / "study", N, meanwhile=meanwhile)


def _params(change: Callable[[dict[str, Any]], object]) -> Callable[[Any], None]:
    def changed(message: Any) -> None:
        params = json.loads(message.params_json)
        change(params)
        message.params_json = json.dumps(params)

    return changed


def _enqueued(change: Callable[[dict[str, Any]], object]) -> Callable[[Any], None]:
    def changed(message: Any) -> None:
        arguments = json.loads(message.arguments_json)
        change(arguments["params"])
        message.arguments_json = json.dumps(arguments)

    return changed


def _text(field: str, value: str) -> Callable[[Any], None]:
    return lambda message: setattr(message, field, value)


@pytest.mark.parametrize(
    ("kind", "which", "change", "says"),
    [
        ("Candidate", 5, _text("params_json", '{"J1": '), "params_json of trial 5"),
        ("Candidate", 5, _text("params_json", "[1, 2]"), "params_json of trial 5"),
        ("Candidate", 5, _text("params_json", "null"), "params_json of trial 5"),
        ("Candidate", 5, _text("params_json", "[" * 100_000), "params_json of trial 5"),
        ("Candidate", 5, _params(lambda p: p.pop("J1")), "params_json of trial 5"),
        ("Candidate", 5, _params(lambda p: p.update(J1="X")), "params_json of trial 5"),
        ("Candidate", 5, _params(lambda p: p.update(J1=["R"])), "params_json of trial 5"),
        ("Candidate", 5, _params(lambda p: p.update(u1=1.5)), "params_json of trial 5"),
        ("Candidate", 5, _params(lambda p: p.update(u1="long")), "params_json of trial 5"),
        ("Candidate", 5, _params(lambda p: p.update(u1=float("nan"))), "params_json of trial 5"),
        ("Candidate", 5, _params(lambda p: p.update(more=0.5)), "params_json of trial 5"),
        ("Command", 0, _text("command", "explode"), "command of trial 16: unknown: 'explode'"),
        ("Command", 0, _text("command", ""), "command of trial 16: unknown: ''"),
        ("Command", 2, _text("arguments_json", "{"), "command enqueue of trial 16"),
        ("Command", 2, _text("arguments_json", '{"params": 3}'), "command enqueue of trial 16"),
        ("Command", 2, _enqueued(lambda p: p.update(J1="X")), "command enqueue of trial 16"),
        ("Command", 2, _enqueued(lambda p: p.update(u1=1.5)), "command enqueue of trial 16"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("whole", [True, False])
def test_what_cannot_be_repeated_is_refused(
    killed: Path, tmp_path: Path, kind: str, which: int, change: Callable[[Any], None], says: str, whole: bool
) -> None:
    """Exit code 2 and one line that names trial or command and the bag, whose files stay as they were."""
    bag = tampered(killed, tmp_path / "copy", kind, change, which)
    if not whole:
        (file,) = bag.glob("*.mcap")
        file.write_bytes(file.read_bytes()[:-40])  # as a killed writer leaves it; resume would make it whole
    before = _files(bag)
    with warnings.catch_warnings(action="error"), pytest.raises(InputError) as error:
        run_study(bag, N, resume=True)
    assert error.value.exit_code == 2
    assert says in str(error.value) and str(bag) in str(error.value) and len(str(error.value)) < 600
    assert _files(bag) == before


def test_the_study_before_the_changes_goes_on(killed: Path, tmp_path: Path) -> None:
    """What the tests above refuse is the change, not the bag."""
    bag = tampered(killed, tmp_path / "copy", "Command", lambda message: None)
    run_study(bag, N, resume=True)


def _files(bag: Path) -> dict[str, bytes]:
    return {entry.name: entry.read_bytes() for entry in bag.iterdir() if entry.name != LOCK_FILE}
