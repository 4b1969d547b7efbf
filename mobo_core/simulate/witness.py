"""Watches a bag as it grows on the disk, message by message, and what takes effect: nothing may before it is there."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator
from io import BytesIO
from itertools import count
from pathlib import Path

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Message, Schema
from mcap.writer import MCAP0_MAGIC

from mobo_core.bag.chunks import Budget, opened
from mobo_core.bag.files import number_of
from mobo_core.bag.reader import read_file
from mobo_core.bag.validity import evaluation_fault
from mobo_core.coordination.control import enqueued_params
from mobo_core.coordination.optimizer import Optimizer
from mobo_core.messages import Candidate, Command, Evaluation, Trial, decode
from mobo_core.search.study import Params, StudySettings
from mobo_core.simulate.oracle import Oracle
from mobo_core.simulate.violation import Violation

_HEAD = struct.Struct("<BQ")
_CHUNK = int(Opcode.CHUNK)
# Of what the optimizer publishes, this is in the bag.
_RECORDED = ("candidates", "trials", "commands")

Key = tuple[int, int, str]  # trial, attempt, evaluator


class Witness:
    """Holds what a bag says, in its order, against the rules and against the undisturbed study.

    Args:
        folder: of the bag.
        settings: of the study.
        oracle: of the same.

    Attributes:
        folder: of the bag.
        told: trials that the bag tells.
        sent: what the bag says was sent out.
    """

    def __init__(self, folder: Path, settings: StudySettings, oracle: Oracle) -> None:
        self.folder, self._settings, self._oracle = folder, settings, oracle
        self._raw: list[tuple[str, bytes]] = []
        self._file: Path | None = None
        self._at = 0
        self._channels: dict[int, str] = {}
        self._forget()

    def _forget(self) -> None:
        self.told = 0
        self.sent: set[Key] = set()
        self._attempts: dict[int, int] = {}
        self._asked = 0
        self._answers: dict[int, Evaluation] = {}
        self._enqueued: dict[int, Params] = {}
        self._paused = False
        self._raw = []

    def published(self, topic: str, data: bytes) -> None:
        """See that what is published on a topic now was recorded before."""
        if topic not in _RECORDED:
            return
        self.follow()
        if not any(known == topic and message == data for known, message in reversed(self._raw[-4:])):
            raise Violation("recorded before effect", f"a message on {topic} is published, but not in the bag")

    def look(self, optimizer: Optimizer) -> None:
        """See that an optimizer has told no more than its bag says."""
        self.follow()
        if len(optimizer.study.told) != self.told:
            text = f"{len(optimizer.study.told)} trials are told, {self.told} are in the bag"
            raise Violation("recorded before effect", text)

    def reopened(self, *, lost_tail: bool = False) -> None:
        """Read the bag anew: an optimizer goes on with it, or it lost its end. Else what was in it must be there."""
        before = self._raw
        self._forget()
        self._file, self._at = None, 0
        for file in self._files():
            for entry in read_file(file).entries:
                self._take(entry.topic.removeprefix("/"), entry.data)
        if not lost_tail and self._raw[: len(before)] != before:
            raise Violation("nothing is lost", f"the bag held {len(before)} messages, and now {len(self._raw)} others")
        self._skip()

    def follow(self) -> None:
        """Take what has come into the bag since."""
        file = self._file
        if file is not None and file.exists() and file.stat().st_size == self._at and not self._next(file).exists():
            return
        while (file := self._current()) is not None:
            self._read(file)
            if not self._next(file).exists():
                return
            self._file, self._at, self._channels = self._next(file), 0, {}

    def _current(self) -> Path | None:
        if self._file is None:
            first = self.folder / f"{self.folder.name}_0.mcap"
            if not first.exists():
                return None
            self._file, self._at, self._channels = first, 0, {}
        return self._file

    def _next(self, file: Path) -> Path:
        return file.with_name(f"{self.folder.name}_{number_of(file) + 1}.mcap")

    def _skip(self) -> None:
        """Go to the end of what is there."""
        for file in self._files():
            self._file, self._at, self._channels = file, file.stat().st_size, {}

    def _files(self) -> Iterator[Path]:
        for number in count():
            if not (file := self.folder / f"{self.folder.name}_{number}.mcap").exists():
                return
            yield file

    def _read(self, path: Path) -> None:
        with path.open("rb") as file:
            file.seek(self._at)
            data = file.read()
        at = len(MCAP0_MAGIC) if self._at == 0 and len(data) >= len(MCAP0_MAGIC) else 0
        while at + _HEAD.size <= len(data):
            opcode, length = _HEAD.unpack_from(data, at)
            if at + _HEAD.size + length > len(data) or data[at:] == MCAP0_MAGIC:
                break
            if opcode == _CHUNK:
                self._read_chunk(path, data[at + _HEAD.size : at + _HEAD.size + length])
            at += _HEAD.size + length
        self._at += at

    def _read_chunk(self, path: Path, data: bytes) -> None:
        for record in opened(Chunk.read(ReadDataStream(BytesIO(data))), Budget(path)):
            if isinstance(record, Channel):
                self._channels[record.id] = record.topic.removeprefix("/")
            elif isinstance(record, Message):
                self._take(self._channels[record.channel_id], record.data)
            else:
                assert isinstance(record, Schema)

    def _take(self, topic: str, data: bytes) -> None:
        self._raw.append((topic, data))
        if topic == "candidates":
            self._take_candidate(decode(Candidate, data))
        elif topic == "evaluations":
            self._take_evaluation(decode(Evaluation, data))
        elif topic == "trials":
            self._take_trial(decode(Trial, data))
        elif topic == "commands":
            self._take_command(decode(Command, data))

    def _take_candidate(self, candidate: Candidate) -> None:
        number = candidate.trial
        if self._paused:
            raise Violation("order", f"trial {number} is sent out during a pause")
        if number < self.told:
            raise Violation("order", f"trial {number} is sent out after it was told")
        if number > self._asked or number >= self.told + self._settings.in_flight:
            raise Violation("order", f"trial {number} is sent out, {self._asked} are asked and {self.told} told")
        if candidate.attempt != self._attempts.get(number, 0) + 1:
            raise Violation("order", f"trial {number}: attempt {candidate.attempt} follows another than the one before")
        self._attempts[number] = candidate.attempt
        self._asked = max(self._asked, number + 1)
        self.sent.add((number, candidate.attempt, candidate.evaluator))
        expected = self._oracle.expects(number, self._enqueued)
        if candidate.params_json != expected.params_json:
            raise Violation("same study", f"trial {number} is another arm than in the undisturbed study")
        if candidate.urdf != expected.urdf:
            raise Violation("same study", f"trial {number} has another URDF than in the undisturbed study")

    def _take_evaluation(self, evaluation: Evaluation) -> None:
        key = (evaluation.trial, evaluation.attempt, evaluation.evaluator)
        if key in self.sent and evaluation.trial not in self._answers:
            ok = evaluation.status == Evaluation.OK and not evaluation_fault(
                evaluation, self._settings.spec.n_voxels, self._settings.objectives
            )
            if ok or evaluation.status == Evaluation.REJECTED:
                self._answers[evaluation.trial] = evaluation

    def _take_trial(self, trial: Trial) -> None:
        number = trial.trial
        if number != self.told:
            rule = "told once" if number < self.told else "order"
            raise Violation(rule, f"trial {number} is told when it is the turn of trial {self.told}")
        self.told += 1
        answer = self._answers.get(number)
        if answer is None:
            raise Violation("told from its answer", f"trial {number} is told ({trial.reason!r:.60}) without an answer")
        if (answer.attempt, answer.evaluator) != (trial.attempt, trial.evaluator):
            raise Violation("told from its answer", f"trial {number} is told from another than its first valid answer")
        values = self._oracle.expects(number, self._enqueued).values
        if values is None:
            if trial.state != Trial.FAIL or not math.isnan(trial.reach):
                raise Violation("same study", f"trial {number} is told, but all evaluators reject its arm")
        elif trial.state != Trial.COMPLETE or (trial.reach, trial.torque) != values:
            told = f"{trial.reach}, {trial.torque} {trial.reason}"
            raise Violation("same study", f"trial {number} is told {told}, not {values[0]}, {values[1]}")

    def _take_command(self, command: Command) -> None:
        if command.command in ("pause", "resume"):
            self._paused = command.command == "pause"
        elif command.command == "enqueue":
            self._enqueued[command.trial] = enqueued_params(command)
