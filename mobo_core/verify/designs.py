"""Whether the sampler, asked again, asks for the recorded designs."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator

from mobo_core.bag.record import StudyRecord
from mobo_core.bag.validity import values_of
from mobo_core.coordination.control import enqueued_params
from mobo_core.errors import InputError
from mobo_core.messages import Trial
from mobo_core.search.study import OrderedStudy, Told
from mobo_core.verify.fault import Fault


def check_designs(study: StudyRecord, n: int) -> Iterator[Fault | None]:
    """Ask the sampler for every trial again; yield a fault or None for each."""
    again, objectives = OrderedStudy(study.settings), study.settings.objectives
    enqueued = {c.trial: c for c in study.commands if c.command == "enqueue"}
    for number in range(n):
        while not again.may_ask():
            told = study.trials.get(len(again.told))
            if told is None:
                yield Fault(number, "design", f"asked before trial {len(again.told)} was told")
                return
            values = values_of(told, objectives) if told.state == Trial.COMPLETE else None
            if values is not None and not all(map(math.isfinite, values)):
                yield Fault(told.trial, "reach", f"told {values}, which are no values")
                return
            again.tell(Told(len(again.told), values))
        candidate = study.candidate_of(number)
        if candidate is None:
            yield Fault(number, "candidate", "never sent out, though later trials were")
            return
        command = enqueued.get(number)
        who = "sampler" if command is None else "command"
        try:
            asked = again.ask() if command is None else again.recall(enqueued_params(command))
        except (InputError, ValueError) as error:
            yield Fault(number, "command", f"enqueued an arm that is none of the space's ({error!r:.80})")
            return
        try:
            recorded = json.loads(candidate.params_json)
        except (ValueError, RecursionError):
            recorded = None
        if recorded != asked.params:
            # What follows would be compared with other trials than the recording's.
            yield Fault(number, "params_json", f"{candidate.params_json:.200}, but the {who} asks {asked.params}")
            return
        yield None
