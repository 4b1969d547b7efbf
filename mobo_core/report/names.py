"""Names of files that a report takes from a study's own names."""

from __future__ import annotations

import re


def file_name(text: str) -> str:
    """Return text as a part of a file name: what could mean something else to a file system is left out."""
    return re.sub(r"[^A-Za-z0-9._-]+", "_", text).lstrip(".")[:100] or "study"
