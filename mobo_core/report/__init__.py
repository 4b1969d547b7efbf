"""What a study means: tables, pictures, a page. The room itself can be called: ``mobo_core.report(study, folder)``."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mobo_core.bag.record import StudyRecord
    from mobo_core.report.report import Report


def report(study: StudyRecord | Path | str, folder: Path | str) -> Report:
    """Write the report of a study, given as read or as its bag: see :func:`mobo_core.report.report.write_report`.

    Args:
        study: what it is of.
        folder: made if it is not there; an older report in it is replaced.

    Raises:
        InputError: no bag, or not one of a mobo study; a file that cannot be written.
    """
    from mobo_core.atlas.regret import fitting_atlas
    from mobo_core.bag.collector import read_study
    from mobo_core.report.own_atlas import engine_of
    from mobo_core.report.report import write_report

    recorded = read_study(study) if isinstance(study, Path | str) else study
    atlas, why = fitting_atlas(recorded.settings, engine_of(recorded))
    return write_report(recorded, Path(folder), atlas=atlas, no_atlas=why)


class _Room(ModuleType):
    __call__ = staticmethod(report)


sys.modules[__name__].__class__ = _Room
