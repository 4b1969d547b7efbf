"""The report of a study: tables, pictures, and a page that shows them."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from matplotlib.figure import Figure

from mobo_core.bag.record import StudyRecord
from mobo_core.outputs import make_folder, write_whole
from mobo_core.report.figures.convergence import hypervolume_figure
from mobo_core.report.figures.drawing import looks, picture
from mobo_core.report.figures.sampling import sampling_figure
from mobo_core.report.figures.voxel_maps import voxel_figure
from mobo_core.report.markup import GENERATOR
from mobo_core.report.page import index_page, study_page
from mobo_core.report.prefixes import Group, found, groups
from mobo_core.report.table import StudyTable, study_table
from mobo_core.report.table_files import FRONT_COLUMNS, table_columns, to_csv

PAGE = "index.html"
_OTHER_MAPS = 4  # voxel maps of prefixes that the paper does not name

Progress = Callable[[int, int], None]


@dataclass
class Report:
    """What was written.

    Attributes:
        folder: where.
        study: what it is of.
        table: the trials.
        groups: of arms by prefix: the paper's, and the others by falling best reach.
        maps: prefix -> file name of its voxel map.
    """

    folder: Path
    study: StudyRecord
    table: StudyTable
    groups: list[Group]
    maps: dict[str, str] = field(default_factory=dict)


def write_report(study: StudyRecord, folder: Path, progress: Progress = lambda done, total: None) -> Report:
    """Write the report of one study into ``folder``; the same study gives the same files, to the byte.

    Args:
        study: as read from its bag.
        folder: made if it is not there; an older report in it is replaced.
        progress: called with (steps done, steps in all).

    Raises:
        InputError: a file cannot be written.
    """
    table = study_table(study)
    report = Report(folder, study, table, groups(table))
    drawn = [group for group in found(report.groups, others=_OTHER_MAPS) if _has_map(study, group)]
    total = len(drawn) + 3
    progress(0, total)
    make_folder(folder)
    _clear(folder)
    write_whole(folder / "front.csv", to_csv(table_columns(table.front, table.n_joints, FRONT_COLUMNS)))
    write_whole(folder / "trials.csv", to_csv(table_columns(table.rows, table.n_joints)))
    with looks():
        figure = sampling_figure(table, f"{study.name}: {len(table.complete)} arms of {table.n_joints} joints")
        pictures = {"sampling.png": picture(figure, "png")}
        write_whole(folder / "sampling.svg", picture(figure, "svg"))
        progress(1, total)
        startup = study.settings.n_startup_trials
        figure = hypervolume_figure(table, startup, f"{study.name}: hypervolume of the front")
        pictures["hypervolume.png"] = picture(figure, "png")
        progress(2, total)
        for i, group in enumerate(drawn):
            name = f"voxels_{file_name(group.prefix)}.png"
            pictures[name] = picture(_map(study, table, group), "png", dpi=120)
            report.maps[group.prefix] = name
            progress(3 + i, total)
    for name, content in pictures.items():
        write_whole(folder / name, content)
    write_whole(folder / PAGE, study_page(study, table, report.groups, report.maps, pictures))
    progress(total, total)
    return report


def write_index(reports: Sequence[Report], folder: Path) -> Path:
    """Write the page that leads to the reports of several studies, in folders below ``folder``; return its path."""
    links = [(report.folder.name, report.study, report.table) for report in reports]
    write_whole(folder / PAGE, index_page(links))
    return folder / PAGE


def report_folders(bags: Sequence[Path], folder: Path) -> list[Path]:
    """Return where the report of each bag goes: ``folder`` itself, or a folder below it named like the bag."""
    if len(bags) == 1:
        return [folder]
    names: list[str] = []
    for bag in bags:
        stem = file_name(bag.resolve().stem if bag.is_file() else bag.resolve().name)
        name, number = stem, 1
        while name in names:
            number += 1
            name = f"{stem}_{number}"
        names.append(name)
    return [folder / name for name in names]


def file_name(text: str) -> str:
    """Return text as a part of a file name: what could mean something else to a file system is left out."""
    return re.sub(r"[^A-Za-z0-9._-]+", "_", text).lstrip(".")[:100] or "study"


def _clear(folder: Path) -> None:
    """Take away the voxel maps of an older report, which need not be of the same prefixes."""
    page = folder / PAGE
    if page.is_file() and GENERATOR in page.read_text(encoding="utf-8", errors="replace")[:1000]:
        for stale in folder.glob("voxels_*.png"):
            stale.unlink(missing_ok=True)


def _has_map(study: StudyRecord, group: Group) -> bool:
    evaluation = study.accepted(group.best.trial) if group.best is not None else None
    n = study.settings.spec.n_voxels
    return evaluation is not None and len(evaluation.voxel_reach) == len(evaluation.voxel_torque) == n


def _map(study: StudyRecord, table: StudyTable, group: Group) -> Figure:
    best = group.best
    assert best is not None
    title = (
        f"{best.joints}, trial {best.trial}: reach {best.reach:.2f} of {table.n_voxels}, torque {best.torque:.1f} N m"
    )
    return voxel_figure(best, study.accepted(best.trial), study.settings.spec, title)
