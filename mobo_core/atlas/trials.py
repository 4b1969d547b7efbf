"""The trials of studies as columns: little memory, whatever their number."""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Counts = NDArray[np.int64]


@dataclass(frozen=True)
class Trials:
    """Trials told of one or more studies, a row each, in the order of their numbers.

    Attributes:
        names: of the columns of ``values``: reach, torque, and further objectives.
        orders: joint orders as built.
        values: (n, names); NaN of a trial that failed.
        order: (n,) which of ``orders``.
        lengths: (n, joints) m.
        base: (n, 2) m and rad: height and tilt of the base.
        study: (n,) which of the studies.
        number: (n,) of the trial in its study.
    """

    names: tuple[str, ...]
    orders: tuple[str, ...]
    values: Floats
    order: Counts
    lengths: Floats
    base: Floats
    study: Counts
    number: Counts

    def __len__(self) -> int:
        """Return the number of trials."""
        return len(self.order)


class Rows:
    """Takes trials one at a time.

    Args:
        names: of the values.
        n_joints: of every arm.
    """

    def __init__(self, names: Sequence[str], n_joints: int) -> None:
        self._names, self._n_joints = tuple(names), n_joints
        self._orders: dict[str, int] = {}
        self._values, self._lengths, self._base = array("d"), array("d"), array("d")
        self._order, self._study, self._number = array("q"), array("q"), array("q")

    def add(
        self,
        study: int,
        number: int,
        joints: str,
        lengths: Sequence[float],
        base: tuple[float, float],
        values: Sequence[float],
    ) -> None:
        """Take a trial; values are NaN if it failed."""
        self._study.append(study)
        self._number.append(number)
        self._order.append(self._orders.setdefault(joints, len(self._orders)))
        self._lengths.extend(lengths)
        self._base.extend(base)
        self._values.extend(values)

    def trials(self) -> Trials:
        """Return all of them; of several studies those of one number stand together."""
        study, number = np.array(self._study, np.int64), np.array(self._number, np.int64)
        by = np.lexsort((study, number))
        n = len(by)
        return Trials(
            self._names,
            tuple(self._orders),
            np.array(self._values).reshape(n, len(self._names))[by],
            np.array(self._order, np.int64)[by],
            np.array(self._lengths).reshape(n, self._n_joints)[by],
            np.array(self._base).reshape(n, 2)[by],
            study[by],
            number[by],
        )
