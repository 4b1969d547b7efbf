"""Commands to a running study: pause, resume, stop, enqueue.

An accepted command is recorded before it takes effect and names the first trial it takes effect on, so that a
study is a function of its settings and its commands.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from typing import NamedTuple

from mobo_core.design import DesignSpace
from mobo_core.errors import InputError
from mobo_core.messages import Command
from mobo_core.search.study import Params, frozen_trial

COMMANDS = ("pause", "resume", "stop", "enqueue")
STOPPED_BY_COMMAND, STOPPED_BY_SIGNAL = "stopped by a command", "stopped by a signal"
_MAX_SOURCE = 200


class Reply(NamedTuple):
    """What became of a command.

    Attributes:
        accepted: whether it is in force.
        message: one line for people: what happens now, or why it was refused.
        trial: the first trial it takes effect on; 0 if refused.
        bad_input: it was refused since its arm is none of the space's.
    """

    accepted: bool
    message: str
    trial: int = 0
    bad_input: bool = False


class Controls:
    """Takes commands, and says what those accepted so far amount to.

    Args:
        study: its name.
        space: of the arms that may be enqueued.
        record: makes a Command message last, before it takes effect.

    Attributes:
        paused: no trial is asked or sent out.
        stopped: the optimizer shall end.
        enqueued: trial -> the sampler's parameters of the arm it shall be.
    """

    def __init__(self, study: str, space: DesignSpace, record: Callable[[Command], None]) -> None:
        self._study, self._space, self._record = study, space, record
        self.paused = self.stopped = False
        self.enqueued: dict[int, Params] = {}

    def pause(self, asked: int, source: str) -> Reply:
        """Stop asking and sending out; ``asked`` trials are asked so far, ``source`` says who wants it."""
        return self._accept("pause", asked, source) if not self.paused else Reply(False, "paused already")

    def resume(self, asked: int, source: str) -> Reply:
        """End a pause."""
        return self._accept("resume", asked, source) if self.paused else Reply(False, "not paused")

    def stop(self, asked: int, source: str) -> Reply:
        """Have the optimizer end in order."""
        return self._accept("stop", asked, source)

    def enqueue(self, asked: int, source: str, joints: str, lengths: Iterable[float], n_trials: int) -> Reply:
        """Make an arm (``joints`` as a sampler would draw them, ``lengths`` in m) the next trial of ``n_trials``."""
        try:
            design = self._space.arm(joints, lengths)
            params = self._space.params(design)
        except InputError as error:
            return Reply(False, str(error), bad_input=True)
        trial = max(asked, max(self.enqueued, default=-1) + 1)
        if trial >= n_trials:
            return Reply(False, f"all {n_trials} trials are asked or enqueued; a larger n_trials makes room")
        return self._accept("enqueue", trial, source, joints=joints, lengths=design.lengths, params=params)

    def repeat(self, commands: Iterable[Command], asked: int) -> None:
        """Put in force again what a bag's commands say of the trials after the first ``asked``.

        A stop is not repeated: it took effect, and to resume the study is the newer wish.

        Raises:
            InputError: a command that is none, or an enqueue of no arm of the space.
        """
        for command in commands:
            if command.command != "stop" and (command.command != "enqueue" or command.trial >= asked):
                self._apply(command)
        for trial, params in self.enqueued.items():
            frozen_trial(self._space, params, f"command enqueue of trial {trial}")

    def _accept(self, command: str, trial: int, source: str, **arguments: object) -> Reply:
        message = Command(
            study=self._study, trial=trial, command=command, arguments_json=json.dumps(arguments),
            source=source[:_MAX_SOURCE],
        )  # fmt: skip
        self._record(message)
        return Reply(True, self._apply(message), trial)

    def _apply(self, command: Command) -> str:
        if command.command == "pause":
            self.paused = True
            return "paused: what is sent out is finished, nothing new goes out"
        if command.command == "resume":
            self.paused = False
            return "going on"
        if command.command == "enqueue":
            self.enqueued[command.trial] = enqueued_params(command)
            return f"trial {command.trial} will be this arm"
        if command.command == "stop":
            self.stopped = True
            return "stopping; resume:=true goes on"
        where = f"command of trial {command.trial}"
        raise InputError(f"unknown: {command.command[:40]!r}", where=where, expected=" or ".join(COMMANDS))


def enqueued_params(command: Command) -> Params:
    """Return the sampler's parameters that an enqueue Command holds.

    Raises:
        InputError: it holds none.
    """
    try:
        return dict(json.loads(command.arguments_json)["params"])
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        where = f"command enqueue of trial {command.trial}"
        raise InputError(f"not readable ({error!r:.80})", where=where, expected="params") from None
