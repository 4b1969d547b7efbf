"""The whole system under a seed: it keeps its promises, and a simulation that breaks one is found and made small."""

from __future__ import annotations

import dataclasses
import os
import subprocess
import sys
from collections.abc import Callable, Iterable
from pathlib import Path

import pytest
from studies import mobo

from mobo_core.bag import cut, writer
from mobo_core.bag.study_bag import StudyBag
from mobo_core.bag.writer import McapFile
from mobo_core.coordination import leases
from mobo_core.coordination.control import Controls
from mobo_core.coordination.dispatch import Dispatcher
from mobo_core.coordination.judge import Judge
from mobo_core.coordination.optimizer import Optimizer
from mobo_core.coordination.progress import Progress
from mobo_core.messages import Evaluation, Trial, decode
from mobo_core.search.study import OrderedStudy
from mobo_core.simulate import faults
from mobo_core.simulate.faults import KINDS, Fault, Plan, draw_plan
from mobo_core.simulate.simulation import Outcome, Simulation, simulate
from mobo_core.verify import evaluations

# The fixed set of `make test`; `make test-faults` takes fresh seeds for an hour.
SEEDS = (0, 3, 5, 8)
# Seeds that found something in mobo, and what.
FOUND_AMONG = tuple(KINDS)[: list(KINDS).index("stranger") + 1]
FOUND = {
    1: "an optimizer killed before its bag's first record was whole could not be resumed",
    40707: "nor one that was killed again while it made that file whole",
}


def quiet(seed: int, kinds: tuple[str, ...] = tuple(KINDS), n_trials: int = 24) -> Outcome:
    """Return what becomes of a seed by a sampler that compiles nothing."""
    plan = draw_plan(seed, kinds, n_trials)
    return simulate(dataclasses.replace(plan, settings=(*plan.settings, ("sampler", "random"))))


@pytest.mark.parametrize("seed", SEEDS)
def test_all_faults(seed: int) -> None:
    """A study with faults of all kinds ends as the undisturbed one."""
    outcome = quiet(seed)
    assert outcome.violation is None, "\n".join([str(outcome.violation), *outcome.trace])
    assert outcome.told == outcome.plan.n_trials


# Studies that found something, and what: in_flight, trials, workers, and what goes wrong.
FOUND_BY: dict[str, tuple[int, int, int, tuple[Fault, ...]]] = {
    "an evaluator's answer to an enqueued arm, which a cut took away, was taken for that of the arm of its number": (
        1, 8, 2,
        (Fault(13.375, "enqueue", 1.0, 0, 0.0), Fault(13.375, "slow_evaluator", 1.591, 0, 0.0783),
         Fault(14.937, "bag_cut", 1.0, 0, 0.8017)),
    ),
    "a bag that was resumed with later trials under way, and cut, did not verify": (
        8, 36, 3, (Fault(34.669, "kill_optimizer", 1.0, 0, 0.0), Fault(43.016, "bag_cut", 1.0, 0, 0.89)),
    ),
}  # fmt: skip


@pytest.mark.parametrize("seed", FOUND)
def test_what_was_found(seed: int) -> None:
    """Seeds that broke a promise break none any more."""
    outcome = quiet(seed, FOUND_AMONG, n_trials=0)
    assert outcome.violation is None, "\n".join([str(outcome.violation), *outcome.trace])
    assert outcome.told == outcome.plan.n_trials


@pytest.mark.parametrize("what", FOUND_BY)
def test_what_was_found_by_cutting(what: str) -> None:
    """Nor do studies drawn up for it."""
    in_flight, n_trials, workers, faults_of_it = FOUND_BY[what]
    settings = (("sampler", "random"), ("seed", 1), ("in_flight", in_flight), ("n_joints", 4))
    outcome = simulate(Plan(115, settings, n_trials, (workers,), 3.0, 500.0, faults_of_it))
    assert outcome.violation is None and outcome.told == n_trials, "\n".join([str(outcome.violation), *outcome.trace])


@pytest.mark.parametrize("kind", ["failing_arms", "convincing_liar", "bag_cut", "long_limit"])
def test_a_study_ends_and_verify_says_what_it_went_through(kind: str, tmp_path: Path) -> None:
    """Arms given up, lies, cuts and abandoned work come about; verify names the first two, and nothing else."""
    plan = draw_plan(0, (kind,), 24)
    simulation = Simulation(dataclasses.replace(plan, settings=(*plan.settings, ("sampler", "random"))), tmp_path)
    outcome = simulation.run()
    assert outcome.violation is None, "\n".join([str(outcome.violation), *outcome.trace])
    came_about = {
        "failing_arms": simulation.witness.exhausted,
        "convincing_liar": simulation.witness.lied,
        "bag_cut": list(tmp_path.glob("s_uncut*")),
        "long_limit": simulation.world.failures,
    }
    assert came_about[kind]


def test_a_seed_says_all() -> None:
    """A process with other hashes, at another time, sees the same things happen at the same moments."""
    code = "from test_simulate import quiet\nprint(*quiet(3).trace, sep='\\n')"
    environment = os.environ | {"PYTHONHASHSEED": "1", "PYTHONPATH": os.pathsep.join(sys.path)}
    there = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment)
    here = quiet(3).trace
    assert there.stdout.splitlines() == here and len(here) > 30


def _accept_all(monkeypatch: pytest.MonkeyPatch) -> None:
    def answered(self: Dispatcher, dispatch: leases.Dispatch, now: float, **said: bool) -> leases.Verdict:
        if (record := self._open.get(dispatch.trial)) is not None:
            record.sent.add(dispatch)
        return true(self, dispatch, now, **said)

    true = Dispatcher.answered
    monkeypatch.setattr(Dispatcher, "answered", answered)


def _tell_before_recording(monkeypatch: pytest.MonkeyPatch) -> None:
    def tell(self: Optimizer, trial: Trial) -> None:
        self._dispatcher.close(trial.trial)
        self._progress.tell(trial, self._urdfs.pop(trial.trial))
        self._publish("trials", b"")
        self._bag.append("trials", trial)

    monkeypatch.setattr(Optimizer, "_tell", tell)


def _lose_a_flush(monkeypatch: pytest.MonkeyPatch) -> None:
    def flush(self: writer._WholePieces) -> None:
        if self.flushes % 7 == 6:
            self.flushes += 1
        else:
            true(self)

    true = writer._WholePieces.flush
    monkeypatch.setattr(writer._WholePieces, "flush", flush)


def _renew_no_lease(monkeypatch: pytest.MonkeyPatch) -> None:
    def heard(self: Dispatcher, evaluator: str, *said: object) -> bool:
        known = self._evaluators.get(evaluator)
        until = {place: lease.until for place, lease in known.leases.items()} if known else {}
        new: bool = true(self, evaluator, *said)  # type: ignore[arg-type]
        for place, lease in self._evaluators[evaluator].leases.items():
            lease.until = until.get(place, lease.until)
        return new

    true = Dispatcher.heard
    monkeypatch.setattr(Dispatcher, "heard", heard)


def _resume_without_the_last(monkeypatch: pytest.MonkeyPatch) -> None:
    def past(self: StudyBag) -> object:
        study = true(self)
        if study is not None and study.trials:
            study.trials.pop(max(study.trials), None)
        return study

    true = StudyBag.past
    monkeypatch.setattr(StudyBag, "past", past)


def _tell_a_duplicate(monkeypatch: pytest.MonkeyPatch) -> None:
    def on_evaluation(self: Optimizer, data: bytes, now: float) -> None:
        known = set(self._told_from) if hasattr(self, "_told_from") else set()  # type: ignore[has-type]
        if data in known and (number := decode(Evaluation, data).trial) < len(self.study.told):
            self._bag.append("trials", Trial(study=self._bag.name, trial=number))
        self._told_from = known | {data}  # type: ignore[attr-defined]
        true(self, data, now)

    true = Optimizer.on_evaluation
    monkeypatch.setattr(Optimizer, "on_evaluation", on_evaluation)


def _see_too_much(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(OrderedStudy, "may_ask",
                        lambda self: len(self._told) >= len(self._asked) - self.settings.in_flight)  # fmt: skip
    monkeypatch.setattr(OrderedStudy, "_catch_up", lambda self, number: None)


def _forget_a_pause(monkeypatch: pytest.MonkeyPatch) -> None:
    def repeat(self: Controls, commands: object, asked: int) -> None:
        true(self, commands, asked)  # type: ignore[arg-type]
        self.paused = False

    true = Controls.repeat
    monkeypatch.setattr(Controls, "repeat", repeat)


def _last_answer_wins(monkeypatch: pytest.MonkeyPatch) -> None:
    def judge(self: Judge, evaluation: Evaluation, now: float, *, overdue: bool = False) -> bool:
        waits = evaluation.trial in self._progress._answers and evaluation.status == Evaluation.OK
        if waits:
            self._progress.answer(evaluation, "")
        return true(self, evaluation, now, overdue=overdue) or waits

    true = Judge.judge
    monkeypatch.setattr(Judge, "judge", judge)


def _never_wait_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """A lost evaluator's trials go to nobody."""
    wait = leases.Board.wait
    monkeypatch.setattr(leases.Board, "wait", lambda self, trial: None if self.open[trial].sent else wait(self, trial))


def _no_cutting_back(monkeypatch: pytest.MonkeyPatch) -> None:
    """After a write that failed, the bag goes on behind the torn piece."""

    def error(self: McapFile, error: OSError) -> Exception:
        return OSError(str(error))

    monkeypatch.setattr(McapFile, "_error", error)


def _never_tell_the_exhausted(monkeypatch: pytest.MonkeyPatch) -> None:
    """A trial whose attempts are used up is forgotten."""
    fail = Dispatcher._fail
    monkeypatch.setattr(Dispatcher, "_fail", lambda self, dispatch: fail(self, dispatch) and False)


def _give_up_too_soon(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(self: Dispatcher, dispatch: leases.Dispatch) -> bool:
        self.max_attempts -= 1
        try:
            return true(self, dispatch)
        finally:
            self.max_attempts += 1

    true = Dispatcher._fail
    monkeypatch.setattr(Dispatcher, "_fail", fail)


def _believe_all(monkeypatch: pytest.MonkeyPatch) -> None:
    """Verify evaluates again, and looks at nothing that comes of it."""
    monkeypatch.setattr(evaluations, "_different", lambda answer, result: iter(()))


def _cut_off_a_pause(monkeypatch: pytest.MonkeyPatch) -> None:
    """A bag that is cut loses the commands of before."""
    true = cut._kept
    kept = lambda messages, before: (m for m in true(messages, before) if m[1].kind != "Command")  # noqa: E731
    monkeypatch.setattr(cut, "_kept", kept)


def _forget_abandoned_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """What nobody waits for any more is taken to fill no place."""
    monkeypatch.setattr(leases.LiveEvaluator, "free", lambda self: self.slots - len(self.leases))


def _tell_another_value(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every eleventh value is a little off."""

    def due(self: Progress) -> Trial | None:
        trial = true(self)
        if trial is not None and trial.trial and trial.trial % 11 == 0:
            return dataclasses.replace(trial, reach=trial.reach + 1e-9)
        return trial

    true = Progress.due
    monkeypatch.setattr(Progress, "due", due)


# What is planted: the rules it may break, and faults that bring it to light.
BUGS: dict[Callable[[pytest.MonkeyPatch], None], tuple[tuple[str, ...], tuple[str, ...]]] = {
    _accept_all: (("told from its answer", "same study"), ("stranger",)),
    _tell_before_recording: (("recorded before effect",), ("delay",)),
    _lose_a_flush: (("recorded before effect",), ("delay",)),
    _renew_no_lease: (("leases",), ("slow_evaluator",)),
    _resume_without_the_last: (
        ("told once", "recorded before effect", "no crash", "order", "liveness"),
        ("kill_optimizer",),
    ),
    _tell_a_duplicate: (("told once",), ("duplicate",)),
    _see_too_much: (("order", "no crash"), ("delay",)),
    _forget_a_pause: (("order",), ("pause", "kill_optimizer")),
    _last_answer_wins: (("told from its answer",), ("duplicate", "slow_evaluator", "stranger")),
    _never_wait_again: (("liveness",), ("kill_evaluator",)),
    _no_cutting_back: (("no crash",), ("disk_full",)),
    _tell_another_value: (("same study",), ("delay",)),
    _never_tell_the_exhausted: (("liveness",), ("failing_arms",)),
    _give_up_too_soon: (("told from its answer",), ("dying_workers", "failing_arms")),
    _believe_all: (("verify names liars",), ("convincing_liar",)),
    _cut_off_a_pause: (("nothing is lost",), ("pause", "enqueue", "bag_cut")),
    _forget_abandoned_work: (("places",), ("long_limit",)),
}


def found(bug: Callable[[pytest.MonkeyPatch], None], seeds: Iterable[int], kinds: tuple[str, ...]) -> int | None:
    """Return the first seed that breaks a rule which the bug breaks; None if no seed breaks any."""
    for seed in seeds:
        outcome = quiet(seed, kinds)
        if outcome.violation is not None:
            assert outcome.violation.rule in BUGS[bug][0], "\n".join([str(outcome.violation), *outcome.trace])
            return seed
    return None


@pytest.mark.parametrize("bug", BUGS, ids=lambda bug: bug.__name__.strip("_"))
def test_bugs_planted_on_purpose(bug: Callable[[pytest.MonkeyPatch], None], monkeypatch: pytest.MonkeyPatch) -> None:
    """Each is found; `make test-faults` finds them anew among all kinds of faults, within a minute each."""
    bug(monkeypatch)
    assert found(bug, range(40), BUGS[bug][1]) is not None


def test_a_violation_is_shown_small(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """The command names the seed, the few faults that are enough, and what happened; exit code 1."""
    monkeypatch.setattr(faults, "SAMPLERS", ("random",))
    _resume_without_the_last(monkeypatch)
    kinds = ("kill_optimizer", "wall_clock")
    seed = found(_resume_without_the_last, range(40), kinds)
    assert mobo("simulate", "--seed", str(seed), "--faults", ",".join(kinds), "--trials", "24") == 1
    shown = capsys.readouterr().out
    assert f"VIOLATION, seed {seed}: " in shown and "optimizer killed" in shown
    assert "  1 of " in shown and "fault: wall_clock" not in shown


def test_the_command(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """It says what was survived, lists the faults, and refuses others."""
    monkeypatch.setattr(faults, "SAMPLERS", ("random",))
    assert mobo("simulate", "--seed", "4", "--faults", "loss", "--trials", "12") == 0
    assert "good: seed 4, 12 trials told" in capsys.readouterr().out
    assert mobo("simulate", "--faults", "list") == 0
    assert capsys.readouterr().out.count("\n") == len(KINDS)
    assert mobo("simulate", "--faults", "flood") == 2
    assert mobo("simulate", "--minutes", "-1") == 2
