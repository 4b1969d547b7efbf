"""Whether evaluations, made again by the study's engine, give the recorded bits."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from multiprocessing import get_context
from typing import NamedTuple

import numpy as np

from mobo_core.bag.record import StudyRecord
from mobo_core.bag.validity import values_of
from mobo_core.coordination.answer import AUDIT_POSES, result_fields, simulated
from mobo_core.errors import InputError, visible
from mobo_core.evaluation.objectives import OBJECTIVES
from mobo_core.evaluation.result import Result
from mobo_core.messages import Candidate, Evaluation, EvaluatorStatus
from mobo_core.verify.fault import Fault
from mobo_core.verify.history import History

_COMPARED = (
    "reach", "torque", "voxel_reach", "voxel_torque", "voxel_torque_sd", "voxel_out_of_range",
    "voxel_not_converged", "voxel_in_collision", "attempts", "iterations", "audit_poses",
)  # fmt: skip
# m, rad or N m: what an audit finds is rounding, which differs between machines.
_AUDIT_ROUNDING = 1e-9
# Of answers to one trial that differ, so many are held against it: one is enough to name a liar.
_MOST_ANSWERS = 4


class Answer(NamedTuple):
    """What an evaluator said of an arm.

    Attributes:
        who: attempt and evaluator, for people.
        status, reason: as in the Evaluation.
        values: name -> recorded value, of those that are compared.
        extra: objective -> value.
        audit_max_error: m, rad or N m.
    """

    who: str
    status: int
    reason: str
    values: dict[str, object]
    extra: dict[str, float]
    audit_max_error: float

    @classmethod
    def of(cls, evaluation: Evaluation, objectives: Iterable[str]) -> Answer:
        """Return what of an Evaluation is compared."""
        who = f"attempt {evaluation.attempt} on {evaluation.evaluator}"
        objectives = list(objectives)
        extra = dict(zip(objectives, values_of(evaluation, objectives), strict=True))
        named = list(evaluation.extra_names)
        values: dict[str, object] = {name: getattr(evaluation, name) for name in _COMPARED}
        values |= {"extra_names": len(named) + len(evaluation.extra_values)}
        return cls(who, evaluation.status, evaluation.reason, values, extra, evaluation.audit_max_error)

    def same_as(self, other: Answer) -> bool:
        """Return whether two answers say the same of the arm."""
        return self.status == other.status and all(
            np.asarray(value).tobytes() == np.asarray(other.values[name]).tobytes()
            for name, value in self.values.items()
        )


@dataclass(frozen=True)
class Job:
    """An arm to evaluate again, and all that was answered of it.

    Attributes:
        answers: distinct ones, the first accepted one first.
        failure: what it was told as failed from, "" if it was not, or if it was rejected.
    """

    trial: int
    urdf: str
    tip: str
    spec_json: str
    engine: str
    objectives: tuple[str, ...]
    answers: list[Answer]
    failure: str

    @property
    def is_suspect(self) -> bool:
        """Whether it is among the first to be made again."""
        return bool(self.failure) or len(self.answers) > 1 or any(a.status != Evaluation.OK for a in self.answers)


class Again(NamedTuple):
    """What came of a job: (field, text) of what differs, and whether an arm that failed evaluates after all."""

    trial: int
    found: list[tuple[str, str]]
    evaluates: str


def evaluation_jobs(study: StudyRecord, history: History) -> list[Job]:
    """Return the arms to evaluate again: all that were answered, and those told as failed."""
    jobs = []
    spec_json, objectives = study.settings.spec.to_json(), study.settings.objectives
    for number in sorted({*history.answers, *history.failures}):
        candidate = study.candidate_of(number)
        if candidate is None:
            continue
        answers: list[Answer] = []
        for evaluation in history.answers.get(number, []):
            answer = Answer.of(evaluation, objectives)
            if len(answers) < _MOST_ANSWERS and not any(answer.same_as(known) for known in answers):
                answers.append(answer)
        failed = history.failures.get(number)
        failure = _failure(failed) if failed is not None and failed.status != Evaluation.REJECTED else ""
        engine = engine_of(study, candidate)
        jobs.append(Job(number, candidate.urdf, candidate.tip, spec_json, engine, tuple(objectives), answers, failure))
    return jobs


def _failure(evaluation: Evaluation) -> str:
    own = not evaluation.mobo_version and not evaluation.host_id and evaluation.reason.startswith("timed out")
    who = "the optimizer itself: no lie, a slow host" if own else f"attempt {evaluation.attempt} on"
    return f"{who} {'' if own else evaluation.evaluator}: {evaluation.reason:.200}"


def engine_of(study: StudyRecord, candidate: Candidate) -> str:
    """Return the engine that an answer was to come from; older bags do not say, but for who joined."""
    if candidate.engine:
        return candidate.engine
    joined = {e.engine for e in study.evaluators if e.state == EvaluatorStatus.JOINED}
    return "reference" if joined == {"reference"} else "kernel"


def sampled(jobs: list[Job], sample: int | None) -> list[Job]:
    """Return so many of the jobs, those that are suspect first, the others spread over the study; all if None."""
    if sample is None:
        return jobs
    suspect = [job for job in jobs if job.is_suspect][:sample]
    others = [job for job in jobs if not job.is_suspect]
    n = min(sample - len(suspect), len(others))
    return suspect + [others[i * len(others) // n] for i in range(n)]


def check_answers(jobs: list[Job]) -> Iterator[Fault]:
    """Check that nobody gave one sending two sets of values; whether a rejection was a lie, evaluation shows."""
    for job in jobs:
        said = Counter(answer.who for answer in job.answers if answer.status == Evaluation.OK)
        for who, times in said.items():
            if times > 1:
                yield Fault(job.trial, "evaluation", f"{who} answered more than once, and not the same")


def evaluated_again(jobs: list[Job], workers: int) -> Iterator[Again]:
    """Make evaluations again; yield what came of each."""
    if workers == 1 or len(jobs) < 2:
        yield from map(_evaluate_again, jobs)
        return
    with get_context("spawn").Pool(min(workers, len(jobs))) as pool:
        yield from pool.imap(_evaluate_again, jobs)


def faults_of(again: Again, unsaid: set[int]) -> tuple[list[Fault], list[str]]:
    """Return the faults that an evaluation made again shows, and notes on what is none in an older bag."""
    faults = [Fault(again.trial, field, text) for field, text in again.found]
    if not again.evaluates:
        return faults, []
    if again.trial in unsaid:
        return faults, [visible(f"trial {again.trial}: {again.evaluates}; an older mobo's bag, which says no more")]
    return [*faults, Fault(again.trial, "state", again.evaluates)], []


def _evaluate_again(job: Job) -> Again:
    try:
        result = _result(job)
    except InputError as error:
        said = [("urdf", f"{error}; but {a.who} answered it") for a in job.answers if a.status == Evaluation.OK]
        return Again(job.trial, said, "")
    found: list[tuple[str, str]] = []
    for answer in job.answers:
        if answer.status != Evaluation.OK:
            found.append(("status", f"{answer.who} rejected it ({answer.reason:.100}), but it evaluates"))
        elif not result.audit_fault:
            differs = _different(answer, result)
            found += [(name, f"{old} recorded by {answer.who}, evaluated again {new}") for name, old, new in differs]
    evaluates = ""
    if job.failure and not result.audit_fault:
        evaluates = f"told as failed ({job.failure}), but it evaluates: reach {result.reach:.6g}"
    if result.audit_fault:
        found += [("audit", result.audit_fault)] if any(a.status == Evaluation.OK for a in job.answers) else []
    return Again(job.trial, found, evaluates)


def _result(job: Job) -> Result:
    from mobo_core.evaluation.evaluate import evaluate
    from mobo_core.evaluation.spec import EvaluationSpec

    spec = EvaluationSpec.of(json.loads(job.spec_json))
    extra = [name for name in job.objectives if name not in ("reach", "torque")]
    if job.engine == "simulated":
        return simulated(job.urdf, spec, 0.0, extra)
    return evaluate(
        job.urdf, spec, tip=job.tip, engine="reference" if job.engine == "reference" else "kernel", objectives=extra,
        audit_poses=AUDIT_POSES, audit_number=job.trial,
    )  # fmt: skip


def _different(answer: Answer, result: Result) -> Iterator[tuple[str, str, str]]:
    """Yield (field, recorded, made again) of what differs."""
    fields = result_fields(result) | {"extra_names": 2 * len(result.extra)}
    for name, recorded in answer.values.items():
        old, new = np.asarray(recorded), np.asarray(fields[name]).astype(np.asarray(recorded).dtype)
        if old.shape == new.shape and old.tobytes() == new.tobytes():
            continue
        both = range(min(old.size, new.size))
        at = next((i for i in both if old.flat[i].tobytes() != new.flat[i].tobytes()), None)
        if at is None:
            yield name, f"{old.size} entries", f"{new.size}"
        else:
            where = f" of voxel {at}" if old.ndim else ""
            yield name, f"{old.flat[at].item()!r}{where}", f"{new.flat[at].item()!r}"
    for name, value in result.extra.items():
        if not abs(value - answer.extra[name]) <= OBJECTIVES[name].tolerance * abs(value):
            yield name, f"{answer.extra[name]!r}", f"{value!r}"
    if not abs(answer.audit_max_error - result.audit_max_error) <= _AUDIT_ROUNDING:
        yield "audit_max_error", f"{answer.audit_max_error!r}", f"{result.audit_max_error!r}"
