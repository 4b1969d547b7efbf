"""Evaluators that are killed, or hang and wake up again."""

from __future__ import annotations

import random
import signal
from pathlib import Path
from typing import Any

import pytest
import yaml
from nodes import QUICK_SPEC, Nodes, finish, output, told_so_far, values, wait_for
from peer import Peer
from studies import run_study

from mobo_core.bag.collector import read_study
from mobo_core.bag.record import StudyRecord
from mobo_core.messages import EvaluatorStatus

pytestmark = pytest.mark.ros

N = 14
SETTINGS = {"spec": yaml.safe_load(QUICK_SPEC), "n_startup_trials": 6, "sampler": "structured"}  # as nodes have it


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> list[tuple[Any, ...]]:
    """The trials of the study that all others here must equal."""
    return values(run_study(tmp_path_factory.mktemp("quiet") / "bag", N, name="s", settings=SETTINGS))


def simulated_evaluator(nodes: Nodes, name: str, simulated_s: float = 0.1, workers: int = 1) -> Any:
    return nodes.start("evaluator", f"__node:={name}", engine="simulated", simulated_s=simulated_s, workers=workers)


def study_so_far(bag: Path) -> StudyRecord | None:
    """Return what a bag that is being written holds, if it can be read yet."""
    return read_study(bag) if told_so_far(bag) or any(bag.glob("*.mcap")) else None


def events(bag: Path, state: str, name: str) -> int:
    study = study_so_far(bag)
    wanted = getattr(EvaluatorStatus, state)
    return sum(e.state == wanted and e.evaluator == name for e in study.evaluators) if study else 0


def answers_of(bag: Path, *sending: object) -> list[Any]:
    """Return the answers recorded to one sending: (trial, attempt, evaluator)."""
    return [e for e in read_study(bag).evaluations if (int(e.trial), int(e.attempt), e.evaluator) == sending]


def test_a_random_one_killed_again_and_again(nodes: Nodes, tmp_path: Path, undisturbed: list[object]) -> None:
    """One of three is killed every few trials and replaced: each trial is told once, with the same values."""
    bag, chance = tmp_path / "bag", random.Random(1)
    optimizer = nodes.optimizer(bag, n_trials=N, n_startup_trials=6)
    running = [simulated_evaluator(nodes, f"e{i}") for i in range(3)]
    for told in range(2, N - 3, 4):
        wait_for(lambda told=told: told_so_far(bag) >= told or optimizer.poll() is not None, f"{told} trials")
        place = chance.randrange(3)
        running[place].kill()
        running[place].wait()
        running[place] = simulated_evaluator(nodes, f"e{place}_{told}")
    assert finish(optimizer) == 0, output(optimizer)
    assert values(bag) == undisturbed
    assert sorted(read_study(bag).trials) == list(range(N))


def test_a_hung_evaluator_is_noticed_and_its_late_answer_does_not_count(
    nodes: Nodes, peer: Peer, tmp_path: Path, undisturbed: list[object]
) -> None:
    """Stopped, it is lost; its trial is told by another; woken, its answer is recorded and not applied."""
    bag = tmp_path / "bag"
    hung = simulated_evaluator(nodes, "hung", simulated_s=5.0)  # long enough to be stopped meanwhile
    optimizer = nodes.optimizer(bag, n_trials=N, n_startup_trials=6)
    peer.until(lambda: any(len(beat.trials) for beat in peer.heard.get("evaluators", [])), "it to say what it holds")
    hung.send_signal(signal.SIGSTOP)
    wait_for(lambda: events(bag, "LOST", "hung"), "the loss")
    study = study_so_far(bag)
    assert study is not None
    sent = study.candidates[-1]
    trial, attempt = int(sent.trial), int(sent.attempt)
    good = simulated_evaluator(nodes, "good", simulated_s=1.0)
    wait_for(lambda: told_so_far(bag) > trial, "the trial from the other")
    good.kill()  # the study shall not end before the other has come back
    hung.send_signal(signal.SIGCONT)
    wait_for(lambda: events(bag, "JOINED", "hung") == 2, "its return")
    wait_for(lambda: answers_of(bag, trial, attempt, "hung"), "its late answer")
    simulated_evaluator(nodes, "last", simulated_s=0.0)
    assert finish(optimizer) == 0, output(optimizer)
    assert values(bag) == undisturbed
    study = read_study(bag)
    assert (study.trials[trial].evaluator, int(study.trials[trial].attempt)) == ("good", attempt + 1)
    assert len(answers_of(bag, trial, attempt, "hung")) == 1
