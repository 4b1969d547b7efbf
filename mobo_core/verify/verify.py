"""Whether a bag says the truth: every design, description, value and record of it, made again."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass

from mobo_core.bag.record import StudyRecord, versions
from mobo_core.verify.designs import check_designs
from mobo_core.verify.evaluations import evaluated_again, evaluation_jobs, sampled
from mobo_core.verify.fault import Fault
from mobo_core.verify.records import check_candidates, check_commands, check_told


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
    faults += check_commands(study)
    faults += check_candidates(study)
    faults += check_told(study)
    jobs = sampled(evaluation_jobs(study), sample)
    n_designs = max((c.trial for c in study.candidates), default=-1) + 1
    total, done = len(jobs) + n_designs, 0
    for step in check_designs(study, n_designs):
        faults += [step] if step else []
        done += 1
        progress(done, total)
    for trial, found in evaluated_again(jobs, workers):
        faults += [Fault(trial, field, text) for field, text in found]
        done += 1
        progress(done, total)
    failed = len(study.trials) - len(study.complete_trials())
    recorded, here = json.loads(study.record.get("versions", "{}")), versions()
    other = {name: (old, here.get(name, "")) for name, old in recorded.items() if old != here.get(name)}
    return Verification(len(study.candidates), len(jobs), n_designs, len(study.trials), failed, faults, other)
