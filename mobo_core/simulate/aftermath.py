"""What `mobo verify` says of a simulated bag afterwards: it names every lie and every arm given up, and no more."""

from __future__ import annotations

from mobo_core.bag.collector import read_study
from mobo_core.simulate.violation import Violation
from mobo_core.simulate.witness import Witness
from mobo_core.simulate.workers import is_bad
from mobo_core.verify.evaluations import check_answers, evaluated_again, evaluation_jobs, faults_of
from mobo_core.verify.fault import Fault
from mobo_core.verify.files import check_files
from mobo_core.verify.history import History


def check_verified(witness: Witness) -> None:
    """See that a bag verifies, but for what its witness saw.

    Arms that the stub of an evaluation rejects are evaluated without complaint by verify, which does not know of
    that; what it says of rejections of those does not count.

    Raises:
        Violation: it does not, or verify overlooks something.
    """
    study = read_study(witness.folder)
    history = History(study)
    history.replay()
    faults = [Fault(-1, "file", text) for text in study.faults] + history.faults + list(check_files(study))
    if faults:
        raise Violation("verifies", f"verify says {faults[0]}")
    jobs = evaluation_jobs(study, history)
    bad = {job.trial for job in jobs if is_bad(job.urdf)}
    faults += check_answers(jobs)
    for again in evaluated_again(jobs, 1):
        faults += faults_of(again, history.unsaid)[0]
    for trial, attempt, evaluator in sorted(witness.lied):
        who = f"attempt {attempt} on {evaluator}"
        if not any(fault.trial == trial and who in fault.text for fault in faults):
            raise Violation("verify names liars", f"not that of {who}, trial {trial}")
    for trial in sorted(witness.exhausted):
        if not any(fault.trial == trial and fault.field == "state" for fault in faults):
            raise Violation("verify names failures", f"not that trial {trial} was given up")
    known = {trial for trial, _, _ in witness.lied} | witness.exhausted
    for fault in faults:
        if fault.trial not in known and not (fault.trial in bad and fault.field == "status"):
            raise Violation("verifies", f"verify says {fault}")
