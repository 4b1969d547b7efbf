"""Pictures of the best arms' voxels, one for each prefix."""

from __future__ import annotations

from collections.abc import Iterator

from mobo_core.bag.record import StudyRecord
from mobo_core.messages import Evaluation
from mobo_core.report.figures.figure import Figure, Picture, View, script_beside
from mobo_core.report.figures.voxel_layers import voxel_figure
from mobo_core.report.prefixes import found, groups
from mobo_core.report.row import Row
from mobo_core.report.table import StudyTable

_OTHER_PREFIXES = 4  # drawn beside those that the paper names


def _draw(study: StudyRecord, table: StudyTable) -> Iterator[Picture]:
    spec = study.settings.spec
    for prefix, best, evaluation in _best(study, table):
        values = f"reach {best.reach:.2f} of {table.n_voxels}, torque {best.torque:.1f} N m"
        canvas = voxel_figure(best, evaluation, spec, f"{best.joints}, trial {best.trial}: {values}")
        yield Picture(canvas, prefix, f"The arm of the highest reach that begins {prefix}.")


def _best(study: StudyRecord, table: StudyTable) -> Iterator[tuple[str, Row, Evaluation]]:
    """Yield the shown prefixes with the arm of the highest reach and its evaluation; given poses have no map."""
    if study.settings.spec.target_poses:
        return
    for group in found(groups(table), others=_OTHER_PREFIXES):
        best = group.best
        evaluation = study.accepted(best.trial) if best is not None else None
        if best is None or evaluation is None:
            continue
        if len(evaluation.voxel_reach) == len(evaluation.voxel_torque) == study.settings.spec.n_voxels:
            yield group.prefix, best, evaluation


def _data(study: StudyRecord, table: StudyTable) -> object:
    return {"arms": [[prefix, best.trial] for prefix, best, _ in _best(study, table)]}


FIGURE = Figure(
    name="voxels",
    heading="Where the arms reach, and at what torque",
    caption="The arm of the highest reach of each prefix, voxel by voxel.",
    draw=_draw,
    view=View(_data, script_beside(__file__)),
    parts="PREFIX",
    dpi=120,
)
