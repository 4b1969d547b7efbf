"""Whether a bag says the truth: every design, description, value and record of it, made again."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass

from mobo_core.bag.record import StudyRecord, versions
from mobo_core.verify.designs import check_designs
from mobo_core.verify.evaluations import check_answers, evaluated_again, evaluation_jobs, faults_of, sampled
from mobo_core.verify.fault import Fault
from mobo_core.verify.files import chain_notes, check_files
from mobo_core.verify.history import History
from mobo_core.verify.records import check_candidates, check_enqueued


@dataclass
class Verification:
    """What was checked, and what was found.

    Attributes:
        candidates, evaluations, designs: how many were made again.
        trials: how many are told.
        failed: how many of those as failed.
        faults: what is wrong.
        notes: what else there is to say: of the hash chain, and of failures in older bags.
        other_versions: libraries whose version differs from the recording's: name -> (recorded, here).
    """

    candidates: int
    evaluations: int
    designs: int
    trials: int
    failed: int
    faults: list[Fault]
    notes: list[str]
    other_versions: dict[str, tuple[str, str]]


def verify(
    study: StudyRecord,
    *,
    sample: int | None = None,
    workers: int = 1,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Verification:
    """Check a recorded study.

    The files are of one study and one bag. For every candidate: its URDF is, byte for byte, what xacro makes of its
    design; its lengths, joints and spec belong to the study. The messages can have come in this order: every trial
    was sent out in its turn and told once, in its turn, from the answer that counted by the rule of acceptance.
    Every design is what the sampler asks after the trials before it. Every answer, made again by the study's engine,
    gives the same bits, and an arm that was told as failed does not evaluate.

    Args:
        study: the recording.
        sample: number of evaluations to make again, first those of failures and of answers that differ, then spread
            over the study; all if None.
        workers: processes that evaluate.
        progress: called with (steps done, in all); a step is an evaluation or a design.
    """
    faults = [Fault(-1, "file", text) for text in study.faults]
    faults += check_files(study)
    history = History(study)
    history.replay()
    faults += history.faults
    faults += check_enqueued(study)
    faults += check_candidates(study)
    notes = chain_notes(study)
    jobs = evaluation_jobs(study, history)
    faults += check_answers(jobs)
    jobs = sampled(jobs, sample)
    n_designs = max((c.trial for c in study.candidates), default=-1) + 1
    total, done = len(jobs) + n_designs, 0
    for step in check_designs(study, n_designs):
        faults += [step] if step else []
        done += 1
        progress(done, total)
    for again in evaluated_again(jobs, workers):
        found, said = faults_of(again, history.unsaid)
        faults += found
        notes += said
        done += 1
        progress(done, total)
    failed = len(study.trials) - len(study.complete_trials())
    recorded, here = _versions(study), versions()
    other = {name: (old, here.get(name, "")) for name, old in recorded.items() if old != here.get(name)}
    return Verification(len(study.candidates), len(jobs), n_designs, len(study.trials), failed, faults, notes, other)


def _versions(study: StudyRecord) -> dict[str, str]:
    try:
        said = json.loads(study.record.get("versions", "{}"))
    except (ValueError, RecursionError):
        return {}
    return {str(name): str(value) for name, value in said.items()} if isinstance(said, dict) else {}
