"""How far a study is from an atlas, and both from what no arm can do better than."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mobo_core.atlas.atlas import Atlas
from mobo_core.atlas.file import packaged, read_atlas
from mobo_core.atlas.reading import question
from mobo_core.design import DesignSpace
from mobo_core.design.numbers import ends
from mobo_core.errors import InputError
from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.search.front import hypervolume
from mobo_core.search.study import StudySettings, first_difference


@dataclass(frozen=True)
class OrderRegret:
    """How far a study's arms of one order are from the atlas's.

    Attributes:
        joints: the order.
        trials: that the study gave it; 0: it has no arm of it.
        reach: best of the study.
        of_reach: best of the study and the atlas.
        hypervolume: of the study's own arms of the order.
        of_hypervolume: of the study's and the atlas's together.
    """

    joints: str
    trials: int
    reach: float
    of_reach: float
    hypervolume: float
    of_hypervolume: float

    @property
    def short(self) -> float:
        """Voxels that the study's best arm of the order lacks."""
        return self.of_reach - self.reach


@dataclass(frozen=True)
class Regret:
    """How far a study is from an atlas.

    Attributes:
        hypervolume: of the study.
        of_hypervolume: of the study and the atlas together.
        orders: each, the one farthest short first.
        trials: of the atlas.
    """

    hypervolume: float
    of_hypervolume: float
    orders: tuple[OrderRegret, ...]
    trials: int

    def __str__(self) -> str:
        """Return a line for people, such as ``0.5650 of 0.5760; RPPYPY 11.0 voxels short``."""
        text = f"{self.hypervolume:.4f} of {self.of_hypervolume:.4f}"
        worst = [one for one in self.orders if one.short >= 0.05][:1]
        return text + "".join(f"; {one.joints} {one.short:.1f} voxels short" for one in worst)


def regret(study: Atlas, atlas: Atlas) -> Regret:
    """Return how far a study, as its own atlas, is from another that was asked the same (see :func:`unfit`)."""
    aims = study.aims
    own, theirs, rows_of, rows_there = study.wanted, atlas.wanted, study.orders, atlas.orders
    found = []
    for joints in dict.fromkeys([*rows_of, *rows_there]):
        here, there = rows_of.get(joints, _NONE), rows_there.get(joints, _NONE)
        mine = [own[row] for row in here]
        reach = float(study.values["reach"][here].max(initial=0.0))
        found.append(
            OrderRegret(
                joints=joints,
                trials=int(study.trials_of_order[here[0]]) if len(here) else 0,
                reach=reach,
                of_reach=float(atlas.values["reach"][there].max(initial=reach)),
                hypervolume=hypervolume(mine, aims),
                of_hypervolume=hypervolume([*mine, *(theirs[row] for row in there)], aims),
            )
        )
    found.sort(key=lambda one: (-one.short, -one.of_reach, one.joints))
    return Regret(hypervolume(own, aims), hypervolume([*own, *theirs], aims), tuple(found), atlas.about.trials)


_NONE = np.empty(0, np.int64)


def unfit(settings: StudySettings, engine: str, atlas: Atlas) -> str:
    """Return why a study's values cannot be compared with an atlas's: the first difference; "" if they can."""
    about = atlas.about
    kept = {name: value for name, value in about.space.items() if name != "lengths"}
    there: dict[str, object] = {"space": kept, "spec": dict(about.spec), "objectives": list(about.objectives)}
    difference = first_difference(question(settings), there)
    if difference is None and engine and about.engine and engine != about.engine:
        difference = "engine", engine, about.engine
    if difference is None:
        return ""
    name, own, other = difference
    return f"{name} is {own!r:.60}, in the atlas {other!r:.60}"


def fitting_atlas(settings: StudySettings, engine: str = "", file: Path | None = None) -> tuple[Atlas | None, str]:
    """Return the atlas to compare a study with, that of ``file`` or the one mobo brings, or None and why.

    Raises:
        InputError: ``file`` is no atlas.
    """
    path = packaged(settings.space.n_joints) if file is None else file
    if path is None:
        return None, f"mobo brings no atlas of {settings.space.n_joints} joints"
    try:
        atlas = read_atlas(path)
    except InputError as error:
        if file is not None:
            raise
        return None, str(error)
    why = unfit(settings, engine, atlas)
    return (None, f"not compared with an atlas: {why}") if why else (atlas, "")


def voxels_within(space: DesignSpace, spec: EvaluationSpec) -> int:
    """Return how many voxels' centres lie within the arm's length of its first joint: no arm's reach is higher.

    A longest arm, at the best height that the base may have; what the tolerance of positions allows counts.
    """
    low, high = ends(space.base_height)
    centres = spec.voxel_centres()
    height = np.clip(centres[:, 2], low, high)
    squares = centres[:, 0] ** 2 + centres[:, 1] ** 2 + (centres[:, 2] - height) ** 2
    farthest = space.longest_reach + spec.tool_length + spec.position_tolerance
    return int((squares <= farthest**2).sum())
