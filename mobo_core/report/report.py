"""The report of a study: tables, pictures, and a page that shows them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from threading import Lock

from mobo_core.atlas.atlas import Atlas
from mobo_core.atlas.regret import Regret, regret
from mobo_core.bag.record import StudyRecord
from mobo_core.outputs import make_folder, write_whole
from mobo_core.report import reproduce
from mobo_core.report.claims.check import check_claims
from mobo_core.report.claims.claim import Pair
from mobo_core.report.claims.evidence import of_study
from mobo_core.report.columns import FRONT_COLUMNS, Columns, table_columns, without_hosts
from mobo_core.report.figures.registry import FIGURES
from mobo_core.report.figures.render import render
from mobo_core.report.joint_torques import held_arms, torque_columns
from mobo_core.report.names import file_name
from mobo_core.report.own_atlas import order_columns, own_atlas
from mobo_core.report.page.claims_section import claims_section
from mobo_core.report.page.index_page import index_page
from mobo_core.report.page.markup import GENERATOR
from mobo_core.report.page.orders import orders_section
from mobo_core.report.page.study_page import study_page
from mobo_core.report.prefixes import Group, groups
from mobo_core.report.table import StudyTable, study_table
from mobo_core.report.table_files import has_parquet, to_csv, to_parquet

PAGE = "index.html"

Progress = Callable[[int, int], None]


@dataclass
class Report:
    """What was written.

    Attributes:
        folder: where.
        study: what it is of.
        table: the trials.
        groups: of arms by prefix: the paper's, and the others by falling best reach.
        regret: how far it is from an atlas; None if it was compared with none.
    """

    folder: Path
    study: StudyRecord
    table: StudyTable
    groups: list[Group]
    regret: Regret | None = None


def write_report(
    study: StudyRecord,
    folder: Path,
    progress: Progress = lambda done, total: None,
    *,
    bag: str = "",
    pinned: Collection[int] = (),
    hosts: bool = False,
    atlas: Atlas | None = None,
    no_atlas: str = "",
) -> Report:
    """Write the report of one study into ``folder``; the same study gives the same files, to the byte.

    Args:
        study: as read from its bag.
        folder: made if it is not there; an older report in it is replaced.
        progress: called with (done, in all): arms evaluated again for their joints' torques, and pictures.
        bag: as the page's commands name it; by default the study's path.
        pinned: trials to evaluate again whatever they are worth.
        hosts: whether ``trials.csv`` names the evaluators, which tells their hosts; else it numbers them.
        atlas: to compare the study with, of the same question (see :func:`mobo_core.atlas.regret.fitting_atlas`).
        no_atlas: why there is none, for the page.

    Raises:
        InputError: a file cannot be written.
    """
    table = study_table(study)
    own = own_atlas(study, table)
    report = Report(folder, study, table, groups(table), regret(own, atlas) if atlas is not None else None)
    make_folder(folder)
    parts = _Parts(progress)
    # The kernel computes while the pictures are drawn.
    with ThreadPoolExecutor(1) as beside:
        evaluating = beside.submit(held_arms, study, table, parts.of("arms"), pinned)
        figures = render(study, table, parts.of("pictures"))
        arms = evaluating.result()
    tables = {
        "front": table_columns(table.front, table.n_joints, FRONT_COLUMNS),
        "trials": table_columns(table.rows if hosts else without_hosts(table.rows), table.n_joints),
        "joint_torques": torque_columns(arms),
        "atlas_orders": order_columns(own, report.regret),
    }
    files: dict[str, bytes | str] = {}
    for figure in figures:
        tables |= figure.tables
        files |= figure.files
    files |= _table_files(tables)
    files |= reproduce.files(study.settings)
    orders = [*orders_section(study, table, tables["atlas_orders"], atlas, report.regret, no_atlas)]
    files[PAGE] = study_page(
        study, table, report.groups, figures, arms, bag=bag or str(study.path), files=sorted(set(files) - {PAGE}),
        orders=orders,
    )  # fmt: skip
    _clear(folder, files)
    for name, content in files.items():
        write_whole(folder / name, content)
    return report


class _Parts:
    """Adds up how far the parts of the work have come."""

    def __init__(self, progress: Progress) -> None:
        self._progress, self._lock = progress, Lock()
        self._parts: dict[str, tuple[int, int]] = {}

    def of(self, name: str) -> Progress:
        def told(done: int, total: int) -> None:
            with self._lock:
                self._parts[name] = (done, total)
                self._progress(*(sum(part) for part in zip(*self._parts.values(), strict=True)))

        return told


def _table_files(tables: Mapping[str, Columns]) -> dict[str, bytes | str]:
    files: dict[str, bytes | str] = {f"{name}.csv": to_csv(columns) for name, columns in tables.items()}
    if has_parquet():
        files |= {f"{name}.parquet": to_parquet(columns) for name, columns in tables.items()}
    return files


def write_index(reports: Sequence[Report], folder: Path) -> Path:
    """Write the page that leads to the reports of several studies, in folders below ``folder``; return its path."""
    links = [(report.folder.name, report.study, report.table) for report in reports]
    write_whole(folder / PAGE, index_page(links, _claims(reports)))
    return folder / PAGE


def _claims(reports: Sequence[Report]) -> list[str]:
    """Return the section on the paper's claims, if there is one study of 6 joints and one of 7."""
    by_joints = {report.table.n_joints: report for report in reports if report.table.complete}
    if len(reports) != 2 or set(by_joints) != {6, 7}:
        return []
    six, seven = (of_study(by_joints[n].study, by_joints[n].table) for n in (6, 7))
    pair = Pair(six, seven)
    return [claims_section(check_claims(pair, evaluate=False), pair.apart)]


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


def _clear(folder: Path, kept: Collection[str]) -> None:
    """Take away the pictures and tables of an older report that the new one does not replace."""
    page = folder / PAGE
    if page.is_file() and GENERATOR in page.read_text(encoding="utf-8", errors="replace")[:1000]:
        for figure in FIGURES.values():
            for kind in figure.kinds:
                for file in (folder / f"{figure.name}.{kind}", *folder.glob(f"{figure.name}_*.{kind}")):
                    if file.name not in kept:
                        file.unlink(missing_ok=True)
        for file in folder.glob("*.parquet"):
            if file.name not in kept and file.with_suffix(".csv").name in kept:  # written where pyarrow was
                file.unlink(missing_ok=True)
