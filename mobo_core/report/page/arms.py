"""What the page holds of each arm: its design and numbers, its voxels while there is room, and its URDF."""

from __future__ import annotations

import json
import math
import zlib
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from mobo_core.bag.record import StudyRecord
from mobo_core.design import Design
from mobo_core.design.joints import JOINTS
from mobo_core.design.numbers import middle
from mobo_core.design.prepared import PreparedXacro
from mobo_core.errors import InputError, MoboError
from mobo_core.messages import Evaluation
from mobo_core.report.page.blobs import Blob, pack
from mobo_core.report.row import Row
from mobo_core.report.uncertainty import standard_errors

Arrays = dict[str, NDArray[np.generic]]

# Voxels of arms, best first, are held up to so many bytes of text; a group of arms is unpacked at a time.
MOST_VOXEL_TEXT = 8_000_000
_GROUP = 400
# N m, a step of the torques in voxel maps.
TORQUE_STEP = 0.01


def columns(study: StudyRecord, rows: Sequence[Row]) -> tuple[Arrays, list[str], list[str]]:
    """Return the columns of the page's arms; joint orders; and who evaluated. Columns name these by number."""
    orders = sorted({row.joints for row in rows} | {row.sampled_joints for row in rows})
    order_of = {order: i for i, order in enumerate(orders)}
    who = sorted({row.evaluator for row in rows})
    who_of = {name: i for i, name in enumerate(who)}
    n = study.settings.space.n_joints
    lengths = np.full((n, len(rows)), math.nan)
    for i, row in enumerate(rows):
        lengths[: len(row.lengths), i] = row.lengths[:n]
    reach_se, torque_se = standard_errors(study, rows)
    arrays: Arrays = {
        "trial": np.array([row.trial for row in rows], np.uint32),
        "order": np.array([order_of[row.joints] for row in rows], np.uint32),
        "sampled": np.array([order_of[row.sampled_joints] for row in rows], np.uint32),
        "reach": np.array([row.reach for row in rows], float),
        "torque": np.array([row.torque for row in rows], float),
        "reach_se": reach_se.astype(np.float32),
        "torque_se": torque_se.astype(np.float32),
        "seconds": np.array([row.seconds for row in rows], np.float32),
        "evaluator": np.array([who_of[row.evaluator] for row in rows], np.uint16),
        "front": np.array([row.on_front for row in rows], np.uint8),
        "useful": np.array([row.above_floor for row in rows], np.uint8),
        "crc": np.array([_crc(study, row) for row in rows], np.uint32),
        "lengths": lengths,
    }
    for k, (name, _) in enumerate(rows[0].extra if rows else ()):
        arrays[f"extra:{name}"] = np.array([row.extra[k][1] for row in rows], float)
    for name in ("base_height", "base_tilt"):
        if isinstance(getattr(study.settings.space, name), tuple):
            arrays[name] = np.array([_params(study, row).get(name, math.nan) for row in rows], float)
    for name in study.settings.space.searched_centers:
        center = np.array([_params(study, row).get(name, math.nan) for row in rows], float)
        arrays[f"joint_center_{name.removeprefix('c')}"] = center
    return arrays, orders, who


def _params(study: StudyRecord, row: Row) -> dict[str, float]:
    candidate = study.candidate_of(row.trial)
    try:
        params = json.loads(candidate.params_json) if candidate is not None else {}
    except (ValueError, RecursionError):
        return {}
    return {name: value for name, value in params.items() if isinstance(value, float)} if type(params) is dict else {}


def _crc(study: StudyRecord, row: Row) -> int:
    candidate = study.candidate_of(row.trial)
    return zlib.crc32(candidate.urdf.encode("utf-8", "surrogatepass")) if candidate is not None else 0


def voxel_groups(study: StudyRecord, rows: Sequence[Row], order: Iterable[int]) -> tuple[list[Blob], list[list[int]]]:
    """Return the voxels of arms in groups, and the arms (by their place in ``rows``) of each group.

    Args:
        study: as read from its bag.
        rows: the page's arms.
        order: which come first, should there be no room for all.
    """
    blobs, members, room = [], [], MOST_VOXEL_TEXT
    places = iter(order)
    while chunk := list(islice(places, _GROUP)):
        found = [(i, answer) for i in chunk if (answer := study.accepted(rows[i].trial)) is not None]
        if not found:
            continue
        blob = pack(_voxels([answer for _, answer in found], study.settings.spec.poses_per_voxel))
        room -= len(blob.text)
        if room < 0:
            break
        blobs.append(blob)
        members.append([i for i, _ in found])
    return blobs, members


def _voxels(answers: Sequence[Evaluation], poses: int) -> Arrays:
    counts = np.uint8 if poses < 256 else np.uint16
    torque = np.stack([answer.voxel_torque for answer in answers]) / TORQUE_STEP
    steps = np.minimum(np.rint(torque), 65535).astype(np.uint16)
    return {
        "reach": np.rint(np.stack([answer.voxel_reach for answer in answers]) * poses).astype(counts),
        # Bytes of one kind side by side compress better.
        "torque_low": (steps & 255).astype(np.uint8),
        "torque_high": (steps >> 8).astype(np.uint8),
        "out_of_range": np.stack([answer.voxel_out_of_range for answer in answers]).astype(counts),
        "in_collision": np.stack([answer.voxel_in_collision for answer in answers]).astype(counts),
    }


def urdf_source(study: StudyRecord, rows: Sequence[Row], held: Sequence[Row]) -> dict[str, object]:
    """Return from what the page makes URDFs.

    ``parts``: see :meth:`PreparedXacro.template`; None if xacro has to do it. ``verbatim``: by place in ``rows`` those
    of ``held`` which the macros at hand make otherwise than recorded. The page checks all by the sums in its columns.
    """
    prepared = PreparedXacro(study.settings.space)
    try:
        parts = prepared.template(_telling(study, rows))
    except MoboError:
        parts = None
    verbatim: dict[int, str] = {}
    place = {row.trial: i for i, row in enumerate(rows)}
    for row in held:
        candidate, design = study.candidate_of(row.trial), _design(study, row)
        if candidate is None:
            continue
        try:
            same = parts is not None and design is not None and prepared.to_urdf(design) == candidate.urdf
        except MoboError:
            same = False
        if not same:
            verbatim[place[row.trial]] = candidate.urdf
    return {"parts": parts, "verbatim": verbatim}


def _design(study: StudyRecord, row: Row) -> Design | None:
    if len(row.lengths) != len(row.sampled_joints) or any(letter not in JOINTS for letter in row.sampled_joints):
        return None
    params, space = _params(study, row), study.settings.space
    height, tilt = (params.get(name, middle(getattr(space, name))) for name in ("base_height", "base_tilt"))
    centers = [params.get(f"c{i}", middle(center)) for i, center in enumerate(space.centers, start=1)]
    try:
        return Design(row.sampled_joints, row.lengths, height, tilt, tuple(centers) if space.searched_centers else ())
    except InputError:
        return None


def _telling(study: StudyRecord, rows: Sequence[Row]) -> Iterator[Design]:
    """Yield designs that lead through every way which the arms of ``rows`` lead through, or nearly."""
    seen: set[tuple[int, str, bool, bool]] = set()
    for row in rows:
        zero = [length == 0.0 for length in row.lengths]
        new = {(i, letter, zero[i], i > 0 and zero[i - 1]) for i, letter in enumerate(row.joints[: len(zero)])} - seen
        design = _design(study, row) if new else None
        if design is not None:
            seen |= new
            yield design
