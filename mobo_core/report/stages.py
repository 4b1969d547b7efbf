"""Where the time of a study went, from what its bag was told and when."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mobo_core.bag.record import StudyRecord

STAGES = {
    "ask": "from what the sampler waits for being told to its design being sent",
    "evaluate": "the evaluation alone, as the evaluator measured it",
    "wait": "on the way there and back, and in the evaluator's queue",
    "record": "from the answer to its being told: to disk, and in the order of trials",
}


@dataclass(frozen=True)
class Stages:
    """Time per stage.

    Attributes:
        median: stage -> s, the median over the trials of which it is known.
        total: stage -> s, summed over these.
        trials: stage -> of how many it is known.
    """

    median: dict[str, float]
    total: dict[str, float]
    trials: dict[str, int]


def stages(study: StudyRecord) -> Stages:
    """Return the time per stage; of evaluators on other hosts, waiting and recording take in how clocks differ."""
    sent = {c.trial: c.header.time_ns for c in reversed(study.candidates)}
    told = {number: trial.header.time_ns for number, trial in study.trials.items()}
    in_flight = study.settings.in_flight
    values: dict[str, list[float]] = {stage: [] for stage in STAGES}
    for number in sorted(study.trials):
        answer = study.accepted(number)
        if answer is None or number not in sent:
            continue
        answered = answer.header.time_ns
        waited = (answered - sent[number]) / 1e9 - answer.seconds
        if study.trials[number].attempt == _first_attempt(study, number) and waited > -1.0:
            values["evaluate"].append(answer.seconds)
            values["wait"].append(max(waited, 0.0))
            values["record"].append(max((told[number] - answered) / 1e9, 0.0))
        # Trial n is asked once trials up to n - in_flight are told; a pause of the study is none of the sampler's.
        before = told.get(number - in_flight)
        if before is not None and 0 <= sent[number] - before < 60e9:
            values["ask"].append((sent[number] - before) / 1e9)
    return Stages(
        {stage: float(np.median(found)) for stage, found in values.items() if found},
        {stage: math.fsum(found) for stage, found in values.items() if found},
        {stage: len(found) for stage, found in values.items() if found},
    )


def _first_attempt(study: StudyRecord, number: int) -> int:
    candidate = study.candidate_of(number)
    return int(candidate.attempt) if candidate is not None else -1


def shares(names: Sequence[str]) -> list[tuple[str, int]]:
    """Return how many trials each evaluator answered, most first."""
    return Counter(names).most_common()
