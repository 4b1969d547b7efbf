"""mobo: which robot arm to build. The core: works on files and arrays, knows nothing of ROS.

The public face, each name loaded when it is first used::

    import mobo_core as mobo

    study = mobo.run_study(mobo.StudySettings(seed=1), n_trials=300, workers=2)
    print(study)
    print(mobo.verify(study))
    mobo.report(study, "report")

- ``Design``: one arm: the order of its joints and the lengths of its links
- ``DesignSpace``: the arms a study may choose from
- ``EvaluationSpec``: what is asked of an arm
- ``StudySettings``: all that the trials of a study depend on
- ``evaluate``: what one arm is worth
- ``solve_poses``: inverse kinematics of given poses
- ``run_study``: a study in this process, recorded in a bag
- ``read_study``: a study from its bag
- ``study_table``: its trials as a table; ``.to_pandas()``
- ``verify``: whether a bag says the truth
- ``report``: tables, pictures and a page of a study
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

from mobo_core.version import __version__

if TYPE_CHECKING:
    from mobo_core.bag.collector import read_study
    from mobo_core.coordination.run import run_study
    from mobo_core.design import Design, DesignSpace
    from mobo_core.evaluation.evaluate import evaluate, solve_poses
    from mobo_core.evaluation.spec import EvaluationSpec
    from mobo_core.report import report
    from mobo_core.report.table import study_table
    from mobo_core.search.study import StudySettings
    from mobo_core.verify import verify

# Name -> module that has it.
_PLACES = {
    "Design": "mobo_core.design",
    "DesignSpace": "mobo_core.design",
    "EvaluationSpec": "mobo_core.evaluation.spec",
    "StudySettings": "mobo_core.search.study",
    "evaluate": "mobo_core.evaluation.evaluate",
    "read_study": "mobo_core.bag.collector",
    "report": "mobo_core.report",
    "run_study": "mobo_core.coordination.run",
    "solve_poses": "mobo_core.evaluation.evaluate",
    "study_table": "mobo_core.report.table",
    "verify": "mobo_core.verify",
}

__all__ = [
    "Design", "DesignSpace", "EvaluationSpec", "StudySettings", "__version__", "evaluate", "read_study", "report",
    "run_study", "solve_poses", "study_table", "verify",
]  # fmt: skip


def __getattr__(name: str) -> object:
    """Load a public name."""
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    place = importlib.import_module(_PLACES[name])
    # `report` and `verify` are rooms too, which can be called: whichever is imported first, the name means one thing.
    value: object = place if _PLACES[name] == f"{__name__}.{name}" else getattr(place, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Return the public names, for completion."""
    return sorted({*globals(), *__all__})
