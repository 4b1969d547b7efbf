"""What the nodes are told when they start: the one source of their parameters' defaults, bounds and texts.

What a study depends on is taken over from its settings; the rest is said here.
"""

from __future__ import annotations

import os
from copy import copy
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, field_validator

from mobo_core.coordination.answer import AnswerEngine
from mobo_core.design import SPACES, DesignSpace, load_space
from mobo_core.errors import InputError
from mobo_core.evaluation.objectives import OBJECTIVES
from mobo_core.evaluation.spec import DEFAULT_PRESET, PRESETS, lacks, load_spec
from mobo_core.search.samplers.registry import DEFAULT_SAMPLER, SAMPLERS
from mobo_core.search.study import StudySettings
from mobo_core.settings import Listed, Settings

_MANY = 2**31 - 1
_MOST_THREADS, _MOST_PER_CORE = 64, 16
_LONG_S = 1e6
# Settings that are options too.
_OF_STUDY = ("objectives", "sampler", "n_startup_trials", "seed", "in_flight", "engine")
_OF_SPACE = ("n_joints", "lengths")


def _as_in(model: type[Settings], name: str, more: str = "", default: object = None) -> Any:
    """Return the field of another model, ``more`` added to its text, with another default if one is given."""
    field = copy(model.model_fields[name])
    field.description = (field.description or "") + more
    field.default = field.default if default is None else default
    return field


class OptimizerOptions(Settings):
    """What an optimizer is told. Which of these were named, not left to their defaults: ``model_fields_set``."""

    study_name: str = Field("study", description="name of the study")
    n_trials: int = Field(1000, ge=1, le=_MANY, description="trials the bag shall hold in all")
    n_startup_trials: int = _as_in(StudySettings, "n_startup_trials")
    n_joints: int = _as_in(DesignSpace, "n_joints", "; wins over the space's")
    space: str = Field("", description=f"the arms: a preset ({', '.join(SPACES)}) or a YAML file; empty: paper")
    lengths: str = _as_in(DesignSpace, "lengths")
    objectives: Annotated[str, Listed(OBJECTIVES.names)] = Field(
        "reach,torque", description="two or three, comma-separated"
    )
    sampler: str = _as_in(StudySettings, "sampler", default=DEFAULT_SAMPLER)
    seed: int = _as_in(StudySettings, "seed")
    in_flight: int = _as_in(StudySettings, "in_flight")
    engine: str = _as_in(StudySettings, "engine")
    spec: str = Field(
        DEFAULT_PRESET, description=f"what is asked of an arm: a preset ({', '.join(PRESETS)}) or a YAML file"
    )
    bag: str = Field("", description="folder of the bag; empty: bags/<study_name>")
    resume: bool = Field(
        False, description="continue the bag if it exists, with all that is not named as it was; else it is refused"
    )
    must_resume: bool = Field(False, description="resume, and refuse to begin a new bag")
    baselines: str = Field(
        "",
        description="arms that a new study tries first: known, the twins of real arms that its space holds; or a CSV "
        "or Parquet file of arms",
    )
    lease_s: float = Field(
        10.0, ge=0.5, le=_LONG_S, description="s, after which a candidate no heartbeat names goes to another evaluator"
    )
    max_attempts: int = Field(3, ge=1, le=1000, description="failed evaluations after which a trial is told as failed")
    evaluation_timeout_s: float = Field(600.0, ge=1.0, le=_LONG_S, description="s, longest evaluation")

    @field_validator("study_name")
    @classmethod
    def _plain(cls, name: str) -> str:
        if not name or not name.isprintable() or "/" in name or name.startswith("."):
            raise ValueError("a plain name, such as first")
        return name

    @property
    def folder(self) -> Path:
        """Folder of the bag."""
        return Path(self.bag or f"bags/{self.study_name}")

    def settings(self) -> StudySettings:
        """Return what the study's trials depend on.

        Raises:
            InputError: a value or file that does not fit.
        """
        given = self.model_fields_set
        usual = SAMPLERS[self.sampler].defaults if self.sampler in SAMPLERS else {}
        over: dict[str, object] = {}
        if not self.space or self.space in SPACES:
            over |= {name: value for name, value in usual.items() if name in DesignSpace.model_fields}
        over |= {name: getattr(self, name) for name in _OF_SPACE if name in given}
        space = load_space(self.space, over) if self.space else DesignSpace.of(over, where="space")
        values = {name: getattr(self, name) for name in _OF_STUDY}
        values |= {name: value for name, value in usual.items() if name in values and name not in given}
        values |= {"space": space, "spec": load_spec(self.spec)}
        return StudySettings.of(values, where="parameters")

    def check(self, settings: StudySettings) -> None:
        """See that these options can serve a study of such settings.

        Raises:
            InputError: they cannot.
        """

    def named(self, recorded: StudySettings) -> dict[str, object]:
        """Return, as plain values, a bag's settings with those that were named in their place; not checked.

        Raises:
            InputError: a file that cannot be read.
        """
        given, values, space = self.model_fields_set, recorded.to_dict(), recorded.space.to_dict()
        over = {name: getattr(self, name) for name in _OF_SPACE if name in given}
        if "space" in given:
            read = load_space(self.space, over) if self.space else DesignSpace()
            fixed = () if self.space in SPACES else read.model_fields_set  # a sampler may win over a preset
            space = read.to_dict() | {name: space[name] for name in _OF_SPACE if name not in fixed}
        values["space"] = space | over
        values |= {name: getattr(self, name) for name in _OF_STUDY if name in given}
        values["engine"] = values["engine"] if recorded.engine else ""  # of an older bag: any
        if "objectives" in given:
            values["objectives"] = self.objectives.split(",")
        if "spec" in given:
            values["spec"] = load_spec(self.spec).to_dict()
        return values


class _Workers(Settings):
    workers: int = Field(
        default_factory=lambda: os.cpu_count() or 1,
        ge=1, le=1024, description="candidates evaluated at a time, a process each",
    )  # fmt: skip
    threads: int = Field(1, ge=1, le=1024, description="threads of each worker")
    engine: AnswerEngine = Field(
        "kernel", description="kernel, reference (slow, the oracle) or simulated (sleeps, invents values)"
    )
    simulated_s: float = Field(0.1, ge=0.0, le=_LONG_S, description="s of sleep in a simulated evaluation")
    memory_mb: int = Field(4000, ge=0, le=_MANY, description="MB of data each worker may hold; 0: no limit")

    def check_load(self, evaluators: int = 1, cores: int | None = None) -> None:
        """See that the machine can bear so many evaluators' workers; simulated ones sleep, and may be many.

        Raises:
            InputError: more threads than anyone can mean.
        """
        cores = cores or os.cpu_count() or 1
        most, asked = max(_MOST_THREADS, _MOST_PER_CORE * cores), evaluators * self.workers * self.threads
        if self.engine != "simulated" and asked > most:
            factors = {"evaluators": evaluators, "workers": self.workers, "threads": self.threads}
            named = {name: factor for name, factor in factors.items() if factor > 1}
            what = " x ".join(map(str, named.values())) + (f" = {asked}" if len(named) > 1 else "")
            raise InputError(what, where=" x ".join(named), expected=f"at most {most} on {cores} cores")


class EvaluatorOptions(_Workers):
    """What an evaluator is told."""

    evaluation_timeout_s: float = Field(600.0, ge=1.0, le=_LONG_S, description="s, after which a worker is replaced")


class StudyOptions(_Workers, OptimizerOptions):
    """What a study is told: all that its optimizer and its evaluators are, and how many of these there are."""

    workers: int = Field(
        default_factory=lambda: max(1, (os.cpu_count() or 1) // 2),
        ge=1, le=1024, description="workers of each evaluator",
    )  # fmt: skip
    evaluators: int = Field(2, ge=1, le=1000, description="evaluator nodes to start on this host")

    def check(self, settings: StudySettings) -> None:
        """See that the evaluators of this study can answer it."""
        if lack := lacks(self.engine, settings.spec.ik_mode):
            has = {"reference": "spec:=paper or irteus", "kernel": "engine:=reference"}[self.engine]
            raise InputError(f"{lack}, which engine {self.engine} lacks", where="spec", expected=has)


class ReplayOptions(Settings):
    """What a replay is told."""

    bag: str = Field("", description="folder of the bag, or one of its .mcap files")
    rate: float = Field(1.0, ge=0.0, le=1e6, description="times the recorded speed; 0: as fast as possible")
