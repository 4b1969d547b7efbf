"""The pictures of a comparison, in the order of the page."""

from __future__ import annotations

from mobo_core.report.compare.figures import fronts, progress, structures
from mobo_core.report.compare.figures.picture import ComparisonPicture

PICTURES: tuple[ComparisonPicture, ...] = (fronts.PICTURE, progress.PICTURE, structures.PICTURE)
