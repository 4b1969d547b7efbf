"""The atlas of a study alone: the front of each order, and how far it has come."""

from __future__ import annotations

import math

from mobo_core.atlas.atlas import Atlas, fronts_of
from mobo_core.atlas.reading import names_of
from mobo_core.atlas.regret import Regret
from mobo_core.atlas.trials import Rows
from mobo_core.bag.record import StudyRecord
from mobo_core.report.columns import Cell, Columns
from mobo_core.report.once import once
from mobo_core.report.table import StudyTable
from mobo_core.search.front import hypervolume


def engine_of(study: StudyRecord) -> str:
    """Return the engine that evaluated a study's arms; "" if its bag does not say."""
    return study.settings.engine or next((each.engine for each in study.candidates if each.engine), "")


@once
def own_atlas(study: StudyRecord, table: StudyTable) -> Atlas:
    """Return the atlas of a study's trials. The heights of bases are left out."""
    names, n = names_of(study.settings.objectives), table.n_joints
    rows = Rows(names, n)
    for row in table.rows:
        if len(row.joints) == len(row.lengths) == n:
            values = {"reach": row.reach, "torque": row.torque, **dict(row.extra)}
            good = [values[name] for name in names] if row.complete else [math.nan] * len(names)
            rows.add(0, row.trial, row.joints, row.lengths, (0.0, 0.0), good)
    return fronts_of(rows.trials(), study.settings, [{"name": study.name}], engine_of(study))


def order_columns(atlas: Atlas, regret: Regret | None = None) -> Columns:
    """Return a row an order: trials, front, how far it has come, and how far it is from another atlas."""
    wanted, aims = atlas.wanted, atlas.aims
    of = {one.joints: one for one in regret.orders} if regret is not None else {}
    lines: list[dict[str, Cell]] = []
    for joints, rows in atlas.orders.items():
        best = int(rows[0])
        line: dict[str, Cell] = {
            "joints": joints,
            "mirror_twin": atlas.twin[best],
            "trials": int(atlas.trials_of_order[best]),
            "arms_on_its_front": len(rows),
            "best_reach": float(atlas.values["reach"][best]),
            "torque_of_best": float(atlas.values["torque"][best]),
            "hypervolume": hypervolume([wanted[row] for row in rows], aims),
            "expected_gain": float(atlas.expected_gain[best]),
        }
        if regret is not None:
            line |= {"voxels_short": of[joints].short}
            line |= {"hypervolume_short": of[joints].of_hypervolume - of[joints].hypervolume}
        lines.append(line)
    return {name: [line[name] for line in lines] for name in (lines[0] if lines else ())}
