"""What a bag holds, in numbers."""

from __future__ import annotations

import json
from collections import Counter
from typing import Any

from mobo_core.bag.collector import message_of
from mobo_core.bag.reader import FileContent, entries
from mobo_core.bag.record import StudyRecord
from mobo_core.messages import EvaluatorStatus, StudyStatus, Trial


def bag_info(study: StudyRecord) -> dict[str, Any]:
    """Return what there is to know of a bag, as plain values fit for JSON.

    ``sessions`` counts the runs of the optimizer that recorded something, ``seconds`` is the time the files
    span, breaks between them left out. Of ``trials``, ``open`` are those sent out but not told.
    """
    told = list(study.trials.values())
    complete = sum(trial.state == Trial.COMPLETE for trial in told)
    sent = {candidate.trial for candidate in study.candidates}
    files = [_file(content) for content in study.contents]
    size = sum(file["bytes"] for file in files)
    begun = sum(status.state == StudyStatus.RUNNING for status in _statuses(study))
    topics = Counter(entry.topic for content in study.contents for entry in content.entries)
    return {
        "study": study.name,
        "settings": study.settings.to_dict(),
        "versions": _json(study.record.get("versions", "")),
        "schema_version": int(study.record["schema_version"]),
        "files": files,
        "topics": dict(sorted(topics.items())),
        "trials": {
            "told": len(told),
            "complete": complete,
            "failed": len(told) - complete,
            "open": len(sent - set(study.trials)),
            "told_twice": sorted(set(study.repeated)),
        },
        "answers": {"recorded": len(study.evaluations), "used": sum(bool(trial.evaluator) for trial in told)},
        "resent": sum(candidate.attempt > 1 for candidate in study.candidates),
        "evaluators": _evaluators(study),
        "sessions": begun or sum(bool(content.entries) for content in study.contents),
        "seconds": sum(file["seconds"] for file in files),
        "bytes": size,
        "bytes_per_trial": round(size / len(told)) if told else None,
    }


def _statuses(study: StudyRecord) -> list[StudyStatus]:
    """Return the StudyStatus messages: a session begins with one that says RUNNING."""
    found = (message_of(entry) for entry in entries(study.contents) if entry.kind == StudyStatus.kind)
    return [status for status in found if isinstance(status, StudyStatus)]


def _file(content: FileContent) -> dict[str, Any]:
    times = [entry.time_ns for entry in content.entries]
    return {
        "name": content.path.name,
        "state": "finished" if content.finished else content.fault or "cut off",
        "messages": len(content.entries),
        "bytes": content.path.stat().st_size,
        "first_ns": min(times, default=None),
        "seconds": (max(times) - min(times)) / 1e9 if times else 0.0,
    }


def _evaluators(study: StudyRecord) -> list[dict[str, Any]]:
    """Return who answered: accepted answers, their share, and what the evaluator said of itself when it joined."""
    accepted = Counter(trial.evaluator for trial in study.trials.values() if trial.evaluator)
    answered = Counter(evaluation.evaluator for evaluation in study.evaluations)
    joined = {status.evaluator: status for status in study.evaluators if status.state == EvaluatorStatus.JOINED}
    lost = Counter(status.evaluator for status in study.evaluators if status.state == EvaluatorStatus.LOST)
    total = sum(accepted.values())
    names = sorted({*accepted, *answered, *joined}, key=lambda name: (-accepted[name], name))
    return [
        {
            "name": name,
            "answers": answered[name],
            "accepted": accepted[name],
            "share": accepted[name] / total if total else 0.0,
            "lost": lost[name],
            "workers": joined[name].workers if name in joined else None,
            "engine": joined[name].engine if name in joined else None,
            "host": joined[name].host_id if name in joined else None,
        }
        for name in names
    ]


def _json(text: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return text
