"""From a Candidate message to the Evaluation message that answers it."""

from __future__ import annotations

import functools
import hashlib
import socket
import time
import traceback
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from mobo_core.errors import InputError, UnableError
from mobo_core.evaluation.objectives import OBJECTIVES
from mobo_core.evaluation.result import Engine, Result
from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.evaluation.spec_message import spec_from_message
from mobo_core.messages import SCHEMA_VERSION, UNABLE, Candidate, Evaluation
from mobo_core.version import __version__

AUDIT_POSES = 8

AnswerEngine = Literal["kernel", "reference", "simulated"]


@functools.cache
def host_id() -> str:
    """Return a name of this machine: its host name and the first digits of its machine id."""
    try:
        machine = Path("/etc/machine-id").read_text(encoding="ascii").strip()[:8]
    except OSError:
        machine = ""
    return f"{socket.gethostname()}-{machine}".rstrip("-")


class Abilities(NamedTuple):
    """What a worker can do, as its evaluator's heartbeats say.

    Attributes:
        kernel_hash: of the sources of its kernel; "" if it has none.
        objectives: names of those it can evaluate.
    """

    kernel_hash: str = ""
    objectives: tuple[str, ...] = ("reach", "torque")


@dataclass(frozen=True)
class Answering:
    """How an evaluator answers.

    Attributes:
        evaluator: its name.
        engine: ``simulated`` answers numbers made from the URDF's hash, after ``simulated_s`` seconds.
        threads: threads of the kernel.
        simulated_s: seconds of sleep in a simulated evaluation.
    """

    evaluator: str
    engine: AnswerEngine = "kernel"
    threads: int = 1
    simulated_s: float = 0.1

    def load(self) -> Abilities:
        """Import and compile all that answers need. Libraries that a simulated evaluation does without stay out."""
        if self.engine == "simulated":
            return Abilities()
        from mobo_core.evaluation import evaluate  # noqa: F401
        from mobo_core.evaluation.kernel.load import kernel
        from mobo_core.evaluation.kernel_sources import kernel_hash
        from mobo_core.evaluation.objectives import OBJECTIVES

        kernel()
        np.ones((64, 64)) @ np.ones((64, 64))  # BLAS takes its memory at its first product, or ends the process
        return Abilities(kernel_hash(), tuple(OBJECTIVES))

    def answer(self, candidate: Candidate) -> Evaluation:
        """Return the Evaluation of a Candidate.

        OK; or REJECTED with the reason if the candidate is bad; or FAILED if this evaluator is unable to answer
        it (the reason then begins with UNABLE), its audit fails or something unforeseen happens.
        """
        try:
            if candidate.schema_version != SCHEMA_VERSION:
                expected = f"{SCHEMA_VERSION}, this evaluator's"
                raise UnableError(str(candidate.schema_version), where="schema_version", expected=expected)
            if candidate.engine not in ("", self.engine):
                raise UnableError(repr(candidate.engine)[:40], where="engine", expected=self.engine)
            spec = spec_from_message(candidate.spec)
            result = self._evaluate(candidate, spec)
        except UnableError as error:
            return self.refusal(candidate, Evaluation.FAILED, UNABLE + str(error))
        except InputError as error:
            return self.refusal(candidate, Evaluation.REJECTED, str(error))
        except Exception as error:
            traceback.print_exc()
            return self.refusal(candidate, Evaluation.FAILED, f"{type(error).__name__}: {error}")
        if result.audit_fault:
            return self.refusal(candidate, Evaluation.FAILED, result.audit_fault)
        return Evaluation(**self._who(candidate), **result_fields(result))

    def refusal(self, candidate: Candidate, status: int, reason: str) -> Evaluation:
        """Return an Evaluation without values."""
        return Evaluation(**self._who(candidate), status=status, reason=reason[:2000])

    def _who(self, candidate: Candidate) -> dict[str, Any]:
        return {
            "study": candidate.study,
            "trial": candidate.trial,
            "attempt": candidate.attempt,
            "evaluator": self.evaluator,
            "mobo_version": __version__,
            "host_id": host_id(),
        }

    def _evaluate(self, candidate: Candidate, spec: EvaluationSpec) -> Result:
        extra = [name for name in candidate.objectives if name not in ("reach", "torque")]
        for name in extra:
            if name not in OBJECTIVES:
                raise UnableError(f"objective {name!r}", where="objectives", expected=OBJECTIVES.names())
        if self.engine == "simulated":
            return simulated(candidate.urdf, spec, self.simulated_s, extra)
        from mobo_core.evaluation.evaluate import evaluate

        engine: Engine = self.engine
        return evaluate(
            candidate.urdf,
            spec,
            tip=candidate.tip,
            engine=engine,
            threads=self.threads,
            objectives=extra,
            audit_poses=AUDIT_POSES,
            audit_number=candidate.trial,
        )


def result_fields(result: Result) -> dict[str, Any]:
    """Return the fields of an Evaluation that hold a result."""
    same = ("reach", "torque", "voxel_reach", "voxel_torque", "voxel_torque_sd", "attempts", "iterations",
            "seconds", "audit_poses", "audit_max_error")  # fmt: skip
    fields = {name: getattr(result, name) for name in same}
    for reason in ("out_of_range", "not_converged", "in_collision"):
        fields[f"voxel_{reason}"] = getattr(result, reason)
    return fields | {"extra_names": list(result.extra), "extra_values": np.array(list(result.extra.values()))}


def simulated(urdf: str, spec: EvaluationSpec, seconds: float, extra: Sequence[str] = ()) -> Result:
    """Return values made from the hash of ``urdf`` after ``seconds`` of sleep, to test all but evaluation."""
    if seconds:
        time.sleep(seconds)
    digest = hashlib.sha256(urdf.encode()).digest()
    share, torque = (int.from_bytes(digest[i : i + 4], "big") / 2**32 for i in (0, 4))
    n = spec.n_voxels
    none = np.zeros(n, np.int64)
    parts = {name: int.from_bytes(digest[8 + 4 * i : 12 + 4 * i], "big") / 2**32 for i, name in enumerate(extra)}
    return Result(
        spec=spec, reach=share * n, torque=10.0 * torque * n,
        voxel_reach=np.full(n, share), voxel_torque=np.full(n, 10.0 * torque), voxel_torque_sd=np.zeros(n),
        out_of_range=none, not_converged=none, in_collision=none, attempts=0, iterations=0, seconds=seconds,
        joints=(), tip="", extra={name: part * OBJECTIVES[name].bound(spec) for name, part in parts.items()},
    )  # fmt: skip
