"""Evaluators that hang while nobody else is there, or never come to an end."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest
from nodes import Nodes, finish, output, told_so_far, values, wait_for
from test_killed_evaluators import N, events, simulated_evaluator, study_so_far, undisturbed

from mobo_core.bag.collector import read_study

pytestmark = [pytest.mark.ros, pytest.mark.timeout(240)]

__all__ = ["undisturbed"]  # the fixture


def test_a_hung_evaluator_that_wakes_while_its_trial_is_open_has_it_counted(
    nodes: Nodes, tmp_path: Path, undisturbed: list[object]
) -> None:
    """Lost and woken with nobody else there: its answer to the first sending counts, lease expired or not."""
    bag = tmp_path / "bag"
    hung = simulated_evaluator(nodes, "hung", simulated_s=0.3)
    optimizer = nodes.optimizer(bag, n_trials=N, n_startup_trials=6)
    wait_for(lambda: told_so_far(bag) >= 2, "two trials")
    hung.send_signal(signal.SIGSTOP)
    wait_for(lambda: events(bag, "LOST", "hung"), "the loss")
    study = study_so_far(bag)
    assert study is not None
    sent = study.candidates[-1]
    assert int(sent.trial) not in study.trials
    hung.send_signal(signal.SIGCONT)
    assert finish(optimizer, 120) == 0, output(optimizer)
    assert values(bag) == undisturbed
    told = read_study(bag).trials[int(sent.trial)]
    assert (told.evaluator, int(told.attempt)) == ("hung", int(sent.attempt))


def test_stragglers_are_not_waited_for(nodes: Nodes, tmp_path: Path, undisturbed: list[object]) -> None:
    """Two candidates that would take hours go to a quick evaluator too, and the study ends without their answers."""
    bag = tmp_path / "bag"
    slow = simulated_evaluator(nodes, "slow", simulated_s=1e5, workers=2)
    optimizer = nodes.optimizer(bag, n_trials=N, n_startup_trials=6)
    wait_for(lambda: (study := study_so_far(bag)) and len(study.candidates) >= 2, "two candidates")
    simulated_evaluator(nodes, "quick", simulated_s=0.05)
    assert finish(optimizer, 120) == 0, output(optimizer)
    assert slow.poll() is None
    assert values(bag) == undisturbed
    study = read_study(bag)
    assert {trial.evaluator for trial in study.trials.values()} == {"quick"}
    assert sum(c.evaluator == "slow" for c in study.candidates) == 2
