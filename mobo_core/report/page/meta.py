"""What the page's scripts are told of the study, besides its arms."""

from __future__ import annotations

import json
import shlex
from collections.abc import Sequence

from matplotlib.colors import to_hex

from mobo_core.bag.record import StudyRecord
from mobo_core.design.joints import JOINTS, built_types
from mobo_core.design.numbers import middle
from mobo_core.evaluation.colours import TORQUE_SCALE
from mobo_core.evaluation.objectives import OBJECTIVES, SAME_PLACE
from mobo_core.report import uncertainty
from mobo_core.report.figures.drawing import red_to_green
from mobo_core.report.joint_torques import HeldArm
from mobo_core.report.page import arms as page_arms
from mobo_core.report.page import held as page_held
from mobo_core.report.page.blobs import Blob, compressed, pack
from mobo_core.report.page.markup import data
from mobo_core.report.page.palette import page_style
from mobo_core.report.prefixes import styles
from mobo_core.report.row import Row, rank
from mobo_core.report.table import StudyTable
from mobo_core.search.mirror import exact_twins

_STOPS = 17  # colours of the gradation that the page mixes the others from


def elements(
    study: StudyRecord, table: StudyTable, held: Sequence[HeldArm], bag: str
) -> tuple[list[str], list[str]]:
    """Return the page's data as elements, to be read by its scripts; none if no arm was evaluated.

    The second ones, large, are not asked for before an arm is shown.

    Args:
        study: as read from its bag.
        table: its trials.
        held: the arms evaluated again.
        bag: as commands name it.
    """
    rows = table.complete
    if not rows:
        return [], []
    place = {row.trial: i for i, row in enumerate(rows)}
    columns, orders, _ = page_arms.columns(study, rows)
    best_first = sorted(range(len(rows)), key=lambda i: (not rows[i].on_front, rank(rows[i])))
    first = [place[arm.row.trial] for arm in held]
    groups, members = page_arms.voxel_groups(study, rows, dict.fromkeys([*first, *best_first]))
    blob, n_with = page_held.held_blob(held, table.n_joints, table.n_voxels)
    settings = study.settings
    space, spec = settings.space, settings.spec
    steady = uncertainty.steadiness(study, table)
    urdfs = page_arms.urdf_source(study, rows, [arm.row for arm in held])
    meta: dict[str, object] = {
        "bag": shlex.quote(bag),
        "joints": table.n_joints,
        "orders": orders,
        "objectives": list(settings.objectives),
        "further": {name: OBJECTIVES[name].unit for name in table.further},
        "styles": [page_style(style) for style in styles(table)],
        "voxels": spec.n_voxels,
        "shape": list(spec.shape),
        "poses": spec.poses_per_voxel,
        "given": bool(spec.target_poses),
        "workspace_min": list(spec.workspace_min),
        "workspace_max": list(spec.workspace_max),
        "voxel_size": spec.voxel_size,
        "gravity": list(spec.gravity),
        "payload_kg": spec.payload_kg,
        "self_collision": spec.self_collision,
        "base": {"height": middle(space.base_height), "tilt": middle(space.base_tilt)},
        "centers": [middle(center) for center in space.centers],
        "floor": table.floor,
        "same_place": SAME_PLACE,
        "torque_step": page_arms.TORQUE_STEP,
        "torque_ends": [TORQUE_SCALE.green, TORQUE_SCALE.red],
        "q_step": page_held.Q_STEP,
        "gradation": [to_hex(red_to_green()(i / (_STOPS - 1))) for i in range(_STOPS)],
        "joint_colours": {letter: JOINTS[letter].colour for letter in sorted(set("".join(orders)) & set(JOINTS))},
        "material_colours": {joint.long_name: joint.colour for joint in built_types(space.letters)},
        "front": [place[row.trial] for row in table.front],
        "first": place[(table.useful_front or table.front)[0].trial] if table.front else -1,
        "known": [{"row": place[row.trial], "name": ", ".join(row.known_as)} for row in _known(table)],
        "twins": exact_twins({row.joints for row in rows}, space, spec),
        "steady": {str(one.row.trial): one.share for one in steady},
        "evaluated": first,
        "with_voxel_q": n_with,
        "voxel_groups": members,
    }
    small = [
        data("meta", meta),
        data("columns", _blob(pack(columns))),
        data("urdf", {"text": compressed(json.dumps(urdfs).encode())}),
    ]
    return small, [
        data("held", _blob(blob)),
        *(data(f"voxels-{i}", _blob(group)) for i, group in enumerate(groups)),
    ]


def _blob(blob: Blob) -> dict[str, object]:
    return {"places": blob.places, "text": blob.text}


def _known(table: StudyTable) -> list[Row]:
    """Return the best arm of each joint order that a known arm has."""
    best: dict[str, Row] = {}
    for row in sorted((row for row in table.complete if row.known_as), key=rank):
        best.setdefault(row.joints, row)
    return list(best.values())
