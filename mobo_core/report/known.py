"""Where real arms stand in a study: the idealised twins of the catalogue's, evaluated as the study's arms were."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mobo_core.arms.twins import Twin, twins_in
from mobo_core.bag.record import StudyRecord
from mobo_core.design import DesignSpace
from mobo_core.design.prepared import PreparedXacro
from mobo_core.errors import MoboError
from mobo_core.evaluation.evaluate import evaluate
from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.report.columns import Columns
from mobo_core.report.once import once
from mobo_core.report.own_atlas import engine_of
from mobo_core.report.table import StudyTable

# Poses tried in all, some 6 s on one core; arms that the paper names come first, then those whose masses are known.
_MOST_POSES = 400_000


@dataclass(frozen=True)
class KnownArm:
    """Real arms with the same idealised twin, and what that is worth.

    Attributes:
        names: of the arms.
        joints: the twin's order.
        lengths: m, the twin's.
        reach: sum over the voxels of the share of poses reached.
        torque: N m, summed over the voxels.
        extra: name and value of the study's further objectives.
        estimated: whether no source says the masses of any of the arms; the twin has those of the space in any case.
    """

    names: tuple[str, ...]
    joints: str
    lengths: tuple[float, ...]
    reach: float
    torque: float
    extra: tuple[tuple[str, float], ...] = ()
    estimated: bool = False


def known_arms_in(space: DesignSpace, spec: EvaluationSpec, objectives: Sequence[str] = ()) -> tuple[KnownArm, ...]:
    """Return the catalogue's arms whose twins lie in a space, evaluated; no more than 400,000 poses allow.

    Args:
        space: of the arms that they are held against.
        spec: what is asked.
        objectives: further ones wanted.
    """
    twins = sorted(twins_in(space), key=_first)
    most = _MOST_POSES // (spec.n_voxels * spec.poses_per_voxel)
    xacro = PreparedXacro(space)
    return tuple(_evaluated(twin, xacro.to_urdf(twin.design), spec, objectives) for twin in twins[:most])


@once
def known_arms_of(study: StudyRecord, table: StudyTable) -> tuple[KnownArm, ...]:
    """Return :func:`known_arms_in` of a study; none where its values were invented, or are of irteus."""
    settings = study.settings
    if engine_of(study) == "simulated" or settings.spec.ik_mode == "irteus" or not table.complete:
        return ()
    try:
        return known_arms_in(settings.space, settings.spec, tuple(table.further))
    except MoboError:  # such as an objective of a distribution that is not here
        return ()


def known_columns(arms: Sequence[KnownArm]) -> Columns:
    """Return a row an arm of the pictures, as ``known_arms.csv`` has them."""
    columns: Columns = {
        "arms": ["; ".join(arm.names) for arm in arms], "joints": [arm.joints for arm in arms],
        "reach": [arm.reach for arm in arms], "torque": [arm.torque for arm in arms],
    }  # fmt: skip
    for i in range(max((len(arm.joints) for arm in arms), default=0)):
        columns[f"length_{i + 1}"] = [arm.lengths[i] for arm in arms]
    for name in [name for name, _ in arms[0].extra] if arms else ():
        columns[name] = [dict(arm.extra)[name] for arm in arms]
    return columns | {"masses": ["estimated" if arm.estimated else "source" for arm in arms]}


def _first(twin: Twin) -> tuple[bool, bool]:
    return not any(arm.paper for arm in twin.arms), _estimated(twin)


def _estimated(twin: Twin) -> bool:
    return all("masses" in arm.estimated for arm in twin.arms)


def _evaluated(twin: Twin, urdf: str, spec: EvaluationSpec, objectives: Sequence[str]) -> KnownArm:
    design = twin.design
    found = evaluate(urdf, spec, objectives=objectives)
    names = tuple(arm.name for arm in sorted(twin.arms, key=lambda arm: not arm.paper))
    return KnownArm(
        names, design.joints, design.lengths, found.reach, found.torque, tuple(found.extra.items()), _estimated(twin)
    )
