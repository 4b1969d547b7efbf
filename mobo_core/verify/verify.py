"""Whether a bag says the truth: every design, description, value and record of it, made again."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from multiprocessing import get_context
from typing import Any, NamedTuple

import numpy as np

from mobo_core.bag.record import StudyRecord, versions
from mobo_core.bag.validity import values_of
from mobo_core.coordination.control import COMMANDS, enqueued_params
from mobo_core.design import Design, to_urdf
from mobo_core.errors import InputError
from mobo_core.evaluation.objectives import OBJECTIVES
from mobo_core.evaluation.spec_message import spec_to_message
from mobo_core.messages import Evaluation, Trial, encode
from mobo_core.search.study import OrderedStudy, Told

_COMPARED = (
    "reach", "torque", "voxel_reach", "voxel_torque", "voxel_torque_sd", "voxel_out_of_range",
    "voxel_not_converged", "voxel_in_collision", "attempts", "iterations",
)  # fmt: skip


class Fault(NamedTuple):
    """Something in a bag that is not as it must be.

    Attributes:
        trial: its number, or -1 if no single one is at fault.
        field: what of it.
        text: what was found and what it should be.
    """

    trial: int
    field: str
    text: str

    def __str__(self) -> str:
        return f"trial {self.trial}, {self.field}: {self.text}" if self.trial >= 0 else f"{self.field}: {self.text}"


@dataclass
class Verification:
    """What was checked, and what was found.

    Attributes:
        candidates, evaluations, designs: how many were made again.
        trials: how many are told.
        failed: how many of those as failed.
        faults: what is wrong.
        other_versions: libraries whose version differs from the recording's: name -> (recorded, here).
    """

    candidates: int
    evaluations: int
    designs: int
    trials: int
    failed: int
    faults: list[Fault]
    other_versions: dict[str, tuple[str, str]]


def verify(
    study: StudyRecord,
    *,
    sample: int | None = None,
    workers: int = 1,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Verification:
    """Check a recorded study.

    For every candidate: its URDF is, byte for byte, what xacro makes of its design; its lengths, joints and
    spec belong to the study. Every trial was told once, the value of the evaluation it names. Every design is
    what the sampler asks after the trials before it. Every evaluation, made again by the kernel, gives the
    same bits.

    Args:
        study: the recording.
        sample: number of evaluations to make again, spread over the study; all if None.
        workers: processes that evaluate.
        progress: called with (steps done, in all); a step is an evaluation or a design.
    """
    faults = [Fault(-1, "file", text) for text in study.faults]
    faults += [Fault(number, "trial", "told more than once") for number in study.repeated]
    faults += _commands(study)
    faults += _candidates(study)
    faults += _told(study)
    jobs = _sampled(_evaluation_jobs(study), sample)
    n_designs = max((int(c.trial) for c in study.candidates), default=-1) + 1
    total, done = len(jobs) + n_designs, 0
    for step in _designs(study, n_designs):
        faults += [step] if step else []
        done += 1
        progress(done, total)
    for trial, found in _evaluated_again(jobs, workers):
        faults += [Fault(trial, field, text) for field, text in found]
        done += 1
        progress(done, total)
    failed = len(study.trials) - len(study.complete_trials())
    recorded, here = json.loads(study.record.get("versions", "{}")), versions()
    other = {name: (old, here.get(name, "")) for name, old in recorded.items() if old != here.get(name)}
    return Verification(len(study.candidates), len(jobs), n_designs, len(study.trials), failed, faults, other)


def _candidates(study: StudyRecord) -> Iterator[Fault]:
    space, spec = study.settings.space, encode(spec_to_message(study.settings.spec))
    urdfs: dict[int, str] = {}
    for candidate in study.candidates:
        trial = int(candidate.trial)
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


def _commands(study: StudyRecord) -> Iterator[Fault]:
    for number in study.belated:
        yield Fault(number, "command", "enqueued after it had been sent out")
    enqueued: set[int] = set()
    for command in study.commands:
        number = int(command.trial)
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
            params = study.settings.space.params(Design(asked["joints"], tuple(asked["lengths"])))
        except (ValueError, KeyError, TypeError, InputError) as error:
            yield Fault(number, "command", f"enqueued no arm of the space ({error!r:.80})")
            continue
        if asked.get("params") != params:
            yield Fault(number, "command", f"enqueued {asked.get('params')}, but its lengths give {params}")


def _first_difference(found: str, expected: str) -> str:
    pairs = enumerate(zip(found, expected, strict=False))
    at = next((i for i, (a, b) in pairs if a != b), min(len(found), len(expected)))
    return f"byte {at}: {found[at : at + 20]!r}, but xacro gives {expected[at : at + 20]!r}"


def _told(study: StudyRecord) -> Iterator[Fault]:
    sent = {(int(c.trial), int(c.attempt), c.evaluator) for c in study.candidates}
    for number in range(max(study.trials, default=-1) + 1):
        trial = study.trials.get(number)
        if trial is None:
            yield Fault(number, "trial", "was never told, though later ones were")
            continue
        if trial.state != Trial.COMPLETE:
            if number in study.denied:
                yield Fault(number, "state", "told as failed, though a good answer had come")
            continue
        if (number, int(trial.attempt), trial.evaluator) not in sent:
            yield Fault(number, "attempt", f"attempt {trial.attempt} on {trial.evaluator} was never sent out")
        evaluation = study.accepted(number)
        if evaluation is None or evaluation.status != Evaluation.OK:
            yield Fault(number, "evaluation", "no good answer of the attempt it names")
            continue
        fields = tuple(dict.fromkeys(("reach", "torque", *study.settings.objectives)))
        for field, told, answered in zip(fields, values_of(trial, fields), values_of(evaluation, fields), strict=True):
            if told != answered:
                yield Fault(number, field, f"told {told!r}, but the evaluation says {answered!r}")


def _designs(study: StudyRecord, n: int) -> Iterator[Fault | None]:
    """Ask the sampler for every trial again; yield a fault or None for each."""
    again, objectives = OrderedStudy(study.settings), study.settings.objectives
    enqueued = {int(c.trial): c for c in study.commands if c.command == "enqueue"}
    for number in range(n):
        while not again.may_ask():
            told = study.trials.get(len(again.told))
            if told is None:
                yield Fault(number, "design", f"asked before trial {len(again.told)} was told")
                return
            values = values_of(told, objectives) if told.state == Trial.COMPLETE else None
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
        except ValueError:
            recorded = None
        if recorded != asked.params:
            # What follows would be compared with other trials than the recording's.
            yield Fault(number, "params_json", f"{candidate.params_json:.200}, but the {who} asks {asked.params}")
            return
        yield None


class _Job(NamedTuple):
    trial: int
    urdf: str
    tip: str
    spec_json: str
    recorded: dict[str, Any]
    extra: dict[str, float]  # by objective; reach and torque are compared as recorded


def _evaluation_jobs(study: StudyRecord) -> list[_Job]:
    jobs = []
    spec_json = study.settings.spec.to_json()
    for number in sorted(study.trials):
        evaluation, candidate = study.accepted(number), study.candidate_of(number)
        if evaluation is None or candidate is None or evaluation.status != Evaluation.OK:
            continue
        recorded = {name: getattr(evaluation, name) for name in _COMPARED}
        extra = dict(zip(study.settings.objectives, values_of(evaluation, study.settings.objectives), strict=True))
        jobs.append(_Job(number, candidate.urdf, candidate.tip, spec_json, recorded, extra))
    return jobs


def _sampled(jobs: list[_Job], sample: int | None) -> list[_Job]:
    if sample is None or sample >= len(jobs):
        return jobs
    return [jobs[i * len(jobs) // sample] for i in range(sample)]


def _evaluated_again(jobs: list[_Job], workers: int) -> Iterator[tuple[int, list[tuple[str, str]]]]:
    if workers == 1 or len(jobs) < 2:
        yield from map(_evaluate_again, jobs)
        return
    with get_context("spawn").Pool(min(workers, len(jobs))) as pool:
        yield from pool.imap(_evaluate_again, jobs)


def _evaluate_again(job: _Job) -> tuple[int, list[tuple[str, str]]]:
    from mobo_core.coordination.answer import result_fields
    from mobo_core.evaluation.evaluate import evaluate
    from mobo_core.evaluation.spec import EvaluationSpec

    try:
        spec = EvaluationSpec.of(json.loads(job.spec_json))
        result = evaluate(job.urdf, spec, tip=job.tip, objectives=list(job.extra))
    except InputError as error:
        return job.trial, [("urdf", str(error))]
    fields = result_fields(result)
    found = []
    for name in _COMPARED:
        old, new = np.asarray(job.recorded[name]), np.asarray(fields[name]).astype(np.asarray(job.recorded[name]).dtype)
        if old.shape != new.shape or old.tobytes() != new.tobytes():
            both = range(min(old.size, new.size))
            at = next((i for i in both if old.flat[i].tobytes() != new.flat[i].tobytes()), None)
            if at is None:
                found.append((name, f"{old.size} entries recorded, evaluated again {new.size}"))
                continue
            where = f" of voxel {at}" if old.ndim else ""
            found.append((name, f"{old.flat[at]!r}{where} recorded, evaluated again {new.flat[at]!r}"))
    for name, value in result.extra.items():
        if abs(value - job.extra[name]) > OBJECTIVES[name].tolerance * abs(value):
            found.append((name, f"{job.extra[name]!r} recorded, evaluated again {value!r}"))
    return job.trial, found
