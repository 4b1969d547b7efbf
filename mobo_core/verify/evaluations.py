"""Whether evaluations, made again, give the recorded bits."""

from __future__ import annotations

import json
from collections.abc import Iterator
from multiprocessing import get_context
from typing import NamedTuple

import numpy as np

from mobo_core.bag.record import StudyRecord
from mobo_core.bag.validity import values_of
from mobo_core.errors import InputError
from mobo_core.evaluation.objectives import OBJECTIVES
from mobo_core.messages import Evaluation

_COMPARED = (
    "reach", "torque", "voxel_reach", "voxel_torque", "voxel_torque_sd", "voxel_out_of_range",
    "voxel_not_converged", "voxel_in_collision", "attempts", "iterations",
)  # fmt: skip


class Job(NamedTuple):
    """An evaluation to make again, and what it was."""

    trial: int
    urdf: str
    tip: str
    spec_json: str
    recorded: dict[str, object]
    extra: dict[str, float]  # by objective; reach and torque are compared as recorded


def evaluation_jobs(study: StudyRecord) -> list[Job]:
    """Return the evaluations that trials were told from."""
    jobs = []
    spec_json = study.settings.spec.to_json()
    for number in sorted(study.trials):
        evaluation, candidate = study.accepted(number), study.candidate_of(number)
        if evaluation is None or candidate is None or evaluation.status != Evaluation.OK:
            continue
        recorded = {name: getattr(evaluation, name) for name in _COMPARED}
        extra = dict(zip(study.settings.objectives, values_of(evaluation, study.settings.objectives), strict=True))
        jobs.append(Job(number, candidate.urdf, candidate.tip, spec_json, recorded, extra))
    return jobs


def sampled(jobs: list[Job], sample: int | None) -> list[Job]:
    """Return so many of the jobs, spread over the study; all if None."""
    if sample is None or sample >= len(jobs):
        return jobs
    return [jobs[i * len(jobs) // sample] for i in range(sample)]


def evaluated_again(jobs: list[Job], workers: int) -> Iterator[tuple[int, list[tuple[str, str]]]]:
    """Make evaluations again; yield (trial, faults as (field, text)) of each."""
    if workers == 1 or len(jobs) < 2:
        yield from map(_evaluate_again, jobs)
        return
    with get_context("spawn").Pool(min(workers, len(jobs))) as pool:
        yield from pool.imap(_evaluate_again, jobs)


def _evaluate_again(job: Job) -> tuple[int, list[tuple[str, str]]]:
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
