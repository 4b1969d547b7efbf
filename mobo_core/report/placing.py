"""The sampling picture of an atlas with an arm that was placed in it."""

from __future__ import annotations

from typing import Literal

from mobo_core.arms.place import Place
from mobo_core.atlas.atlas import Atlas
from mobo_core.errors import visible
from mobo_core.report.figures.drawing import looks, picture
from mobo_core.report.figures.known_marks import Placed
from mobo_core.report.figures.sampling import sampling_figure
from mobo_core.report.known import known_arms_in
from mobo_core.report.row import Row
from mobo_core.report.table import REACH_FLOOR_SHARE, StudyTable
from mobo_core.search.front import pareto_front


def place_picture(found: Place, atlas: Atlas, name: str, kind: Literal["png", "svg"]) -> bytes:
    """Return the picture: the arms on the front of each order, real arms as their twins, and the placed arm, a star.

    Args:
        found: the arm, scaled, and its twin, a hollow star.
        atlas: that it was placed in.
        name: of the atlas.
        kind: png or svg.
    """
    arm = found.arm.name
    placed = [Placed(f"{arm}, scaled", found.scaled.reach, found.scaled.torque, True)]
    if found.twin is not None:
        placed.append(Placed(f"{arm}, its twin", found.twin.reach, found.twin.torque, False))
    known = () if atlas.about.engine == "simulated" else known_arms_in(atlas.space, atlas.spec)
    others = [each for each in known if arm not in each.names]
    with looks():
        title = visible(f"{arm} in {name}: the front of each joint order")
        return picture(sampling_figure(table_of_atlas(atlas), title, others, placed), kind, dpi=120)


def table_of_atlas(atlas: Atlas) -> StudyTable:
    """Return the arms of an atlas as a table of trials, numbered by row."""
    about = atlas.about
    wanted, reach = atlas.wanted, atlas.values["reach"]
    on_front, floor = set(pareto_front(wanted, atlas.aims)), REACH_FLOOR_SHARE * about.n_voxels
    further = [name for name in about.objectives if name not in ("reach", "torque")]
    rows = [
        Row(
            trial=row, complete=True, joints=joints, sampled_joints=joints, lengths=tuple(atlas.lengths[row].tolist()),
            reach=float(reach[row]), torque=float(atlas.values["torque"][row]),
            on_front=row in on_front, above_floor=bool(reach[row] >= floor),
            known_as=(), attempt=0, evaluator="", seconds=0.0, reason="", values=wanted[row],
            extra=tuple((name, float(atlas.values[name][row])) for name in further),
        )
        for row, joints in enumerate(atlas.joints)
    ]  # fmt: skip
    return StudyTable(tuple(rows), atlas.lengths.shape[1], about.n_voxels, atlas.aims)
