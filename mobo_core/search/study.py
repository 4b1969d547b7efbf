"""The ordered study: trial n sees the values of trials 0 to n - in_flight, whatever else is known."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Annotated, Literal

import optuna
from optuna.trial import TrialState
from pydantic import Field, ValidationInfo, field_validator

from mobo_core.design import Design, DesignSpace
from mobo_core.errors import InputError
from mobo_core.evaluation.objectives import OBJECTIVES
from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.search.front import Aims, aims_of
from mobo_core.search.recalled import recalled
from mobo_core.search.samplers.registry import SAMPLERS, sampler_names
from mobo_core.search.samplers.sampler import Task
from mobo_core.settings import Listed, Settings


class StudySettings(Settings):
    """All that the trials of a study depend on. Two studies of equal settings have equal trials.

    ``in_flight`` is the number of trials asked before the first of them is told: it is part of the function,
    whatever the number of evaluators.
    """

    space: DesignSpace = DesignSpace()
    spec: EvaluationSpec = EvaluationSpec()
    objectives: tuple[str, ...] = Field(("reach", "torque"), description="two or three, in the order of their values")
    sampler: Annotated[str, Listed(sampler_names)] = Field("tpe", description="in brackets what it sets unless named")
    sampler_rules: int = Field(
        0, ge=0, validate_default=True, description="which of the algorithms that the sampler has had; 0: the latest"
    )
    n_startup_trials: int = Field(
        100, ge=1, le=1_000_000, description="random trials before the sampler's model takes over"
    )
    seed: int = Field(0, ge=0, lt=2**63, description="of the sampler only; that of targets and IK starts is the spec's")
    in_flight: int = Field(
        8, ge=1, le=10_000, description="trials asked before the first of them is told; part of the study's function"
    )
    engine: Literal["", "kernel", "reference", "simulated"] = Field(
        "", description="engine of all evaluators that get work; empty: that of the first one that joins"
    )

    @field_validator("objectives", mode="before")
    @classmethod
    def _words(cls, objectives: object) -> object:
        return objectives.split(",") if isinstance(objectives, str) else objectives

    @field_validator("objectives")
    @classmethod
    def _distinct(cls, objectives: tuple[str, ...]) -> tuple[str, ...]:
        if not 2 <= len(objectives) <= 3 or len(set(objectives)) < len(objectives):
            raise ValueError("two or three distinct names")
        for name in objectives:
            if name not in OBJECTIVES:
                raise ValueError(f"names of {OBJECTIVES.names()}")
        return objectives

    @field_validator("sampler")
    @classmethod
    def _fits(cls, sampler: str, info: ValidationInfo) -> str:
        if sampler not in SAMPLERS:
            raise ValueError(" or ".join(repr(name) for name, known in SAMPLERS.items() if known.offered))
        space, objectives = info.data.get("space"), info.data.get("objectives")
        if space is not None and objectives is not None and (why := SAMPLERS[sampler].unfit(space, objectives)):
            raise ValueError(f"another than {sampler} {why}")
        return sampler

    @field_validator("sampler_rules")
    @classmethod
    def _of_the_sampler(cls, rules: int, info: ValidationInfo) -> int:
        latest = SAMPLERS[info.data["sampler"]].rules if "sampler" in info.data else 1
        if rules > latest > 1:
            raise ValueError(f"at most {latest} of {info.data['sampler']}")
        return min(rules or latest, latest)  # one that has had one algorithm alone goes by that

    @property
    def aims(self) -> Aims:
        """What the study wants of its objectives."""
        return aims_of(self.objectives, self.spec)

    def first_difference(self, other: StudySettings) -> tuple[str, object, object] | None:
        """Return (name, own value, other's value) of the first setting that differs, or None."""
        return first_difference(self.to_dict(), other.to_dict())


def first_difference(own: dict[str, object], others: dict[str, object]) -> tuple[str, object, object] | None:
    """Return (name, own value, other's value) of the first of some plain settings that differs, or None."""

    def flat(values: dict[str, object], prefix: str = "") -> dict[str, object]:
        out: dict[str, object] = {}
        for name, value in values.items():
            out |= flat(value, f"{prefix}{name}.") if isinstance(value, dict) else {prefix + name: value}
        return out

    here, there = flat(own), flat(others)
    for name in [*here, *there]:
        if here.get(name) != there.get(name):
            return name, here.get(name), there.get(name)
    return None


# A sampler's own parameters, by name: what it drew, and what a bag holds of it as JSON.
Params = dict[str, str | float]


@dataclass(frozen=True)
class Asked:
    """A trial that the sampler asks for.

    Attributes:
        number: of the trial, from 0.
        design: the arm.
        params: the sampler's own parameters.
    """

    number: int
    design: Design
    params: Params


@dataclass(frozen=True)
class Told:
    """What a trial came to: the values of the objectives in their order, or None if it failed."""

    number: int
    values: tuple[float, ...] | None


class OrderedStudy:
    """Ask and tell in the one order that makes a study a function of its settings.

    Trials are told in the order of their numbers. What the sampler sees lags behind: just before trial n is
    asked, it is given the values of trials 0 to n - in_flight and no others. So timing never decides which
    values it knows.
    """

    def __init__(self, settings: StudySettings) -> None:
        self.settings = settings
        sampler = SAMPLERS[settings.sampler]
        given = (settings.n_startup_trials, settings.seed, settings.sampler_rules)
        task = Task(settings.space, settings.spec, settings.objectives, *given)
        self._sampler, self._stateful = sampler.factory(task), sampler.stateful
        self._optuna = optuna.create_study(
            directions=[OBJECTIVES[name].direction for name in settings.objectives], sampler=self._sampler(0)
        )
        self._asked: list[Asked] = []
        self._told: list[Told] = []
        self._seen = 0

    @property
    def asked(self) -> list[Asked]:
        """The trials asked so far, by number."""
        return self._asked

    @property
    def told(self) -> list[Told]:
        """The trials told so far, by number."""
        return self._told

    def may_ask(self) -> bool:
        """Return whether the next trial's turn has come."""
        return len(self._told) > len(self._asked) - self.settings.in_flight

    def ask(self) -> Asked:
        """Draw the next trial. Only when :meth:`may_ask`."""
        number = len(self._asked)
        self._catch_up(number)
        self._optuna.sampler = self._sampler(number)
        trial = self._optuna.ask()
        design = self.settings.space.suggest(trial)
        asked = Asked(number, design, dict(trial.params))
        self._asked.append(asked)
        return asked

    def recall(self, params: Params) -> Asked:
        """Take the next trial from a record instead of from the sampler.

        Raises:
            InputError: they are no parameters of the space.
        """
        number = len(self._asked)
        self._catch_up(number)
        space = self.settings.space
        design, trial = recalled(space, params, f"params_json of trial {number}")
        asked = Asked(number, design, params)
        if self._stateful:
            self._optuna.sampler = self._sampler(number)
            self._optuna.enqueue_trial(params)
            again = self._optuna.ask()
            _ = again.relative_params  # has the sampler draw, in vain but for its notes
            space.suggest(again)
        else:
            self._optuna.add_trial(trial)
        self._asked.append(asked)
        return asked

    def tell(self, told: Told) -> None:
        """Take the values of the next trial in order.

        Raises:
            ValueError: it is another trial's turn.
        """
        if told.number != len(self._told) or told.number >= len(self._asked):
            raise ValueError(f"trial {told.number} told, but it is the turn of trial {len(self._told)}")
        self._told.append(told)

    def _catch_up(self, number: int) -> None:
        """Let the sampler see what trial ``number`` may see."""
        last = number - self.settings.in_flight
        if last >= len(self._told):
            raise ValueError(f"trial {number} asked before trial {last} is told")
        while self._seen <= last:
            told = self._told[self._seen]
            if told.values is None:
                self._optuna.tell(told.number, state=TrialState.FAIL)
            else:
                self._optuna.tell(told.number, list(told.values))
            self._seen += 1


def frozen_trial(space: DesignSpace, params: Params, where: str) -> optuna.trial.FrozenTrial:
    """Return parameters that a record holds as a trial of Optuna's that runs.

    Raises:
        InputError: they are none of the space; ``where`` they were found.
    """
    try:
        with warnings.catch_warnings(action="ignore"):  # of values out of range, refused here
            distributions = space.distributions(params)
        return optuna.trial.create_trial(state=TrialState.RUNNING, params=params, distributions=distributions)
    except (ValueError, KeyError, TypeError, AttributeError, ArithmeticError, RecursionError, InputError) as error:
        raise InputError(f"not readable ({error!r:.80})", where=where, expected="parameters of the space") from None
