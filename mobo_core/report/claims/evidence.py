"""What there is to judge claims by: arms of one number of joints, of a study or of an atlas."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mobo_core.bag.record import StudyRecord
from mobo_core.design import DesignSpace
from mobo_core.design.joints import count_built
from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.report.prefixes import PREFIX_LENGTH
from mobo_core.report.row import Row
from mobo_core.report.table import REACH_FLOOR_SHARE, StudyTable
from mobo_core.search.front import aims_of, pareto_front
from mobo_core.search.mirror import swapped

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Flags = NDArray[np.bool_]
# (voxel reach, voxel torque, its deviation), each (voxels,).
Maps = tuple[Array, Array, Array]

# Voxels of 75 with 30 poses each: what two arms have to differ by in reach for it to be a finding (the poses' noise).
STEP = 2.0
# Trials of a prefix below which it was hardly searched, whatever the study's length.
FEWEST_TRIALS = 100
_MOST_TORQUE = 1e9  # N m
# Of its best reach: orders of a prefix that reach so much have to be known, in an atlas.
NEARLY = 0.8


@dataclass(frozen=True)
class Arm:
    """One arm and what it is worth.

    Attributes:
        joints: as built.
        lengths: m.
        reach: voxels.
        torque: N m.
        trial: of the study; of an atlas the row.
        trials: of an atlas: those its order got.
        known: of an atlas: whether its order was searched enough.
    """

    joints: str
    lengths: tuple[float, ...]
    reach: float
    torque: float
    trial: int = -1
    trials: int = 1
    known: bool = True


@dataclass(frozen=True)
class Members:
    """The arms of one prefix.

    Attributes:
        prefix: the first four joints.
        arms: by number of the trial.
        trials: how many it got.
        gain: voxels; by how much the latter half of its trials raised its best reach, which bounds roughly what as
            many more would bring.
        known: whether its best says something of the prefix rather than of the sampler.
    """

    prefix: str
    arms: tuple[Arm, ...]
    trials: int
    gain: float
    known: bool

    @property
    def best(self) -> Arm:
        """The arm of the highest reach; of equals the one of least torque."""
        return min(self.arms, key=by_reach)

    def top(self, share: float = 0.05, fewest: int = 5, most: int = 60) -> list[Arm]:
        """Return the arms that reach most."""
        count = min(max(math.ceil(share * len(self.arms)), fewest), most)
        return sorted(self.arms, key=by_reach)[:count]


def by_reach(arm: Arm) -> tuple[float, float, int]:
    """Return what arms are sorted by to have the highest reach first."""
    return (-arm.reach, arm.torque, arm.trial)


class Evidence:
    """Arms of one number of joints.

    A prefix is known if it got half an equal share of the trials or more (an equal share is all trials over the
    number of prefixes that the space can build), 100 at least, and the latter half of them raised its best reach by
    no more than two voxels of 75. In an atlas, where orders are searched by themselves, it is known if those of its
    orders are that reach nearly as far as its best one. Of other prefixes no check says that they are worse.

    Attributes:
        n_joints: of the arms.
        space, spec: that they were evaluated by.
        arms: all.
        fair: whether they are an atlas's, every order searched by itself.
        step: voxels that two arms have to differ by.
        memo: what claims evaluated and share.
    """

    def __init__(
        self,
        arms: Sequence[Arm],
        space: DesignSpace,
        spec: EvaluationSpec,
        *,
        fair: bool = False,
        maps: Callable[[Arm], Maps | None] = lambda arm: None,
        urdf: Callable[[Arm], tuple[str, str] | None] = lambda arm: None,
    ) -> None:
        self.n_joints, self.space, self.spec, self.fair = space.n_joints, space, spec, fair
        self.arms = tuple(arms)
        self.step = STEP * math.sqrt(spec.n_voxels / 75 * 30 / spec.poses_per_voxel)
        self._maps, self._urdf = maps, urdf
        self.memo: dict[str, object] = {}
        self._kept: dict[tuple[int, str, tuple[float, ...]], Maps | None] = {}
        by_prefix: dict[str, list[Arm]] = {}
        for arm in self.arms:
            by_prefix.setdefault(arm.joints[:PREFIX_LENGTH], []).append(arm)
        n_prefixes = count_built(space.places[:PREFIX_LENGTH])
        self._least = max(FEWEST_TRIALS, len(self.arms) / (2 * n_prefixes))
        self.prefixes = {prefix: self._members(prefix, of) for prefix, of in by_prefix.items() if prefix}

    def _members(self, prefix: str, arms: list[Arm]) -> Members:
        if self.fair:
            trials, gain = sum({arm.joints: arm.trials for arm in arms}.values()), 0.0
            least = NEARLY * max(arm.reach for arm in arms)
            known = all(arm.known for arm in arms if arm.reach >= least)
        else:
            trials, half = len(arms), len(arms) // 2
            gain = max(arm.reach for arm in arms) - max((arm.reach for arm in arms[:half]), default=0.0)
            known = trials >= self._least and gain <= self.step
        return Members(prefix, tuple(arms), trials, max(gain, 0.0), known)

    @property
    def best(self) -> Arm:
        """The arm of the highest reach of all."""
        return min(self.arms, key=by_reach)

    @property
    def front(self) -> list[Arm]:
        """The arms of the Pareto front of reach and torque, above the reach floor."""
        floor = REACH_FLOOR_SHARE * self.spec.n_voxels
        return [arm for arm in self.front_of(self.arms) if arm.reach >= floor]

    def front_of(self, arms: Sequence[Arm]) -> list[Arm]:
        """Return the Pareto front of some arms."""
        aims = aims_of(("reach", "torque"), self.spec)
        return [arms[i] for i in pareto_front([(arm.reach, arm.torque) for arm in arms], aims)]

    @property
    def searched(self) -> bool:
        """Whether enough prefixes are known for others to be compared with: three."""
        return sum(of.known for of in self.prefixes.values()) >= 3

    def unknown(self, prefixes: Sequence[str]) -> tuple[str, ...]:
        """Return those of the prefixes that were hardly searched, or not at all."""
        return tuple(p for p in prefixes if p not in self.prefixes or not self.prefixes[p].known)

    def twin(self, prefix: str) -> str:
        """Return the prefix with Roll and Pitch exchanged, which the paper counts as the same."""
        return swapped(prefix)

    def maps(self, arm: Arm) -> Maps | None:
        """Return the arm's voxels; None if there is no way to know them."""
        key = (arm.trial, arm.joints, arm.lengths)
        if key not in self._kept:
            self._kept[key] = self._maps(arm)
        return self._kept[key]

    def urdf(self, arm: Arm) -> tuple[str, str] | None:
        """Return the arm's description and tip; None if it cannot be made."""
        return self._urdf(arm)


def sound(row: Row, n_joints: int, n_voxels: int) -> bool:
    """Return whether a trial's arm and values can be: a bag may claim anything."""
    letters = len(row.joints) == n_joints and row.joints.isascii() and row.joints.isalpha() and row.joints.isupper()
    return letters and 0.0 <= row.reach <= n_voxels and 0.0 <= row.torque <= _MOST_TORQUE


def of_study(study: StudyRecord, table: StudyTable) -> Evidence:
    """Return the complete trials of a study as evidence; those whose arm or values cannot be are left out."""
    arms = [
        Arm(row.joints, row.lengths, row.reach, row.torque, row.trial)
        for row in table.complete
        if sound(row, table.n_joints, table.n_voxels)
    ]

    def maps(arm: Arm) -> Maps | None:
        answer = study.accepted(arm.trial)
        if answer is None:
            return None
        return answer.voxel_reach, answer.voxel_torque, answer.voxel_torque_sd.astype(float)

    def urdf(arm: Arm) -> tuple[str, str] | None:
        candidate = study.candidate_of(arm.trial)
        return None if candidate is None else (candidate.urdf, candidate.tip)

    return Evidence(arms, study.settings.space, study.settings.spec, maps=maps, urdf=urdf)

