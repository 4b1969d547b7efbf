"""The figures of a study as the bytes of files."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import NamedTuple

from mobo_core.bag.record import StudyRecord
from mobo_core.report.columns import Columns
from mobo_core.report.figures.drawing import looks, picture
from mobo_core.report.figures.figure import Figure, Picture
from mobo_core.report.figures.registry import FIGURES
from mobo_core.report.names import file_name
from mobo_core.report.table import StudyTable


class Shown(NamedTuple):
    """A picture of the page: its caption, and the PNG."""

    caption: str
    png: bytes


@dataclass
class Rendered:
    """A figure's pictures and files.

    Attributes:
        figure: what it is.
        shown: its pictures.
        files: file name -> content.
        tables: name of the file without its suffix -> columns.
        data: of its view.
    """

    figure: Figure
    shown: list[Shown] = field(default_factory=list)
    files: dict[str, bytes] = field(default_factory=dict)
    tables: dict[str, Columns] = field(default_factory=dict)
    data: object = None


def render(study: StudyRecord, table: StudyTable, progress: Callable[[int, int], None]) -> list[Rendered]:
    """Return the figures that have something to show of a study.

    One of another distribution that raises is told on standard error, in one line, and left out.

    Args:
        study: as read from its bag.
        table: its trials.
        progress: called with (pictures done, pictures in all).
    """
    drawn: list[tuple[Figure, Sequence[Picture]]] = []
    for figure in FIGURES.values():
        with _spared(figure), looks():
            drawn.append((figure, list(figure.draw(study, table))))
    total, done = sum(len(pictures) for _, pictures in drawn), 0
    progress(done, total)

    def step() -> None:
        nonlocal done
        done += 1
        progress(done, total)

    rendered = []
    for figure, pictures in drawn:
        with _spared(figure), looks():
            done_one = _rendered(figure, pictures, step)
            if done_one.shown and figure.tables is not None:
                done_one.tables = dict(figure.tables(study, table))
            if done_one.shown and figure.view is not None:
                done_one.data = figure.view.data(study, table)
            rendered.append(done_one)
    return [figure for figure in rendered if figure.shown]


def _rendered(figure: Figure, pictures: Sequence[Picture], step: Callable[[], None]) -> Rendered:
    out = Rendered(figure)
    for one in pictures:
        stem = f"{figure.name}_{file_name(one.part)}" if one.part else figure.name
        for kind in figure.kinds:
            name = f"{stem}.{kind}"
            if name in out.files:
                raise ValueError(f"two pictures for {name}")
            out.files[name] = picture(one.canvas, kind, figure.dpi)
        out.shown.append(Shown(one.caption or figure.caption, out.files[f"{stem}.png"]))
        step()
    return out


@contextmanager
def _spared(figure: Figure) -> Iterator[None]:
    """Tell what another distribution's figure raises, and go on; what mobo's own raise is raised."""
    try:
        yield
    except Exception as error:
        if figure in FIGURES.built_in:
            raise
        text = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        print(f"mobo: figure {figure.name!r} left out: {text}", file=sys.stderr, flush=True)
