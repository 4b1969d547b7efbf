"""Reads a mesh in a process of its own: `python -m mobo_core.arms.mesh_reader FILE X Y Z`, scaled, as .npz on stdout.

Assimp, by which Coal reads meshes, never ends on some damaged files, or takes the process with it.
"""

from __future__ import annotations

import io
import sys
from pathlib import Path

import coal
import numpy as np
from numpy.typing import NDArray


def read(path: Path, scale: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return a mesh's points (p, 3), scaled, and each triangle's three of them (t, 3)."""
    model = coal.MeshLoader().load(str(path), scale)
    points = np.array(model.vertices(), dtype=float).reshape(-1, 3)
    corners = [tuple(model.tri_indices(i)[k] for k in range(3)) for i in range(int(model.num_tris))]
    return points, np.array(corners, dtype=np.int64).reshape(-1, 3)


def main(file: str, *scale: str) -> int:
    """Write the mesh to standard output; 2 if it cannot be read, with the reason on standard error."""
    try:
        points, corners = read(Path(file), np.array(scale, dtype=float))
    except Exception as error:  # Coal raises what assimp says
        print(" ".join(str(error).split()) or type(error).__name__, file=sys.stderr)
        return 2
    found = io.BytesIO()
    np.savez(found, points=points, corners=corners)
    sys.stdout.buffer.write(found.getvalue())
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
