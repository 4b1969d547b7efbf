"""Collision shapes as triangles, by Coal's reader of meshes (assimp: STL, OBJ, DAE, PLY, glTF and others)."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import NoReturn
from xml.parsers import expat

import coal
import numpy as np
from numpy.typing import NDArray

from mobo_core.arms.capsules import convex_hull
from mobo_core.arms.packages import MAX_MESH_BYTES, Packages
from mobo_core.arms.robot import Solid
from mobo_core.errors import InputError

Array = NDArray[np.float64]
MAX_TRIANGLES = 2_000_000
_FARTHEST = 1e3  # m


def triangles_of(solid: Solid, packages: Packages) -> Array:
    """Return the triangles (t, 3, 3) of a box or mesh in the frame of its link, m.

    Raises:
        InputError: no such mesh, or it is too large, cannot be read, or has no triangles.
    """
    if solid.kind == "box":
        points, corners = _box(solid)
    else:
        points, corners = _mesh(solid, packages.file(solid.file))
    placed = points @ solid.placed.matrix.T + np.array(solid.placed.xyz)
    found: Array = placed[corners]
    return found


def volume_of(triangles: Array) -> float:
    """Return the volume in m^3 that triangles (t, 3, 3) enclose; of their convex hull where they are not closed."""
    hull = convex_hull(triangles.reshape(-1, 3))
    most = 0.0 if hull is None else float(hull.computeVolume())
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    areas = 0.5 * np.cross(b - a, c - a)
    # The areas of a closed surface, as vectors, add up to nothing.
    if np.linalg.norm(areas.sum(axis=0)) > 1e-4 * np.linalg.norm(areas, axis=1).sum():
        return most
    enclosed = abs(float(np.einsum("ti,ti->", a - a.mean(axis=0), areas))) / 3.0
    return enclosed if 0.05 * most < enclosed < most else most


def model_of(triangles: Array) -> coal.BVHModelOBBRSS:
    """Return triangles (t, 3, 3) as an object of Coal."""
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(triangles), 3 * len(triangles))
    model.addVertices(triangles.reshape(-1, 3))
    model.addTriangles(np.arange(3 * len(triangles)).reshape(-1, 3))
    model.endModel()
    return model


def _box(solid: Solid) -> tuple[Array, NDArray[np.int64]]:
    points = 0.5 * np.array(list(itertools.product(*((-side, side) for side in solid.size))))
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return points, np.array([corners for a, b, c, d in sides for corners in ((a, b, c), (a, c, d))])


def _mesh(solid: Solid, path: Path) -> tuple[Array, NDArray[np.int64]]:
    where = f"mesh {solid.file[-80:]!r}"
    size = path.stat().st_size
    if not 0 < size <= MAX_MESH_BYTES:
        raise InputError(f"{size} bytes", where=where, expected=f"a mesh of up to {MAX_MESH_BYTES // 1_000_000} MB")
    if path.suffix.lower() == ".dae":
        _check_xml(path, where)
    try:
        model = coal.MeshLoader().load(str(path), np.array(solid.size))
        count = int(model.num_tris)
    except Exception as error:  # Coal raises what assimp says
        reason = " ".join(str(error).split())[:160] or type(error).__name__
        raise InputError(f"cannot be read ({reason})", where=where, expected="a mesh such as STL, OBJ or DAE") from None
    if not 0 < count <= MAX_TRIANGLES:
        raise InputError(f"{count} triangles", where=where, expected=f"1 to {MAX_TRIANGLES}")
    points = np.array(model.vertices(), dtype=float).reshape(-1, 3)
    corners = np.array([[t[0], t[1], t[2]] for t in map(model.tri_indices, range(count))], dtype=np.int64)
    if not np.isfinite(points).all() or np.abs(points).max() > _FARTHEST:
        raise InputError("points that are not finite, or far away", where=where, expected=f"m, within {_FARTHEST:g}")
    return points, corners


def _check_xml(path: Path, where: str) -> None:
    """Raise InputError unless a file is well-formed XML without DTD: on what is cut off, assimp never ends."""

    def doctype(*_: object) -> NoReturn:
        raise InputError("forbidden XML (DTDForbidden)", where=where, expected="XML without DTD or entities")

    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = doctype
    try:
        parser.Parse(path.read_bytes(), True)
    except (expat.ExpatError, ValueError, LookupError) as error:
        raise InputError(f"not well-formed XML ({error})", where=where, expected="a COLLADA mesh") from None
