"""`verify` sees every lie that changes what a study says; an honest bag, however it came about, has none."""

from __future__ import annotations

import functools
import json
import shutil
from collections.abc import Callable, Iterator
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from nodes import values
from studies import mobo, run_study

from mobo_core.bag import study_bag
from mobo_core.bag.collector import read_study
from mobo_core.bag.files import METADATA_FILE
from mobo_core.bag.reader import Entry, read_bag
from mobo_core.bag.study_bag import StudyBag
from mobo_core.bag.writer import McapFile
from mobo_core.coordination.answer import Answering
from mobo_core.coordination.dispatch import Dispatcher
from mobo_core.coordination.optimizer import Optimizer
from mobo_core.messages import (
    KINDS,
    TOPICS,
    Candidate,
    Command,
    Evaluation,
    EvaluatorStatus,
    Header,
    SpecMessage,
    StudyStatus,
    decode,
    encode,
)
from mobo_core.search.study import StudySettings
from mobo_core.verify import records
from mobo_core.verify.spot import SpotCheck
from mobo_core.verify.verify import verify

N = 12
SETTINGS: dict[str, Any] = {
    "sampler": "random", "in_flight": 4, "engine": "simulated", "spec": {"poses_per_voxel": 2},
}  # fmt: skip

Messages = list[tuple[str, Any]]  # (kind, message)


@pytest.fixture(scope="module", autouse=True)
def _xacro_once() -> Iterator[None]:
    """Each arm's URDF is made once, not in each test."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(records, "to_urdf", functools.cache(records.to_urdf))
        yield


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study whose values any machine makes at once, with a pause, an enqueued arm and its last word."""
    return recorded(tmp_path_factory.mktemp("lies") / "bag", N)


def recorded(folder: Path, n_trials: int) -> Path:
    settings = StudySettings.of(SETTINGS)
    store = StudyBag(folder, "study", settings, resume=False)
    sent: list[Candidate] = []

    def publish(topic: str, data: bytes) -> None:
        sent.extend([decode(Candidate, data)] if topic == "candidates" else [])

    optimizer = Optimizer(store, settings, n_trials, Dispatcher(), publish, log=lambda line: None)
    optimizer.record_status(StudyStatus.RUNNING)
    now = 0.0
    while not optimizer.done:
        now += 0.5
        for name in ("anna", "bob"):
            status = EvaluatorStatus(evaluator=name, workers=2, engine="simulated", studies=[], host_id="h")
            optimizer.on_evaluator(encode(status), now)
        told = len(optimizer.study.told)
        if told == 3:
            optimizer.controls.pause(len(optimizer.study.asked), "me")
            optimizer.controls.enqueue(
                len(optimizer.study.asked), "me", "YPPYPY", (0.05, 0.25, 0.2, 0.05, 0.0, 0.05), n_trials
            )
            optimizer.controls.resume(len(optimizer.study.asked), "me")
        if sent:
            candidate = sent.pop(0)
            answer = Answering(candidate.evaluator, "simulated", simulated_s=0.0).answer(candidate)
            optimizer.on_evaluation(encode(answer), now)
    optimizer.end()
    store.close()
    return folder


def messages_of(bag: Path) -> Messages:
    return [(e.kind, decode(KINDS[e.kind], e.data)) for content in read_bag(bag) for e in content.entries]


def written(folder: Path, record: dict[str, str], messages: Messages) -> Path:
    """Write messages as a bag of one file, with a hash chain that fits: a liar has that too."""
    folder.mkdir()
    file = McapFile(folder / f"{folder.name}_0.mcap", record)
    topics = {cls.kind: topic for topic, cls in TOPICS.items()}
    for kind, message in messages:
        file.write(f"/{topics[kind]}", kind, encode(message))
    file.finish()
    return folder


def faults(folder: Path) -> list[str]:
    return [str(fault) for fault in verify(read_study(folder), workers=1).faults]


def test_an_honest_bag_has_no_fault(bag: Path) -> None:
    """Pauses and enqueued arms included; the hash chain is whole."""
    found = verify(read_study(bag), workers=1)
    assert not found.faults and found.notes == ["hash chain whole"] and found.evaluations == found.trials == N


def at(kind: str, number: int) -> Callable[[Messages], int]:
    """Return where message ``number`` of a kind stands."""
    return lambda messages: [i for i, (is_, _) in enumerate(messages) if is_ == kind][number]


def changed(kind: str, number: int, **fields: Any) -> Callable[[Messages], None]:
    """Set fields of a message."""

    def change(messages: Messages) -> None:
        message = messages[at(kind, number)(messages)][1]
        for name, value in fields.items():
            setattr(message, name, value(message) if callable(value) else value)

    return change


def _reversed(messages: Messages) -> None:
    messages.reverse()


def _told_first(messages: Messages) -> None:
    """Every Trial before its Evaluation."""
    for number in range(N):
        trial = messages.pop(at("Trial", number)(messages))
        where = next(i for i, (kind, m) in enumerate(messages) if kind == "Evaluation" and m.trial == number)
        messages.insert(where, trial)


def _swapped(messages: Messages) -> None:
    one, other = at("Trial", 6)(messages), at("Trial", 7)(messages)
    messages[one], messages[other] = messages[other], messages[one]


def _asked_early(messages: Messages) -> None:
    """A candidate before the trial that it had to wait for."""
    candidate = messages.pop(at("Candidate", 8)(messages))
    messages.insert(at("Trial", 4)(messages), candidate)


def _failed(times: int, status: int, **more: Any) -> Callable[[Messages], None]:
    """A stranger answers trial 5 in its evaluator's place, as often as it takes."""

    def change(messages: Messages) -> None:
        where = at("Evaluation", 5)(messages)
        good = messages[where][1]
        sent = messages[at("Candidate", 5)(messages)][1]
        answers: Messages = []
        for attempt in range(1, times + 1):
            if attempt > 1:
                answers.append(("Candidate", decode(Candidate, encode(sent))))
                answers[-1][1].attempt = attempt
            fields = {"reason": "it broke", "mobo_version": "0.1.0", "host_id": "h", **more}
            answers.append(("Evaluation", Evaluation(
                study="study", trial=5, attempt=attempt, evaluator=good.evaluator, status=status, **fields
            )))  # fmt: skip
        messages[where : where + 1] = answers
        reason = f"rejected: {fields['reason']}" if status == 1 else fields["reason"]
        changed("Trial", 5, state=1, attempt=times, reach=np.nan, torque=np.nan, reason=reason)(messages)
        changed("StudyStatus", -1, failed=1)(messages)

    return change


def _answer_deleted(messages: Messages) -> None:
    del messages[at("Evaluation", 5)(messages)]
    changed("Trial", 5, state=1, reach=np.nan, torque=np.nan, reason="it broke")(messages)


def _second_answer(messages: Messages) -> None:
    """Another answer to the same sending, told already: sound, and different."""
    where = at("Evaluation", 5)(messages)
    other = decode(Evaluation, encode(messages[where][1]))
    other.voxel_torque = other.voxel_torque * 0.5
    other.torque = float(np.sum(other.voxel_torque))
    messages.insert(at("Trial", 5)(messages) + 1, ("Evaluation", other))


def _inserted(kind: str, number: int, message: Callable[[], Any]) -> Callable[[Messages], None]:
    return lambda messages: messages.insert(at(kind, number)(messages), (message().kind, message()))


def _again(kind: str, number: int) -> Callable[[Messages], None]:
    """A message once more, right behind itself."""

    def change(messages: Messages) -> None:
        where = at(kind, number)(messages)
        messages.insert(where + 1, messages[where])

    return change


def _cut_tail(messages: Messages) -> None:
    """The last trial and all of it are gone, its study's last word is not."""
    messages[:] = [(kind, m) for kind, m in messages if getattr(m, "trial", 0) != N - 1 or kind == "Command"]


def _without(kind: str) -> Callable[[Messages], None]:
    def change(messages: Messages) -> None:
        messages[:] = [(is_, m) for is_, m in messages if is_ != kind]

    return change


LIES: dict[str, tuple[Callable[[Messages], None], str]] = {
    "all reversed": (_reversed, "trial 11, trial: told when it was the turn of trial 0"),
    "trials before their evaluations": (_told_first, "no good answer of the attempt it names had come"),
    "two trials swapped": (_swapped, "trial 7, trial: told when it was the turn of trial 6"),
    "asked too early": (_asked_early, "trial 8, candidate: sent out before trial 4 was told"),
    "failed thrice by a stranger": (_failed(3, 2), "trial 5, state: told as failed (attempt 3 on"),
    "failed once": (_failed(1, 2), "trial 5, state: told as failed, though 1 of 3 attempts had failed"),
    "rejected by a stranger": (_failed(1, 1), "trial 5, status: attempt 1 on"),
    "timed out": (_failed(3, 2, reason="timed out after 600 s", host_id="", mobo_version=""), "no lie, a slow host"),
    "answer deleted, told as failed": (_answer_deleted, "trial 5, state: told as failed, though 0 of 3"),
    "a second answer that differs": (_second_answer, "answered more than once, and not the same"),
    "audit figures": (changed("Evaluation", 4, audit_poses=9), "trial 4, audit_poses"),
    "audit error": (changed("Evaluation", 4, audit_max_error=0.5), "trial 4, audit_max_error"),
    "told twice": (_again("Trial", 4), "trial 4, trial: told more than once"),
    "told a number far off": (changed("Trial", N - 1, trial=2**32 - 1), f"trial {N - 1}, trial: was never told"),
    "study of a trial": (changed("Trial", 4, study="other"), "trial 4, study: 'other'"),
    "study of an evaluation": (changed("Evaluation", 4, study="other"), "trial 4, study: 'other'"),
    "study of a status": (changed("StudyStatus", 0, study="other"), "study: 'other'"),
    "reason of a complete trial": (changed("Trial", 4, reason="well"), "trial 4, reason"),
    "state of a trial": (changed("Trial", 4, state=7), "trial 4, state: 7"),
    "extra names": (changed("Trial", 4, extra_names=["mass"]), "trial 4, extra_names"),
    "evaluator of a trial": (changed("Trial", 4, evaluator="eve"), "trial 4, attempt: attempt 1 on eve was never"),
    "schema_version": (changed("Candidate", 4, schema_version=1), "trial 4, schema_version"),
    "tip": (changed("Candidate", 4, tip="link_3"), "trial 4, tip"),
    "engine": (changed("Candidate", 4, engine="kernel"), "trial 4, engine"),
    "objectives": (changed("Candidate", 4, objectives=["reach", "mass"]), "trial 4, objectives"),
    "attempt": (changed("Candidate", 4, attempt=2), "trial 4, attempt: 2 is sending number 1"),
    "evaluator that never joined": (changed("Candidate", 4, evaluator="eve"), "'eve' was sent it without having"),
    "sent after it was told": (_again("Candidate", 0), "trial 0, attempt: 1 is sending number 2"),
    "an unknown command": (changed("Command", 0, command="erase"), "command: unknown: 'erase'"),
    "a pause twice": (_again("Command", 0), "pause, though it was paused"),
    "a resume without a pause": (_inserted("Trial", 5, lambda: _command("resume", 9)), "though it was not paused"),
    "sent during a pause": (_inserted("Candidate", 9, lambda: _command("pause", 9)), "sent out during a pause"),
    "enqueued too late": (_inserted("Trial", 5, lambda: _command("enqueue", 2)), "trial 2, command: enqueued after"),
    "status: told": (changed("StudyStatus", -1, told=N - 1), "its status says told 11"),
    "status: front": (changed("StudyStatus", -1, front_size=99), "its status says front_size 99"),
    "status: hypervolume": (changed("StudyStatus", -1, hypervolume=0.99), "its status says hypervolume"),
    "status: best": (changed("StudyStatus", -1, best_reach=lambda m: m.best_reach + 1e-6), "says best_reach"),
    "status: done too early": (changed("StudyStatus", -1, n_trials=20), "done with 12 of 20"),
    "status: state": (changed("StudyStatus", 0, state=9), "state 9"),
    "a cut tail": (_cut_tail, "its status says told 12, but the bag holds 11"),
    "nobody joined": (_without("EvaluatorStatus"), "without having joined"),
    "evaluator's state": (changed("EvaluatorStatus", 0, state=0), "in state 0, which is not recorded"),
    "no evaluations": (_without("Evaluation"), "no good answer"),
    "status: stopped, though done": (changed("StudyStatus", -1, state=3), "stopped with 12 of 12"),
    "status: more trials from the beginning": (changed("StudyStatus", 0, n_trials=11), "in a study of 11 trials"),
    "joined twice": (_again("EvaluatorStatus", 0), "'anna' joined more than once"),
    "seconds": (changed("Evaluation", 4, seconds=np.nan), "trial 4, seconds"),
    "workers": (changed("EvaluatorStatus", 0, workers=0), "joined with 0 workers"),
}


# What verify takes as it is said; docs/operations.md says why. Stamps are clocks', which may be set.
UNCOVERED = {
    "StudyStatus": {"workers", "answers", "answers_unused", "bag"},
    "EvaluatorStatus": {
        "workers", "threads", "kernel_hash", "objectives", "answered", "mobo_version", "host_id", "pid",
    },
    "Evaluation": {"seconds", "mobo_version", "host_id"},
    "Command": {"source"},
}  # fmt: skip
_STAMP = Header.at(0)


def _flipped(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return np.append(value[:-1], value[-1:] + 1) if value.size else np.ones(1, value.dtype)
    if isinstance(value, list):
        return [*value, "x"]
    if isinstance(value, SpecMessage):
        return replace(value, seed=value.seed + 1)
    if isinstance(value, Header):
        return replace(value, frame_id="tool")
    return value + ("x" if isinstance(value, str) else 1)


def test_every_field_of_every_message_is_covered_or_named(tmp_path: Path) -> None:
    """Flipped one at a time, and those that verify takes as they are said all at once."""
    bag = recorded(tmp_path / "bag", 5)
    record, honest = read_bag(bag)[0].record, messages_of(bag)
    uncovered, number = messages_of(bag), 0
    for where in {kind: at(kind, -1)(honest) for kind, _ in honest}.values():
        kind, message = honest[where]
        for name in (part.name for part in fields(message)):
            flipped = _flipped(getattr(message, name))
            if name in UNCOVERED.get(kind, ()):
                setattr(uncovered[where][1], name, flipped)
                continue
            lie = [*honest]
            lie[where] = kind, replace(message, **{name: flipped})
            number += 1
            assert faults(written(tmp_path / f"{number}", record, lie)), f"{kind}.{name}"
        uncovered[where][1].header.stamp = _STAMP.stamp
    assert number > 50 and not faults(written(tmp_path / "all", record, uncovered))
    table = (Path(__file__).parents[1] / "docs" / "operations.md").read_text()
    assert all(f"`{name}`" in table for names in UNCOVERED.values() for name in names)


@pytest.mark.parametrize("value", ["[" * 100_000, "[1]", "1" + "0" * 400, "NaN", "{}", '"J"', "null", "true"])
def test_parameters_that_are_none_are_a_fault(bag: Path, tmp_path: Path, value: str) -> None:
    """As a whole, or in the place of a number: nothing else ends."""
    messages = messages_of(bag)
    known = json.loads(messages[at("Candidate", 4)(messages)][1].params_json)
    last = list(known)[-1]
    for number, text in enumerate((value, json.dumps(known).replace(json.dumps(known[last]), value))):
        changed("Candidate", 4, params_json=text)(messages)
        found = faults(written(tmp_path / f"{number}", read_bag(bag)[0].record, messages))
        assert any(fault.startswith("trial 4, params_json") for fault in found)


def test_a_record_does_not_pass_for_an_older_mobos(bag: Path, tmp_path: Path) -> None:
    """A failure of one attempt, of which an older mobo's record would not say how many it took."""
    messages, record = messages_of(bag), read_bag(bag)[0].record
    LIES["failed once"][0](messages)
    del record["max_attempts"]
    assert "bag_0.mcap: its record does not say max_attempts" in faults(written(tmp_path / "bag", record, messages))


def _command(name: str, trial: int) -> Command:
    return Command(study="study", trial=trial, command=name, arguments_json="{}")


@pytest.mark.parametrize("lie", LIES)
def test_a_lie_is_found_and_named(bag: Path, tmp_path: Path, lie: str) -> None:
    """Though every record and the hash chain fit the changed messages."""
    change, said = LIES[lie]
    messages = messages_of(bag)
    change(messages)
    found = faults(written(tmp_path / "bag", read_bag(bag)[0].record, messages))
    assert any(said in fault for fault in found), found


def test_the_same_messages_written_again_are_no_lie(bag: Path, tmp_path: Path) -> None:
    """So what the lies above are found by is their change."""
    assert not faults(written(tmp_path / "bag", read_bag(bag)[0].record, messages_of(bag)))


def test_an_answer_that_came_twice_is_no_lie(bag: Path, tmp_path: Path) -> None:
    """The network may double it, and strangers may answer what they were not asked."""
    messages = messages_of(bag)
    _again("Evaluation", 3)(messages)
    stranger = decode(Evaluation, encode(messages[at("Evaluation", 3)(messages)][1]))
    stranger.evaluator = "eve"
    messages.insert(at("Trial", 3)(messages), ("Evaluation", stranger))
    assert not faults(written(tmp_path / "bag", read_bag(bag)[0].record, messages))


RECORD_LIES: dict[str, tuple[dict[str, str], str]] = {
    "seed": ({"seed": "5"}, "its record says seed 5"),
    "study": ({"study": "other"}, "is of study 'other'"),
    "spec": ({"spec": "{}"}, "its record says spec"),
    "schema_version": ({"schema_version": "1"}, "its record says schema_version '1'"),
    "versions": ({"versions": "[1]"}, "versions in its record"),
    "deep versions": ({"versions": "[" * 100_000}, "versions in its record"),
    "max_attempts": ({"max_attempts": "many"}, "its record says max_attempts"),
    "no number": ({"in_flight": "x"}, "in_flight"),
}


@pytest.fixture(scope="module")
def two_files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bag of two sessions, the first of them killed."""
    folder = tmp_path_factory.mktemp("two") / "bag"
    run_study(folder, 6, settings=SETTINGS, kill_after=4)
    return run_study(folder, 9, settings=SETTINGS, resume=True)


@pytest.mark.parametrize("lie", RECORD_LIES)
def test_the_record_of_every_file_counts(two_files: Path, tmp_path: Path, lie: str) -> None:
    """The second file may not say another thing than the first."""
    change, said = RECORD_LIES[lie]
    copy = Path(shutil.copytree(two_files, tmp_path / "bag"))
    rewritten(copy / "bag_1.mcap", record=change)
    found = faults(copy)
    assert any(said in fault for fault in found), found


def rewritten(
    path: Path, record: dict[str, str] | None = None, change: Callable[[list[Entry]], None] = lambda entries: None
) -> None:
    """Write a file anew with another record or other messages, its own hash as it should be."""
    content = read_bag(path)[0]
    path.unlink()
    file = McapFile(path, content.record | (record or {}), chain=content.chain)
    change(content.entries)
    for entry in content.entries:
        file.copy(entry.channel, entry.data, entry.time_ns)
    file.finish()


def test_the_chain_tells_whole_bags_from_changed_ones(two_files: Path, tmp_path: Path) -> None:
    """A whole one is whole; a file that was written anew, taken away, or is another bag's does not fit."""
    assert not faults(two_files)

    def copy(name: str) -> Path:
        folder = Path(shutil.copytree(two_files, tmp_path / name / "bag"))
        (folder / METADATA_FILE).unlink()
        return folder

    later = copy("time")  # a message that nothing else depends on: only its time
    rewritten(later / "bag_0.mcap", change=lambda e: e.__setitem__(0, Entry(e[0].topic, e[0].kind, 1, *_rest(e[0]))))
    assert any("follows another file than bag_0.mcap" in fault for fault in faults(later))
    alone = copy("alone")
    (alone / "bag_0.mcap").unlink()
    assert any("follows a file that is not there" in fault for fault in faults(alone))
    swapped = copy("swapped")
    run_study(tmp_path / "other" / "bag", 6, settings=SETTINGS, kill_after=4)
    assert mobo("bag", "recover", tmp_path / "other" / "bag") == 0
    shutil.copy(tmp_path / "other" / "bag" / "bag_0.mcap", swapped)
    assert any("follows another file" in fault for fault in faults(swapped))


def _rest(entry: Entry) -> tuple[Any, ...]:
    return entry.data, entry.channel


@pytest.mark.parametrize("words", [["compact"], ["recover"]])
def test_compact_and_recover_begin_the_chain_anew_and_say_so(two_files: Path, tmp_path: Path, words: list[str]) -> None:
    """Without a fault, and the study goes on from there without one."""
    copy = Path(shutil.copytree(two_files, tmp_path / "bag"))
    if words == ["recover"]:
        first = copy / "bag_0.mcap"
        first.write_bytes(first.read_bytes()[:-30])
    assert mobo("bag", *words, copy) == 0
    run_study(copy, 11, settings=SETTINGS, resume=True)
    found = verify(read_study(copy), workers=1)
    assert not found.faults
    assert found.notes[0].startswith(f"hash chain begins anew in bag_0.mcap: '{words[0]}")


def test_a_bag_that_rolls_over_is_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A session of many files is one, and a chain."""
    monkeypatch.setattr(study_bag, "_MAX_CHUNKS", 12)
    bag = run_study(tmp_path / "bag", 8, settings=SETTINGS)
    assert len(list(bag.glob("*.mcap"))) > 2
    assert not faults(bag) and not mobo("bag", "compact", bag) and not faults(bag)


@pytest.mark.parametrize("field", ["message_count", "relative_file_paths", "custom_data"])
def test_metadata_that_differs_from_the_files_is_found(two_files: Path, tmp_path: Path, field: str) -> None:
    """And recover mends it."""
    copy = Path(shutil.copytree(two_files, tmp_path / "bag"))
    text = yaml.safe_load((copy / METADATA_FILE).read_text())
    information = text["rosbag2_bagfile_information"]
    wrong = {"message_count": 7, "relative_file_paths": ["bag_0.mcap"], "custom_data": {"mobo_seed": "7"}}
    information[field] = wrong[field]
    (copy / METADATA_FILE).write_text(yaml.safe_dump(text))
    assert faults(copy) == [f"metadata.yaml: its {field} is not that of the files; mobo bag recover writes it anew"]
    assert mobo("bag", "recover", copy) == 0 and not faults(copy)


def test_a_changed_definition_is_found(bag: Path, tmp_path: Path) -> None:
    """Of which units are in its comments, or of which the type is said to be another."""
    copy = Path(shutil.copytree(bag, tmp_path / "bag"))
    (copy / METADATA_FILE).unlink()

    def change(entries: list[Entry]) -> None:
        for i, entry in enumerate(entries):
            if entry.kind == "Trial":
                channel = entry.channel._replace(definition=entry.channel.definition + b"# torque in kg\n")
                entries[i] = Entry(entry.topic, entry.kind, entry.time_ns, entry.data, channel)

    rewritten(copy / "bag_0.mcap", change=change)
    assert any("its definition is not mobo's" in fault for fault in faults(copy))


def test_the_command_names_the_remedy(bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Exit code 1, and from which trial on to ask anew."""
    messages = messages_of(bag)
    LIES["rejected by a stranger"][0](messages)
    copy = written(tmp_path / "bag", read_bag(bag)[0].record, messages)
    assert mobo("verify", copy, "--workers", "1") == 1
    assert f"mobo bag cut {copy} --before 5 keeps what came before" in capsys.readouterr().err


def test_an_honest_study_by_the_reference_engine_verifies_by_it(tmp_path: Path) -> None:
    """Its candidates say which engine was to answer."""
    spec = {"voxel_size": 0.6, "poses_per_voxel": 1, "restarts": 0, "iterations": 10, "workspace_min": [0.0, 0.0, 0.0],
            "workspace_max": [0.6, 0.6, 0.6]}  # fmt: skip
    settings = {**SETTINGS, "engine": "reference", "spec": spec}
    bag = run_study(tmp_path / "bag", 3, settings=settings, engine="reference")
    study = read_study(bag)
    assert {candidate.engine for candidate in study.candidates} == {"reference"}
    assert not verify(study, workers=1).faults


@pytest.mark.parametrize("before", [0, 1, 5, N])
def test_a_bag_cut_before_a_trial_goes_on_as_the_honest_study(bag: Path, tmp_path: Path, before: int) -> None:
    """What a liar made of trial 5 is gone, it verifies, and resumed it comes to the honest study's trials."""
    messages = messages_of(bag)
    if before <= 5:
        LIES["failed thrice by a stranger"][0](messages)
    copy = written(tmp_path / "bag", read_bag(bag)[0].record, messages)
    (copy / "notes.txt").write_text("mine")
    assert mobo("bag", "cut", copy, "--before", before) == 0
    cut = verify(read_study(copy), workers=1)
    assert not cut.faults and cut.trials == before and "begins anew" in cut.notes[0]
    assert (copy / "notes.txt").read_text() == "mine" and len(read_study(tmp_path / "bag_uncut").trials) == N
    run_study(copy, N, settings=SETTINGS, resume=True)
    assert not faults(copy)
    if before > 3:  # the enqueued arm is part of it
        assert values(copy) == values(bag)


def test_a_bag_is_not_cut_behind_its_end(bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """One line, exit code 2, nothing touched."""
    copy = Path(shutil.copytree(bag, tmp_path / "bag"))
    for before in (N + 1, -1):
        assert mobo("bag", "cut", copy, "--before", before) == 2
        assert capsys.readouterr().err.count("\n") == 1
    assert not faults(copy) and not list(tmp_path.glob("*uncut*"))


def test_a_look_at_a_bag_that_goes_on_finds_what_does_not_verify(
    bag: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a process of its own: nothing of an honest one, the trial and the remedy of another."""
    monkeypatch.setattr("mobo_core.verify.spot._PATIENCE_S", 100.0)  # on a busy machine too
    messages = messages_of(bag)
    LIES["rejected by a stranger"][0](messages)
    copy = written(tmp_path / "bag", read_bag(bag)[0].record, messages)
    looks = [SpotCheck(folder) for folder in (bag, copy)]
    honest, lied = (look.lines(wait=True) for look in looks)
    assert not honest and not looks[1].lines()
    assert lied[0].startswith("trial 5, status: ") and lied[-1].endswith(f"cut {copy} --before 5 is the remedy")
