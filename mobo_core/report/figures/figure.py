"""What a figure of the report is."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

import matplotlib.figure

from mobo_core.bag.record import StudyRecord
from mobo_core.report.columns import Columns
from mobo_core.report.table import StudyTable

Kind = Literal["png", "svg"]


class Picture(NamedTuple):
    """One picture of a figure.

    Attributes:
        canvas: what is drawn.
        part: which of the figure's pictures it is, a part of its file's name; "" if there is only one.
        caption: below it; "": that of the figure.
    """

    canvas: matplotlib.figure.Figure
    part: str = ""
    caption: str = ""


@dataclass(frozen=True)
class View:
    """What the page shows of a figure in place of its pictures, for which it has a fold then.

    Attributes:
        data: returns plain data, which the script is given.
        script: JavaScript that calls ``mobo.view(NAME, (root, data, study) => …)`` with the figure's name, and adds to
            the element ``root`` what it shows; ``study`` is what page/scripts/study.js defines.
    """

    data: Callable[[StudyRecord, StudyTable], object]
    script: str


def script_beside(module: str) -> str:
    """Return the JavaScript in the file that is named like a module (its ``__file__``), with the suffix ``.js``."""
    return Path(module).with_suffix(".js").read_text(encoding="utf-8")


@dataclass(frozen=True)
class Figure:
    """A figure of the report: one picture, or one of each of several things.

    Its files are ``NAME.png``, or ``NAME_PART.png`` for a picture that names its part. The same study must give the
    same pictures.

    Attributes:
        name: of lower-case letters, digits and underscores.
        heading: above it on the page; "" puts it at the top of the page, before the tables.
        caption: below a picture that has none of its own, and in ``mobo report --help``.
        draw: returns the pictures of a study; none if there is nothing to show.
        parts: what the parts are, for ``mobo report --help``, such as ``PREFIX``; "" if there is one picture only.
        svg: whether each picture is written as SVG too.
        dpi: dots per inch of the PNG.
        view: what the page shows in place of the pictures; None: the pictures.
        tables: returns the numbers behind it, columns by name of the file, which becomes ``NAME.csv`` and
            ``NAME.parquet``; None if there are none of its own.

    Raises:
        ValueError: a name that is no part of a file name.
    """

    name: str
    heading: str
    caption: str
    draw: Callable[[StudyRecord, StudyTable], Iterable[Picture]]
    parts: str = ""
    svg: bool = False
    dpi: int = 160
    view: View | None = None
    tables: Callable[[StudyRecord, StudyTable], Mapping[str, Columns]] | None = None

    def __post_init__(self) -> None:
        if not re.fullmatch(r"[a-z][a-z0-9_]*", self.name):
            raise ValueError(f"name {self.name!r}, not lower-case letters, digits and underscores")

    @property
    def files(self) -> str:
        """Its files' names for people, such as ``voxels_<PREFIX>.png``."""
        stem = f"{self.name}_<{self.parts}>" if self.parts else self.name
        return f"{stem}.png and .svg" if self.svg else f"{stem}.png"

    @property
    def kinds(self) -> tuple[Kind, ...]:
        """Suffixes of its files."""
        return ("png", "svg") if self.svg else ("png",)
