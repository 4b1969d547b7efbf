"""Capsules around points: as small as a search finds, and always around all of them."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Any

import coal
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Added to each radius for what rounding may take, m.
_ROUNDING = 1e-7
# Directions looked at: on the half sphere at first, and around the best one in each round after.
_DIRECTIONS = 32
_NEAR = 8
_ROUNDS = 4
# One more capsule has to save this share of the volume.
_SAVED = 0.15
_FEW = 800
MOST = 3


@dataclass(frozen=True)
class Capsule:
    """All points within ``radius`` (m) of the segment from ``a`` to ``b``, (3,) m each."""

    a: Array
    b: Array
    radius: float

    @property
    def volume(self) -> float:
        """m^3."""
        length = float(np.linalg.norm(self.b - self.a))
        return math.pi * self.radius**2 * (length + self.radius * 4.0 / 3.0)

    def depth(self, points: Array) -> Array:
        """Return how far inside each of ``points`` (m, 3) lies, in m; below 0 outside."""
        along = self.b - self.a
        square = float(along @ along)
        t = np.clip((points - self.a) @ along / square, 0.0, 1.0) if square > 0 else np.zeros(len(points))
        depth: Array = self.radius - np.linalg.norm(points - self.a - t[:, None] * along, axis=1)
        return depth


def _half_sphere(n: int) -> Array:
    """Return ``n`` directions spread over the half sphere z >= 0 (a golden spiral), (n, 3)."""
    k = np.arange(n) + 0.5
    z, turn = 1.0 - k / n, math.pi * (1.0 + math.sqrt(5.0)) * k
    flat = np.sqrt(1.0 - z * z)
    return np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=1)


def _frames(axes: Array) -> Array:
    """Return rotations (n, 3, 3) whose rows are two directions across each axis, and the axis."""
    least = np.eye(3)[np.argmin(np.abs(axes), axis=1)]
    x = np.cross(axes, least)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    return np.stack([x, np.cross(axes, x), axes], axis=1)


def _around(points: Array, axes: Array) -> tuple[Array, Array, Array]:
    """Return for each axis (n, 3) volume (n,), segment ends (n, 2, 3) and radius (n,) of a capsule along it."""
    frames = _frames(axes)
    turned = np.einsum("nij,pj->nip", frames, points)  # (n, 3, points)
    across, along = turned[:, :2], turned[:, 2]
    # The smallest circle around the points across the axis, by steps towards the farthest (Badoiu and Clarkson 2003).
    centre = 0.5 * (across.max(axis=2) + across.min(axis=2))
    rows = np.arange(len(axes))
    for step in range(1, 25):
        away = across - centre[:, :, None]
        farthest = np.argmax(np.einsum("nip,nip->np", away, away), axis=1)
        centre = centre + (across[rows, :, farthest] - centre) / (step + 4)
    away = across - centre[:, :, None]
    distance = np.sqrt(np.einsum("nip,nip->np", away, away))
    best = np.full(len(axes), np.inf)
    ends, radii = np.zeros((len(axes), 2, 3)), np.zeros(len(axes))
    for wider in (1.0, 1.03, 1.08, 1.15, 1.3):
        radius = wider * distance.max(axis=1) + _ROUNDING
        # Each end ball has to take in the points beyond it: the segment ends where the last of them still fits.
        cap = np.sqrt(np.maximum(radius[:, None] ** 2 - distance**2, 0.0))
        low, high = np.min(along + cap, axis=1), np.max(along - cap, axis=1)
        middle = 0.5 * (low + high)
        low, high = np.where(low > high, middle, low), np.where(low > high, middle, high)
        volume = math.pi * radius**2 * (high - low + radius * 4.0 / 3.0)
        better = volume < best
        best = np.where(better, volume, best)
        radii = np.where(better, radius, radii)
        for k, end in enumerate((low, high)):
            place = np.concatenate([centre, end[:, None]], axis=1)
            ends[better, k] = np.einsum("nij,ni->nj", frames, place)[better]
    return best, ends, radii


def fit_one(points: Array, rounds: int = _ROUNDS) -> Capsule:
    """Return a small capsule around ``points`` (m, 3), in m, and around their convex hull with them."""
    centre = points.mean(axis=0)
    away = points - centre
    _, _, main = np.linalg.svd(away.T @ away)
    axes, spread = np.concatenate([main, np.eye(3), _half_sphere(_DIRECTIONS)]), 0.25
    best: tuple[float, Array, float] | None = None
    best_axis = main[0]
    for _ in range(1 + rounds):
        volume, ends, radius = _around(away, axes)
        k = int(np.argmin(volume))
        if best is None or volume[k] < best[0]:
            best, best_axis = (float(volume[k]), ends[k], float(radius[k])), axes[k]
        frame = _frames(best_axis[None])[0]
        angles = 2.0 * math.pi * np.arange(_NEAR) / _NEAR
        near = best_axis + spread * (np.cos(angles)[:, None] * frame[0] + np.sin(angles)[:, None] * frame[1])
        axes, spread = near / np.linalg.norm(near, axis=1, keepdims=True), 0.4 * spread
    assert best is not None
    a, b = best[1] + centre
    missing = _ROUNDING - float(Capsule(a, b, best[2]).depth(points).min())
    return Capsule(a, b, best[2] + max(0.0, missing))


def _cut(triangles: Array, normal: Array, at: float) -> tuple[Array, Array]:
    """Return the points (m, 3) of the parts of ``triangles`` (t, 3, 3) below and above a plane, cut edges in both."""
    height = triangles @ normal - at  # (t, 3)
    corners, heights = triangles.reshape(-1, 3), height.ravel()
    crossing = []
    for i, j in ((0, 1), (1, 2), (2, 0)):
        a, b, low, high = triangles[:, i], triangles[:, j], height[:, i], height[:, j]
        cross = low * high < 0
        share = low[cross] / (low[cross] - high[cross])
        crossing.append(a[cross] + share[:, None] * (b[cross] - a[cross]))
    both = np.concatenate(crossing)
    return np.concatenate([corners[heights <= 0], both]), np.concatenate([corners[heights >= 0], both])


def _part(triangles: Array, normal: Array, at: float, above: bool) -> Array:
    """Return triangles that cover the same part of a plane's side as ``triangles`` do."""
    sign = 1.0 if above else -1.0
    height = sign * (triangles @ normal - at)
    whole = triangles[(height >= 0).all(axis=1)]
    parts = [whole]
    mixed = (height.max(axis=1) > 0) & (height.min(axis=1) < 0)
    for corners, tall in zip(triangles[mixed], height[mixed], strict=True):
        kept = []
        for i in range(3):
            j = (i + 1) % 3
            if tall[i] >= 0:
                kept.append(corners[i])
            if tall[i] * tall[j] < 0:
                kept.append(corners[i] + tall[i] / (tall[i] - tall[j]) * (corners[j] - corners[i]))
        parts += [np.array([[kept[0], kept[k], kept[k + 1]]]) for k in range(1, len(kept) - 1)]
    return np.concatenate(parts)


def fit(triangles: Array, most: int = MOST) -> list[Capsule]:
    """Return up to ``most`` capsules that together cover ``triangles`` (t, 3, 3), in m.

    Where a second or third capsule saves a fair share of the volume, the triangles are cut by a plane across one of
    their main directions, and each part has its own.
    """
    parts = [(triangles, fit_one(_corners(triangles)))]
    while len(parts) < most:
        cuts = [(_best_cut(part, capsule), i) for i, (part, capsule) in enumerate(parts)]
        (saved, halves), i = max(cuts, key=lambda cut: cut[0][0])
        if saved < _SAVED * sum(capsule.volume for _, capsule in parts):
            break
        parts[i : i + 1] = [(half, fit_one(_corners(half))) for half in halves]
    return [capsule for _, capsule in parts]


def _corners(triangles: Array) -> Array:
    """Return the corners of triangles, those of their convex hull alone if there are many."""
    points = triangles.reshape(-1, 3)
    return hull_points(points) if len(points) > 60 else points


def hull_points(points: Array) -> Array:
    """Return the corners of the convex hull of ``points`` (m, 3), m >= 4; all of them where they lie in a plane."""
    hull = convex_hull(points)
    if hull is None:
        return points
    corners: Array = np.array(hull.points(), dtype=float).reshape(-1, 3)
    return corners


def convex_hull(points: Array) -> Any:
    """Return the convex hull of ``points`` (m, 3), m >= 4, as Coal has it; None where they lie in a plane."""
    cloud = coal.BVHModelOBB()
    cloud.beginModel(1, len(points))
    cloud.addVertices(points)
    cloud.endModel()
    try:
        cloud.buildConvexHull(True, "Qt")
    except (RuntimeError, ValueError):
        return None
    convex: Any = cloud.convex
    return convex


def _best_cut(triangles: Array, whole: Capsule) -> tuple[float, tuple[Array, Array]]:
    """Return the volume that the best of some cuts saves, and the two parts."""
    few = triangles[:: 1 + len(triangles) // _FEW]  # to choose by; the parts are of all
    points = few.reshape(-1, 3)
    away = points - points.mean(axis=0)
    _, _, main = np.linalg.svd(away.T @ away)
    best, chosen = math.inf, (main[0], 0.0)
    for normal, share in itertools.product(main[:2], (0.2, 0.4, 0.6, 0.8)):
        height = points @ normal
        at = float(height.min() + share * (height.max() - height.min()))
        sides = _cut(few, normal, at)
        if min(len(side) for side in sides) < 4:
            continue
        volume = sum(fit_one(_thin(side), 2).volume for side in sides)
        if volume < best:
            best, chosen = volume, (normal, at)
    if best == math.inf:
        return -math.inf, (triangles, triangles)
    return whole.volume - best, (_part(triangles, *chosen, False), _part(triangles, *chosen, True))


def _thin(points: Array) -> Array:
    """Return at most some hundred points that stand for the outline of ``points``."""
    directions = _half_sphere(40)
    height = points @ directions.T
    kept: Array = points[np.unique(np.concatenate([height.argmax(axis=0), height.argmin(axis=0)]))]
    return kept
