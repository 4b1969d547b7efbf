"""What a figure of the report is."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Literal, NamedTuple

import matplotlib.figure

from mobo_core.bag.record import StudyRecord
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
