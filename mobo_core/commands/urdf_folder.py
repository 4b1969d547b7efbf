"""URDFs into a folder of their own."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from mobo_core.errors import InputError
from mobo_core.outputs import make_folder, write_whole

MANIFEST = "manifest.json"


def write_urdfs(folder: Path, urdfs: Mapping[str, str], manifest: Mapping[str, object] | None = None) -> None:
    """Write URDFs, by the names of their files, into a folder, made if it is not there; and what is said of them.

    Raises:
        InputError: it holds URDFs of other names, or cannot be written.
    """
    make_folder(folder)
    strangers = sorted(file.name for file in folder.glob("*.urdf") if file.name not in urdfs)
    if strangers:
        raise InputError(f"holds {strangers[0]}", where=str(folder), expected="a folder without other URDF files")
    for name, urdf in urdfs.items():
        write_whole(folder / name, urdf.encode("utf-8"))
    if manifest is not None:
        write_whole(folder / MANIFEST, json.dumps(manifest, indent=2) + "\n")
