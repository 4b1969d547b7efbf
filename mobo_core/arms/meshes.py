"""Collision shapes as triangles, by Coal's reader of meshes (assimp: STL, OBJ, DAE, PLY, glTF and others)."""

from __future__ import annotations

import io
import itertools
import subprocess
import sys
from pathlib import Path
from typing import NoReturn
from xml.parsers import expat

import coal
import numpy as np
from numpy.typing import NDArray

from mobo_core.arms import mesh_reader
from mobo_core.arms.capsules import convex_hull
from mobo_core.arms.packages import MAX_MESH_BYTES, Packages
from mobo_core.arms.robot import Solid
from mobo_core.errors import InputError

Array = NDArray[np.float64]
MAX_TRIANGLES = 2_000_000
_FARTHEST = 1e3  # m
READING_S = 60.0


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
    points, corners = _read(path, np.array(solid.size), where)
    if not 0 < len(corners) <= MAX_TRIANGLES:
        raise InputError(f"{len(corners)} triangles", where=where, expected=f"1 to {MAX_TRIANGLES}")
    if not np.isfinite(points).all() or np.abs(points).max() > _FARTHEST:
        raise InputError("points that are not finite, or far away", where=where, expected=f"m, within {_FARTHEST:g}")
    return points, corners


def _read(path: Path, scale: Array, where: str) -> tuple[Array, NDArray[np.int64]]:
    """Return a mesh's points and corners; of formats other than STL, some files hang their reader: see there."""

    def unread(reason: str) -> InputError:
        return InputError(f"cannot be read ({reason[:160]})", where=where, expected="a mesh such as STL, OBJ or DAE")

    if path.suffix.lower() == ".stl":
        try:
            return mesh_reader.read(path, scale)
        except Exception as error:  # Coal raises what assimp says
            raise unread(" ".join(str(error).split()) or type(error).__name__) from None
    command = [sys.executable, "-m", mesh_reader.__name__, str(path.absolute()), *map(repr, scale.tolist())]
    try:
        run = subprocess.run(command, capture_output=True, stdin=subprocess.DEVNULL, timeout=READING_S, check=False)
    except subprocess.TimeoutExpired:
        raise unread(f"not within {READING_S:g} s") from None
    if run.returncode:
        said = run.stderr.decode(errors="replace").strip().splitlines()
        raise unread(said[-1] if run.returncode == 2 and said else f"its reader ended with {run.returncode}")
    with np.load(io.BytesIO(run.stdout)) as found:
        return found["points"], found["corners"]


def _check_xml(path: Path, where: str) -> None:
    """Raise InputError unless a file is well-formed XML without DTD (assimp never ends on what is cut off)."""

    def doctype(*_: object) -> NoReturn:
        raise InputError("forbidden XML (DTDForbidden)", where=where, expected="XML without DTD or entities")

    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = doctype
    try:
        parser.Parse(path.read_bytes(), True)
    except (expat.ExpatError, ValueError, LookupError) as error:
        raise InputError(f"not well-formed XML ({error})", where=where, expected="a COLLADA mesh") from None
