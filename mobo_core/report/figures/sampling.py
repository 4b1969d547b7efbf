"""The picture of a study's sampling: every arm by reach and torque, coloured by its first four joints."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas
from matplotlib.lines import Line2D

from mobo_core.bag.record import StudyRecord
from mobo_core.report.columns import Columns
from mobo_core.report.figures.drawing import FAINT, INK, plain
from mobo_core.report.figures.figure import Figure, Picture, View, script_beside
from mobo_core.report.figures.known_marks import Placed, known_labels, mark_known, mark_placed, placed_labels
from mobo_core.report.figures.labels import Label, place_labels
from mobo_core.report.known import KnownArm, known_arms_of, known_columns
from mobo_core.report.prefixes import prefix_of, styles
from mobo_core.report.row import Row, rank
from mobo_core.report.table import StudyTable

_OTHERS = "#cfcfcf"
_BEHIND: dict[str, object] = {"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.8}
_BEST = Line2D(
    [], [], linestyle="", marker="+", markersize=7, markeredgewidth=1.4, color=INK, label="best of a known order"
)
_RASTER_FROM = 3000  # points; above it an SVG holds them as a picture


def sampling_figure(
    table: StudyTable, title: str, known: Sequence[KnownArm] = (), placed: Sequence[Placed] = ()
) -> Canvas:
    """Return the scatter of all complete trials: the paper's colours, the front ringed, known arms named.

    Reach is the sum over the voxels, torque in N m likewise, so that better arms lie to the lower right.

    Args:
        table: the trials.
        title: of the picture.
        known: real arms as they stand in the study; without them the best trial of each order that one has is named.
        placed: further marks.
    """
    figure = Canvas(figsize=(9.6, 6.0), layout="constrained")
    axes = figure.add_subplot()
    axes.set_title(plain(title), loc="left", pad=12)
    axes.set_xlabel(f"reachability $E^{{\\mathrm{{reach}}}}$  [of {table.n_voxels} voxels]")
    axes.set_ylabel("joint torque $E^{\\mathrm{torque}}$  [N m, summed over voxels]")
    axes.grid(True)
    if table.complete:
        more = [*((arm.reach, arm.torque) for arm in known), *((arm.reach, arm.torque) for arm in placed)]
        _set_limits(axes, table, more)
        best = [] if known else _best_of_known_orders(table)
        figure.legend(
            handles=[
                *_arms(axes, table),
                *_front(axes, table),
                *([_BEST] if best else []),
                *mark_known(axes, known),
                *mark_placed(axes, placed),
            ],
            loc="outside right upper",
            title="first four joints",
            alignment="left",
            handletextpad=0.5,
            labelspacing=0.55,
        )
        axes.annotate(
            "better",
            (0.985, 0.03),
            xycoords="axes fraction",
            xytext=(-46, 26),
            textcoords="offset points",
            color=FAINT,
            fontsize=9,
            ha="center",
            va="bottom",
            arrowprops={"arrowstyle": "-|>", "color": FAINT, "linewidth": 1.0},
            bbox=_BEHIND,
            zorder=5,
        )
        labels = placed_labels(placed) + (known_labels(axes, known) if known else _mark_best(axes, best))
        points = [(row.reach, row.torque, 8.0 if row.on_front else 1.0) for row in table.complete]
        points += [(arm.reach, arm.torque, 4.0) for arm in known] + [(arm.reach, arm.torque, 200.0) for arm in placed]
        place_labels(figure, axes, labels, points)
    else:
        axes.set(xlim=(0, table.n_voxels), ylim=(0, 10 * table.n_voxels))
        axes.text(0.5, 0.5, "no complete trial", transform=axes.transAxes, ha="center", color=FAINT)
    return figure


def _set_limits(axes: Axes, table: StudyTable, more: Sequence[tuple[float, float]]) -> None:
    points = [(row.reach, row.torque) for row in table.complete] + list(more)
    reach, torque = (max(values) for values in zip(*points, strict=True))
    right, top = 1.06 * max(reach, table.floor), 1.06 * max(torque, 1.0)
    axes.set(xlim=(-0.02 * right, right), ylim=(-0.02 * top, top))


def _arms(axes: Axes, table: StudyTable) -> list[Line2D]:
    drawn = styles(table)
    own = {style.prefix for style in drawn}
    raster = len(table.complete) > _RASTER_FROM
    size = 34.0 if len(table.complete) <= 1000 else 20.0
    rest = [row for row in table.complete if prefix_of(row) not in own]
    axes.scatter(*_xy(rest), s=0.5 * size, c=_OTHERS, linewidths=0, rasterized=raster, zorder=2)
    handles = []
    for place, style in enumerate(drawn):
        rows = [row for row in table.complete if prefix_of(row) == style.prefix]
        axes.scatter(
            *_xy(rows),
            s=size,
            c=style.colour,
            marker=style.marker,
            edgecolors="white",
            linewidths=0.4,
            rasterized=raster,
            zorder=4 - 0.1 * place,
        )
        handles.append(_handle(plain(f"{style.prefix}  ({len(rows)})"), style.colour, style.marker))
    if rest:
        handles.append(_handle(f"others  ({len(rest)})", _OTHERS, "o", size=5.0))
    return handles


def _handle(label: str, colour: str, marker: str, size: float = 7.0) -> Line2D:
    return Line2D(
        [], [], linestyle="", marker=marker, color=colour, markeredgecolor="white", markeredgewidth=0.4,
        markersize=size, label=label,
    )  # fmt: skip


def _front(axes: Axes, table: StudyTable) -> list[Line2D]:
    size = 110.0 if len(table.complete) <= 1000 else 70.0
    axes.scatter(*_xy(table.front), s=size, facecolors="none", edgecolors="black", linewidths=1.3, zorder=6)
    axes.axvline(table.floor, color=FAINT, linewidth=0.9, linestyle=(0, (4, 4)), zorder=1)
    axes.annotate(
        f"reach floor {table.floor:g}",
        (table.floor, 1.0),
        xycoords=("data", "axes fraction"),
        xytext=(4, -4),
        textcoords="offset points",
        rotation=90,
        va="top",
        fontsize=8.5,
        color=FAINT,
        bbox=_BEHIND,
        zorder=5,
    )
    ring = Line2D(
        [], [], linestyle="", marker="o", markersize=9.5, markerfacecolor="none", markeredgecolor="black",
        markeredgewidth=1.3, label=f"Pareto front  ({len(table.front)})",
    )  # fmt: skip
    return [ring]


def _best_of_known_orders(table: StudyTable) -> list[Row]:
    """Return the best arm of each joint order that a known arm has."""
    best: dict[tuple[str, ...], Row] = {}
    for row in sorted((row for row in table.complete if row.known_as), key=rank):
        best.setdefault(row.known_as, row)
    return list(best.values())


def _mark_best(axes: Axes, rows: list[Row]) -> list[Label]:
    axes.scatter(*_xy(rows), s=26, c="black", marker="+", linewidths=1.4, zorder=7)
    return [Label(row.reach, row.torque, _known_text(row)) for row in rows]


def _known_text(row: Row) -> str:
    names = list(row.known_as)
    shown = ", ".join(names[:2]) + (f" + {len(names) - 2}" if len(names) > 2 else "")
    return plain(f"{row.joints}\n{shown}")


def _xy(rows: list[Row]) -> tuple[list[float], list[float]]:
    return [row.reach for row in rows], [row.torque for row in rows]


def _draw(study: StudyRecord, table: StudyTable) -> Iterator[Picture]:
    title = f"{study.name}: {len(table.complete)} arms of {table.n_joints} joints"
    yield Picture(sampling_figure(table, title, known_arms_of(study, table)))


def _tables(study: StudyRecord, table: StudyTable) -> Mapping[str, Columns]:
    known = known_arms_of(study, table)
    return {"known_arms": known_columns(known)} if known else {}


def _data(study: StudyRecord, table: StudyTable) -> object:
    return [
        {
            "names": list(arm.names), "joints": arm.joints, "hollow": arm.estimated,
            "values": {"reach": arm.reach, "torque": arm.torque, **dict(arm.extra)}
            | {f"length_{i}": length for i, length in enumerate(arm.lengths, start=1)},
        }
        for arm in known_arms_of(study, table)
    ]  # fmt: skip


FIGURE = Figure(
    name="sampling",
    heading="",
    caption="All arms by reach and torque. The front is ringed in black; diamonds are real arms, as their twins in the "
    "study's space, hollow where no source says their masses.",
    draw=_draw,
    svg=True,
    view=View(_data, script_beside(__file__)),
    tables=_tables,
)
