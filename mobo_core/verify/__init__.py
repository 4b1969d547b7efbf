"""Whether a bag says the truth. The room itself can be called: ``mobo_core.verify(study)``."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mobo_core.bag.record import StudyRecord
    from mobo_core.verify.verify import Verification


def verify(study: StudyRecord | Path | str, *, sample: int | None = None, workers: int = 1) -> Verification:
    """Check a recorded study, given as read or as its bag: see :func:`mobo_core.verify.verify.verify`.

    Args:
        study: the recording.
        sample: number of evaluations to make again, spread over the study; all if None.
        workers: processes that evaluate.

    Raises:
        InputError: no bag, or not one of a mobo study.
    """
    from mobo_core.bag.collector import read_study
    from mobo_core.verify.verify import verify as check

    recorded = read_study(study) if isinstance(study, Path | str) else study
    return check(recorded, sample=sample, workers=workers)


class _Room(ModuleType):
    __call__ = staticmethod(verify)


sys.modules[__name__].__class__ = _Room
