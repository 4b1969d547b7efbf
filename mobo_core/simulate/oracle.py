"""The study as it is when nothing disturbs it: what the trials of a disturbed one must be, to the bit."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from mobo_core.coordination.answer import Answering, simulated
from mobo_core.design import Design, DesignSpace
from mobo_core.design.prepared import PreparedXacro
from mobo_core.search.study import OrderedStudy, Params, StudySettings, Told
from mobo_core.simulate.workers import is_bad

# Reach and torque; None if the trial failed.
Values = tuple[float, float] | None

_ANSWERING = Answering("oracle", "simulated", simulated_s=0.0)


@dataclass(frozen=True)
class Expected:
    """What a trial must be.

    Attributes:
        params_json, urdf: of its arm.
        values: reach and torque; None if every evaluator rejects the arm.
    """

    params_json: str
    urdf: str
    values: Values


_xacros: dict[str, PreparedXacro] = {}
_urdfs: dict[tuple[str, Design], str] = {}


def describer(space: DesignSpace) -> Callable[[Design], str]:
    """Return what makes the URDF of an arm by xacro, each once."""
    key = space.to_json()

    def describe(design: Design) -> str:
        if (key, design) not in _urdfs:
            if key not in _xacros:
                _xacros[key] = PreparedXacro(space)
            _urdfs[key, design] = _xacros[key].to_urdf(design)
        return _urdfs[key, design]

    return describe


class Oracle:
    """Runs the study by itself, as far as it is asked.

    Args:
        settings: of the study.
        alone: whether nobody else asks it, so that a study may go another way.
    """

    def __init__(self, settings: StudySettings, *, alone: bool) -> None:
        self._settings, self._alone = settings, alone
        self._study, self._describe, self._spec = OrderedStudy(settings), describer(settings.space), settings.spec
        self._trials: list[Expected] = []

    def anew(self) -> Oracle:
        """Return one for a study that goes on from an earlier trial, maybe in another way."""
        return Oracle(self._settings, alone=True) if self._alone else self

    def expects(self, number: int, enqueued: Mapping[int, Params], otherwise: Mapping[int, Values]) -> Expected:
        """Return what a trial must be.

        Args:
            number: of the trial.
            enqueued: arms that are asked at their numbers.
            otherwise: what trials were told other than they must be: those asked after them see that.
        """
        while len(self._trials) <= number:
            while not self._study.may_ask():
                told = len(self._study.told)
                self._study.tell(Told(told, otherwise.get(told, self._trials[told].values)))
            params = enqueued.get(len(self._trials))
            asked = self._study.ask() if params is None else self._study.recall(params)
            urdf = self._describe(asked.design)
            values: Values = None
            if not is_bad(urdf):
                result = simulated(urdf, self._spec, 0.0)
                values = (result.reach, result.torque)
            self._trials.append(Expected(json.dumps(asked.params), urdf, values))
        return self._trials[number]


_known: dict[str, Oracle] = {}


def oracle_of(settings: StudySettings, *, alone: bool) -> Oracle:
    """Return an oracle of these settings; unless ``alone``, one that others have asked before."""
    if alone:
        return Oracle(settings, alone=True)
    key = settings.to_json()
    if key not in _known:
        if len(_known) >= 64:
            _known.clear()
        _known[key] = Oracle(settings, alone=False)
    return _known[key]
