"""The part of the page on how well each joint order is known, and how far the study is from an atlas."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape

from mobo_core.atlas.atlas import Atlas, partial
from mobo_core.atlas.regret import Regret, voxels_within
from mobo_core.bag.record import StudyRecord
from mobo_core.report.columns import Columns
from mobo_core.report.page import markup
from mobo_core.report.table import StudyTable

_MOST_OPEN = 15
_NOT_TRIED = 12


def orders_section(
    study: StudyRecord, table: StudyTable, columns: Columns, atlas: Atlas | None, regret: Regret | None, why: str
) -> Iterator[str]:
    """Yield the part; nothing if no trial is complete.

    Args:
        study: what the page is of.
        table: its trials.
        columns: of its orders, as ``atlas_orders.csv`` has them.
        atlas: that it is compared with.
        regret: how far it is from that.
        why: it is compared with none.
    """
    if not columns:
        return
    within = voxels_within(study.settings.space, study.settings.spec)
    body = []
    if atlas is not None and regret is not None:
        few = partial(atlas)
        body.append(
            f"<p>Against an atlas of {atlas.about.trials:,} trials of {atlas.about.orders} orders: hypervolume "
            f"<b>{escape(str(regret))}</b>.{f' The atlas is {escape(few)}.' if few else ''}</p>"
        )
        never = [one.joints for one in regret.orders if not one.trials]
        if never:
            more = f" and {len(never) - _NOT_TRIED} more" if never[_NOT_TRIED:] else ""
            some = ", ".join(never[:_NOT_TRIED]) + more
            body.append(f"<p>Of the atlas's orders the study has no arm of {escape(some)}.</p>")
    elif why:
        body.append(f'<p class="note">{escape(why)}.</p>')
    body.append(
        f"<p>{within} of {table.n_voxels} voxels lie within the arm's length: no arm reaches more. "
        f"{len({row.joints for row in table.useful_front})} orders hold the front above the reach floor.</p>"
    )
    head = {
        "joints": "order", "mirror_twin": "twin", "trials": "trials", "best_reach": "best reach",
        "torque_of_best": "torque [N m]", "hypervolume": "hypervolume", "expected_gain": "to gain",
        "voxels_short": "voxels short", "hypervolume_short": "hypervolume short",
    }  # fmt: skip
    names = [name for name in head if name in columns]
    rows = [[_text(name, value) for name, value in zip(names, line, strict=True)]
            for line in zip(*(columns[name] for name in names), strict=True)]  # fmt: skip
    shown = markup.table([head[name] for name in names], rows[:_MOST_OPEN], right=range(2, len(names)))
    body.append(shown)
    if rows[_MOST_OPEN:]:
        rest = markup.table([head[name] for name in names], rows[_MOST_OPEN:], right=range(2, len(names)))
        body.append(markup.fold(f"{len(rows) - _MOST_OPEN} more orders", [rest]))
    body.append(
        '<p class="note">To gain: the hypervolume that as many trials again may be expected to add to the order\'s own '
        "(docs/atlas.md). All of it: atlas_orders.csv.</p>"
    )
    yield markup.section("orders", "How well each order is known", body, nav="Orders")


def _text(name: str, value: object) -> str:
    if not isinstance(value, float):
        return str(value)
    digits = {"best_reach": 2, "torque_of_best": 1, "voxels_short": 1}.get(name, 4)
    return f"{value:.{digits}f}"
