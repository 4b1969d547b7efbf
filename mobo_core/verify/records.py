"""Whether the records of a bag agree with each other and with the study's settings."""

from __future__ import annotations

import json
from collections.abc import Iterator

from mobo_core.bag.record import StudyRecord
from mobo_core.bag.validity import values_of
from mobo_core.coordination.control import COMMANDS
from mobo_core.design import to_urdf
from mobo_core.errors import InputError
from mobo_core.evaluation.spec_message import spec_to_message
from mobo_core.messages import Evaluation, Trial, encode
from mobo_core.verify.fault import Fault


def check_candidates(study: StudyRecord) -> Iterator[Fault]:
    """Check what was sent out: it is of the study, and its parameters, lengths, joints and URDF are one arm's."""
    space, spec = study.settings.space, encode(spec_to_message(study.settings.spec))
    urdfs: dict[int, str] = {}
    for candidate in study.candidates:
        trial = candidate.trial
        if candidate.study != study.name:
            yield Fault(trial, "study", f"{candidate.study!r} in a bag of {study.name!r}")
        if encode(candidate.spec) != spec:
            yield Fault(trial, "spec", "differs from the study's")
        try:
            design = space.design(json.loads(candidate.params_json))
        except (ValueError, KeyError, InputError) as error:
            yield Fault(trial, "params_json", f"no parameters of the space ({error!r:.80})")
            continue
        for field, is_, should in (
            ("sampled_joints", candidate.sampled_joints, design.sampled_joints),
            ("joints", candidate.joints, design.joints),
            ("lengths", tuple(candidate.lengths.tolist()), design.lengths),
        ):
            if is_ != should:
                yield Fault(trial, field, f"{is_!r}, but the parameters give {should!r}")
        if trial not in urdfs:
            urdfs[trial] = to_urdf(design, space)
        if candidate.urdf != urdfs[trial]:
            yield Fault(trial, "urdf", _first_difference(candidate.urdf, urdfs[trial]))


def check_commands(study: StudyRecord) -> Iterator[Fault]:
    """Check that commands are known and of the study, and that each enqueues an arm of the space, once and in time."""
    for number in study.belated:
        yield Fault(number, "command", "enqueued after it had been sent out")
    enqueued: set[int] = set()
    for command in study.commands:
        number = command.trial
        if command.study != study.name:
            yield Fault(number, "command", f"for study {command.study!r} in a bag of {study.name!r}")
        if command.command not in COMMANDS:
            yield Fault(number, "command", f"unknown: {command.command[:40]!r}")
        if command.command != "enqueue":
            continue
        if number in enqueued:
            yield Fault(number, "command", "enqueued more than once")
        enqueued.add(number)
        try:
            asked = json.loads(command.arguments_json)
            params = study.settings.space.params(study.settings.space.arm(asked["joints"], asked["lengths"]))
        except (ValueError, KeyError, TypeError, InputError) as error:
            yield Fault(number, "command", f"enqueued no arm of the space ({error!r:.80})")
            continue
        if asked.get("params") != params:
            yield Fault(number, "command", f"enqueued {asked.get('params')}, but its lengths give {params}")


def _first_difference(found: str, expected: str) -> str:
    pairs = enumerate(zip(found, expected, strict=False))
    at = next((i for i, (a, b) in pairs if a != b), min(len(found), len(expected)))
    return f"byte {at}: {found[at : at + 20]!r}, but xacro gives {expected[at : at + 20]!r}"


def check_told(study: StudyRecord) -> Iterator[Fault]:
    """Check that every trial was told, with the values of the evaluation it names."""
    sent = {(c.trial, c.attempt, c.evaluator) for c in study.candidates}
    for number in range(max(study.trials, default=-1) + 1):
        trial = study.trials.get(number)
        if trial is None:
            yield Fault(number, "trial", "was never told, though later ones were")
            continue
        if trial.state != Trial.COMPLETE:
            if number in study.denied:
                yield Fault(number, "state", "told as failed, though a good answer had come")
            continue
        if (number, trial.attempt, trial.evaluator) not in sent:
            yield Fault(number, "attempt", f"attempt {trial.attempt} on {trial.evaluator} was never sent out")
        evaluation = study.accepted(number)
        if evaluation is None or evaluation.status != Evaluation.OK:
            yield Fault(number, "evaluation", "no good answer of the attempt it names")
            continue
        fields = tuple(dict.fromkeys(("reach", "torque", *study.settings.objectives)))
        for field, told, answered in zip(fields, values_of(trial, fields), values_of(evaluation, fields), strict=True):
            if told != answered:
                yield Fault(number, field, f"told {told!r}, but the evaluation says {answered!r}")
