"""Whether an answer or a heartbeat makes sense, whoever sent it."""

from __future__ import annotations

from mobo_core.bag.validity import check_plain, evaluation_fault
from mobo_core.coordination.leases import Dispatch
from mobo_core.errors import InputError
from mobo_core.messages import Evaluation, EvaluatorStatus, decode
from mobo_core.search.study import StudySettings

# A heartbeat of so many workers, each with a candidate, is far smaller than so many bytes.
MAX_WORKERS = 10_000
MAX_HEARTBEAT_BYTES = 1_000_000
MAX_NAME = 255
MAX_REASON = 2000
MAX_ABOUT = 4000


def claim_of(evaluation: Evaluation, settings: StudySettings) -> tuple[Dispatch, bool, str]:
    """Return which sending an Evaluation answers, whether its trial may be told from it, and what is wrong with it."""
    answered = evaluation.status == Evaluation.OK
    fault = evaluation_fault(evaluation, settings.spec.n_voxels, settings.objectives) if answered else ""
    ok = not fault and evaluation.status in (Evaluation.OK, Evaluation.REJECTED)
    return Dispatch(evaluation.trial, evaluation.attempt, evaluation.evaluator), ok, fault


def failure_reason(evaluation: Evaluation, settings: StudySettings) -> str:
    """Return why a trial fails whose answer that is, as its record says it."""
    _, ok, fault = claim_of(evaluation, settings)
    reason = (fault and f"invalid answer: {fault}") or evaluation.reason or "failed without a reason"
    return (f"rejected: {reason}" if ok else reason)[:MAX_REASON]


def read_heartbeat(data: bytes) -> EvaluatorStatus:
    """Return the EvaluatorStatus that CDR bytes hold.

    Raises:
        InputError: the bytes are not one, or one that no evaluator sends.
    """
    where = "heartbeat"
    if len(data) > MAX_HEARTBEAT_BYTES:
        raise InputError(f"{len(data)} bytes", where=where, expected=f"at most {MAX_HEARTBEAT_BYTES} bytes")
    status = decode(EvaluatorStatus, data)
    name = status.evaluator
    if not name or len(name) > MAX_NAME or not name.isprintable():
        raise InputError(f"evaluator {name[:40]!r}", where=where, expected=f"a name of 1 to {MAX_NAME} characters")
    check_plain(status, where)  # joins are recorded, to be read again
    more = len("".join([status.engine, status.kernel_hash, status.mobo_version, status.host_id, *status.objectives]))
    if more > MAX_ABOUT:
        raise InputError(f"{more:,} characters about {name}", where=where, expected=f"at most {MAX_ABOUT}")
    if not 0 < status.workers <= MAX_WORKERS:
        raise InputError(f"{name}: {status.workers} workers", where=where, expected=f"1 to {MAX_WORKERS}")
    if not len(status.studies) == len(status.trials) == len(status.attempts):
        raise InputError(f"{name}: studies, trials, attempts of different lengths", where=where, expected="equal ones")
    return status
