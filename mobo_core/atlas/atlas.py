"""An atlas: the front of every joint order, and what it comes from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from mobo_core.atlas.reading import Source
    from mobo_core.atlas.trials import Trials
    from mobo_core.design import Design, DesignSpace
    from mobo_core.evaluation.spec import EvaluationSpec
    from mobo_core.search.front import Aims
    from mobo_core.search.study import StudySettings

Floats = NDArray[np.float64]
Counts = NDArray[np.int64]

# Trials after which an order counts as searched, if its best arm reaches so large a share of the voxels.
SEARCHED, _OF_USE = 1000, 0.1


@dataclass(frozen=True)
class About:
    """What the arms of an atlas were asked, and by which studies. Plain values: reading them needs no library.

    Attributes:
        space: of the arms, as plain settings.
        spec: of what they were asked, likewise.
        objectives: of the fronts.
        n_voxels: of the spec; no arm's reach is higher.
        trials: evaluated in all.
        orders: joint orders that have an arm.
        hypervolume: of all arms.
        engine: that evaluated them; "" if that is not known.
        studies: name, sampler, seed and trials of each.
        versions: of mobo and libraries that recorded the first of them.
    """

    space: Mapping[str, object]
    spec: Mapping[str, object]
    objectives: tuple[str, ...]
    n_voxels: int
    trials: int
    orders: int
    hypervolume: float
    engine: str = ""
    studies: Sequence[Mapping[str, object]] = ()
    versions: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, repr=False)
class Atlas:
    """One row an arm that no other of its joint order dominates; orders by falling best reach, arms by falling reach.

    Attributes:
        about: what it comes from.
        joints: of each arm, as built.
        twin: the exact mirror twin of its order among the atlas's orders, or "".
        lengths: (rows, joints) m.
        base: (rows, 2) m and rad: height and tilt of the base.
        values: reach, torque and further objectives, (rows,) each.
        trials_of_order: trials that its order got.
        expected_gain: hypervolume, that as many trials again may be expected to add to its order's own.
        study: that it is of.
        trial: of that study.
    """

    about: About
    joints: tuple[str, ...]
    twin: tuple[str, ...]
    lengths: Floats
    base: Floats
    values: Mapping[str, Floats]
    trials_of_order: Counts
    expected_gain: Floats
    study: tuple[str, ...]
    trial: Counts

    def __len__(self) -> int:
        """Return the number of arms."""
        return len(self.joints)

    def __repr__(self) -> str:
        """Return a line: orders, arms, trials."""
        return f"<Atlas: {len(self)} arms on the fronts of {self.about.orders} orders, {self.about.trials} trials>"

    @property
    def orders(self) -> dict[str, NDArray[np.int64]]:
        """Joint order -> its rows."""
        found: dict[str, list[int]] = {}
        for row, joints in enumerate(self.joints):
            found.setdefault(joints, []).append(row)
        return {joints: np.array(rows) for joints, rows in found.items()}

    @property
    def wanted(self) -> list[tuple[float, ...]]:
        """The objectives' values of each arm, in their order."""
        columns = [self.values[name].tolist() for name in self.about.objectives]
        return list(zip(*columns, strict=True))

    @property
    def spec(self) -> EvaluationSpec:
        """What the arms were asked."""
        from mobo_core.evaluation.spec import EvaluationSpec

        return EvaluationSpec.of(dict(self.about.spec), where="spec of the atlas")

    @property
    def space(self) -> DesignSpace:
        """The space that they are of."""
        from mobo_core.design import DesignSpace

        return DesignSpace.of(dict(self.about.space), where="space of the atlas")

    @property
    def aims(self) -> Aims:
        """What is wanted of the objectives."""
        from mobo_core.search.front import aims_of

        return aims_of(self.about.objectives, self.spec)

    def design(self, row: int) -> Design:
        """Return an arm."""
        from mobo_core.design import Design

        height, tilt = self.base[row].tolist()
        return Design(self.joints[row], tuple(self.lengths[row].tolist()), height, tilt)


def partial(atlas: Atlas) -> str:
    """Return in a line that orders got few trials; "" if all whose best reach is a tenth of the voxels got SEARCHED."""
    reach = atlas.values["reach"]
    counts = [
        int(atlas.trials_of_order[rows[0]])
        for rows in atlas.orders.values()
        if reach[rows].max() >= _OF_USE * atlas.about.n_voxels
    ]
    few = sum(count < SEARCHED for count in counts)
    if not few:
        return ""
    return f"partial: {few} of {len(counts)} orders that reach a tenth of the voxels got fewer than {SEARCHED:,} trials"


def atlas_of(trials: Trials, sources: Sequence[Source]) -> Atlas:
    """Return the atlas of trials, and of the studies that they are of."""
    settings = sources[0].settings
    first = sources[0].record
    counts = np.bincount(trials.study, minlength=len(sources)).tolist()
    studies = [
        {"name": one.name, "sampler": one.settings.sampler, "seed": one.settings.seed, "trials": count}
        for one, count in zip(sources, counts, strict=True)
    ]
    engine = next((one.engine for one in sources if one.engine), "")
    return fronts_of(trials, settings, studies, engine, _versions(first))


def fronts_of(
    trials: Trials,
    settings: StudySettings,
    studies: Sequence[Mapping[str, object]],
    engine: str = "",
    versions: Mapping[str, str] | None = None,
) -> Atlas:
    """Return the atlas of trials, all asked as in ``settings``; ``studies`` by the numbers that ``trials`` has."""
    from mobo_core.atlas.growth import expected_gain, volumes_added
    from mobo_core.search.front import hypervolume, pareto_front
    from mobo_core.search.mirror import exact_twins

    aims = settings.aims
    wanted = trials.values[:, [trials.names.index(name) for name in settings.objectives]]
    complete = np.flatnonzero(np.isfinite(wanted).all(axis=1))
    by_order = np.argsort(trials.order, kind="stable")
    ends = np.searchsorted(trials.order[by_order], np.arange(len(trials.orders) + 1))
    reach = trials.values[:, 0]
    rows: list[tuple[float, str, list[int], int, float]] = []
    for k, joints in enumerate(trials.orders):
        own = by_order[ends[k] : ends[k + 1]]
        good = own[np.isin(own, complete, assume_unique=True)]
        if not len(good):
            continue
        front = [int(good[i]) for i in pareto_front(list(map(tuple, wanted[good].tolist())), aims)]
        front.sort(key=lambda row: (-reach[row], trials.values[row, 1], row))
        gain = expected_gain(volumes_added(wanted[own], aims))
        rows.append((-float(reach[good].max()), joints, front, len(own), gain))
    rows.sort()
    twins = exact_twins([joints for _, joints, *_ in rows], settings.space, settings.spec)
    chosen = np.array([row for _, _, front, _, _ in rows for row in front], np.int64)
    names = [str(one["name"]) for one in studies]
    about = About(
        space=_plain(settings.space.to_dict()),
        spec=_plain(settings.spec.to_dict()),
        objectives=settings.objectives,
        n_voxels=settings.spec.n_voxels,
        trials=len(trials),
        orders=len(rows),
        hypervolume=hypervolume(list(map(tuple, wanted[chosen].tolist())), aims),
        engine=engine,
        studies=tuple(studies),
        versions=versions or {},
    )
    return Atlas(
        about=about,
        joints=tuple(joints for _, joints, front, _, _ in rows for _ in front),
        twin=tuple(twins.get(joints, "") for _, joints, front, _, _ in rows for _ in front),
        lengths=trials.lengths[chosen],
        base=trials.base[chosen],
        values={name: trials.values[chosen, k] for k, name in enumerate(trials.names)},
        trials_of_order=np.array([count for _, _, front, count, _ in rows for _ in front], np.int64),
        expected_gain=np.array([gain for _, _, front, _, gain in rows for _ in front]),
        study=tuple(names[study] for study in trials.study[chosen].tolist()),
        trial=trials.number[chosen],
    )


def _plain(values: object) -> dict[str, object]:
    assert isinstance(values, dict)
    return values


def _versions(record: Mapping[str, str]) -> dict[str, str]:
    import json

    try:
        found = json.loads(record.get("versions", "{}"))
    except (ValueError, RecursionError):
        return {}
    return {str(name): str(value) for name, value in found.items()} if isinstance(found, dict) else {}
