"""The collision shapes of a link as capsules, and by how much those are larger."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import coal
import numpy as np

from mobo_core.arms.capsules import Array, Capsule, fit
from mobo_core.arms.meshes import model_of, triangles_of, volume_of
from mobo_core.arms.packages import Packages
from mobo_core.arms.rigid import Placement
from mobo_core.arms.robot import Robot, Solid

_ROUND = ("sphere", "cylinder", "capsule")
_GRID = 24  # cells a side, by which the volume of several capsules together is counted
_SAMPLES = 150  # points of a capsule at which its distance from the shape is taken


@dataclass(frozen=True)
class Shape:
    """A capsule as it is written: a segment of ``length`` m along z of ``placed``, in the frame of its link."""

    placed: Placement
    length: float
    radius: float


@dataclass(frozen=True)
class Fitted:
    """The capsules of a link.

    Attributes:
        shapes: the capsules.
        fitted: how many of them were fitted, to meshes and boxes.
        volume: m^3, of all capsules together.
        solid_volume: m^3, of the shapes that they stand for, meshes that are not closed as convex hulls.
        gap: m, farthest that a fitted capsule stands off the mesh or box in it; 0 if none was fitted.
    """

    shapes: tuple[Shape, ...]
    fitted: int
    volume: float
    solid_volume: float
    gap: float


@dataclass(frozen=True)
class Capsules:
    """The capsules of an arm.

    Attributes:
        count: of all.
        fitted: to meshes and boxes.
        volume_ratio: volume of all capsules over that of all shapes, meshes that are not closed as convex hulls; None
            if those have none.
        largest_gap: m, farthest that a fitted capsule stands off its mesh or box.
        at: link where it does.
        links: link -> the same of it.
    """

    count: int
    fitted: int
    volume_ratio: float | None
    largest_gap: float
    at: str
    links: Mapping[str, Capsules]

    @classmethod
    def of(cls, links: Mapping[str, Fitted]) -> Capsules:
        """Sum up what links have."""
        volume = math.fsum(each.volume for each in links.values())
        solid = math.fsum(each.solid_volume for each in links.values())
        at = max(links, key=lambda link: links[link].gap, default="")
        return cls(
            sum(len(each.shapes) for each in links.values()), sum(each.fitted for each in links.values()),
            volume / solid if solid > 0 else None, links[at].gap if at else 0.0, at,
            {link: cls.of({link: each}) for link, each in links.items()} if len(links) > 1 else {},
        )  # fmt: skip

    def to_dict(self) -> dict[str, object]:
        """Return all as plain values."""
        own: dict[str, object] = {"capsules": self.count, "fitted": self.fitted, "volume_ratio": self.volume_ratio}
        own["largest_gap"], own["at"] = self.largest_gap, self.at
        return own | ({"links": {link: each.to_dict() for link, each in self.links.items()}} if self.links else {})


def fit_links(
    robot: Robot, links: list[str], packages: Packages, progress: Callable[[int, int], None] | None = None
) -> dict[str, Fitted]:
    """Return the capsules of those ``links`` that have collision shapes.

    Spheres and capsules are taken as they are, cylinders as capsules with their half balls beyond the ends. All
    boxes and meshes of a link together are covered by one to three capsules.

    Raises:
        InputError: a mesh is not found or cannot be read.
    """
    found = {}
    for i, link in enumerate(links):
        solids = [solid for solid in robot.solids if solid.link == link]
        if solids:
            found[link] = _fit_link(solids, packages)
        if progress:
            progress(i + 1, len(links))
    return found


def _fit_link(solids: list[Solid], packages: Packages) -> Fitted:
    shapes = [Shape(solid.placed, solid.size[1], solid.size[0]) for solid in solids if solid.kind in _ROUND]
    volume = math.fsum(_volume(shape.radius, shape.length) for shape in shapes)
    solid_volume = math.fsum(_solid_volume(solid) for solid in solids if solid.kind in _ROUND)
    others = [triangles_of(solid, packages) for solid in solids if solid.kind not in _ROUND]
    if not others:
        return Fitted(tuple(shapes), 0, volume, solid_volume, 0.0)
    triangles = np.concatenate(others)
    capsules = fit(triangles)
    shapes += [_shape(capsule) for capsule in capsules]
    volume += _together(capsules)
    solid_volume += math.fsum(volume_of(each) for each in others)
    return Fitted(tuple(shapes), len(capsules), volume, solid_volume, _gap(capsules, triangles))


def _shape(capsule: Capsule) -> Shape:
    along = capsule.b - capsule.a
    length = float(np.linalg.norm(along))
    x, y, z = along / length if length > 0 else (0.0, 0.0, 1.0)
    rpy = (0.0, math.atan2(math.hypot(x, y), z), math.atan2(y, x))
    return Shape(Placement(tuple((0.5 * (capsule.a + capsule.b)).tolist()), rpy), length, capsule.radius)


def _volume(radius: float, length: float) -> float:
    return math.pi * radius**2 * (length + radius * 4.0 / 3.0)


def _solid_volume(solid: Solid) -> float:
    radius, length = solid.size
    return math.pi * radius**2 * length if solid.kind == "cylinder" else _volume(radius, length)


def _together(capsules: list[Capsule]) -> float:
    """Return the volume of capsules that may overlap."""
    if len(capsules) == 1:
        return capsules[0].volume
    ends = np.array([end for capsule in capsules for end in (capsule.a, capsule.b)])
    most = max(capsule.radius for capsule in capsules)
    low, high = ends.min(axis=0) - most, ends.max(axis=0) + most
    places = [low[k] + (np.arange(_GRID) + 0.5) / _GRID * (high[k] - low[k]) for k in range(3)]
    points = np.stack(np.meshgrid(*places, indexing="ij"), axis=-1).reshape(-1, 3)
    inside = np.any([capsule.depth(points) >= 0 for capsule in capsules], axis=0)
    return float(inside.mean() * np.prod(high - low))


def _gap(capsules: list[Capsule], triangles: Array) -> float:
    """Return how far the surface of ``capsules`` gets from the triangles that they cover."""
    model, request = model_of(triangles), coal.DistanceRequest()
    point, still = coal.Sphere(1e-9), coal.Transform3s()
    k = np.arange(_SAMPLES) + 0.5
    z, turn = 1.0 - 2.0 * k / _SAMPLES, math.pi * (1.0 + math.sqrt(5.0)) * k
    flat = np.sqrt(1.0 - z * z)
    ball = np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=1)
    farthest = 0.0
    for capsule in capsules:
        along = capsule.b - capsule.a
        across = ball - np.outer(ball @ along, along) / max(float(along @ along), 1e-300)
        across = across / np.linalg.norm(across, axis=1, keepdims=True)
        share = np.modf(k * 0.618)[0]
        surface = np.concatenate(
            [
                np.where((ball @ along)[:, None] > 0, capsule.b, capsule.a) + capsule.radius * ball,
                capsule.a + share[:, None] * along + capsule.radius * across,
            ]
        )
        covered = np.zeros(len(surface), bool)
        for other in capsules:
            covered |= (other.depth(surface) > 0) if other is not capsule else False
        for place in surface[~covered]:
            result = coal.DistanceResult()
            at = coal.Transform3s(np.eye(3), place)
            farthest = max(farthest, coal.distance(point, at, model, still, request, result))
    return float(farthest)
