"""The best arms of a study, and what their files are called."""

from __future__ import annotations

import re

from mobo_core.bag.record import StudyRecord
from mobo_core.report.row import Row, rank
from mobo_core.report.table import StudyTable


def best_rows(study: StudyRecord, table: StudyTable, count: int) -> list[Row]:
    """Return the best arms: those of the front above the reach floor by falling reach, then the others likewise.

    Arms whose candidate the bag has lost are left out.
    """
    first = table.useful_front
    chosen = {row.trial for row in first}
    others = sorted((row for row in table.complete if row.trial not in chosen), key=rank)
    return [row for row in first + others if study.candidate_of(row.trial) is not None][:count]


def best_of_orders(table: StudyTable) -> list[Row]:
    """Return the front above the reach floor and each joint order's arm of the highest reach, by falling reach."""
    best: dict[str, Row] = {}
    for row in sorted(table.complete, key=rank):
        best.setdefault(row.joints, row)
    chosen = {row.trial: row for row in (*table.useful_front, *best.values())}
    return sorted(chosen.values(), key=rank)


def urdf_name(place: int, row: Row, count: int) -> str:
    """Return the file name of an arm, such as ``1_PRRYPY_trial123.urdf``; places sort as text."""
    joints = re.sub(r"[^A-Za-z0-9]", "_", row.joints)[:64]  # a bag may claim anything
    return f"{place:0{len(str(count))}d}_{joints}_trial{row.trial}.urdf"
