"""Groups of arms to measure on: lists that come with mobo or lie in a file, and samples of a recorded study."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from pydantic import Field

from mobo_core.bag.record import StudyRecord
from mobo_core.design import Design, DesignSpace, to_urdf
from mobo_core.errors import InputError
from mobo_core.settings import Settings

_FOLDER = Path(__file__).with_name("groups")
# visited: trials of a study, drawn uniformly; random: see mobo_core.bench.random_arms; picked: arms of the paper's and
# of known structures, with spread and with concentrated lengths.
GROUPS = ("visited6", "visited7", "random", "picked")
DEFAULT_GROUPS = ("visited6", "visited7", "picked")


class Listed(Settings):
    """One design of a list; fields as :class:`mobo_core.design.Design` has them."""

    number: int | None = Field(None, description="trial of the study, or number of the draw")
    joints: str = Field(description="as sampled")
    lengths: tuple[float, ...] = Field(description="m")
    base_height: float = Field(0.0, description="m")
    base_tilt: float = Field(0.0, description="rad")

    @classmethod
    def of_design(cls, design: Design, number: int) -> Listed:
        """Return the entry of a design."""
        height, tilt = design.base_height, design.base_tilt
        joints, lengths = design.sampled_joints, design.lengths
        return cls(number=number, joints=joints, lengths=lengths, base_height=height, base_tilt=tilt)


class Part(Settings):
    """Designs that share a space, from which their URDF takes masses, radius and limits."""

    space: DesignSpace = Field(DesignSpace(), description="of the designs")
    designs: tuple[Listed, ...] = Field(description="the list")


class DesignList(Settings):
    """A list of designs, as ``mobo bench designs`` writes it."""

    source: str = Field("", description="where they come from, for people")
    parts: tuple[Part, ...] = Field(description="the designs by their space")

    def to_text(self) -> str:
        """Return the list as JSON, a design a line."""
        parts = []
        for part in self.parts:
            rows = ",\n".join(json.dumps(d.model_dump(exclude_defaults=True)) for d in part.designs)
            space = json.dumps(part.space.model_dump(exclude_defaults=True))
            parts.append(f'{{"space": {space}, "designs": [\n{rows}\n]}}')
        return f'{{"source": {json.dumps(self.source)}, "parts": [\n' + ",\n".join(parts) + "\n]}\n"


@dataclass(frozen=True)
class Arm:
    """An arm to measure.

    Attributes:
        group: that it is counted in.
        design: the arm.
        space: of its masses, radius and limits.
    """

    group: str
    design: Design
    space: DesignSpace

    @classmethod
    def of(cls, group: str, design: Design, space: DesignSpace | None = None) -> Arm:
        """Return an arm; without a space, one of the default masses, radius and limits.

        Raises:
            InputError: a design that no space has, such as one of too many joints.
        """
        if space is None:
            values = {"n_joints": len(design.joints), "total_length": design.total_length}
            space = DesignSpace.of(values, where=f"design {design.name}")
        return cls(group, design, space)

    @cached_property
    def urdf(self) -> str:
        """The arm's description."""
        return to_urdf(self.design, self.space)


def arms_of_group(name_or_path: str) -> list[Arm]:
    """Return the arms of a group by its name, or of a file that ``mobo bench designs`` wrote.

    Raises:
        InputError: neither a group nor a file of designs.
    """
    own = name_or_path in GROUPS
    path = _FOLDER / f"{name_or_path}.json" if own else Path(name_or_path)
    expected = f"{', '.join(GROUPS)} or a file of designs"
    if not path.is_file():
        raise InputError(f"no group or file {name_or_path!r}", where="--group", expected=expected)
    try:
        values = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"not JSON ({error!s:.80})", where=str(path), expected=expected) from None
    arms = arms_of(name_or_path if own else path.stem, DesignList.of(values, where=str(path)))
    if not arms:
        raise InputError("no design", where=str(path), expected=expected)
    return arms


def arms_of(group: str, designs: DesignList) -> list[Arm]:
    """Return the arms of a list.

    Raises:
        InputError: a design that does not fit its space.
    """
    arms = []
    for part in designs.parts:
        for d in part.designs:
            design = Design(d.joints, d.lengths, d.base_height, d.base_tilt)
            if len(d.joints) != part.space.n_joints:
                expected = f"{part.space.n_joints}, as its space says"
                raise InputError(f"{len(d.joints)} joints", where=f"design {design.name}", expected=expected)
            arms.append(Arm.of(group, design, part.space))
    return arms


def sample_of_study(study: StudyRecord, count: int, seed: int) -> DesignList:
    """Return ``count`` designs drawn uniformly over the trials that were told with values, without repeating one.

    Raises:
        InputError: there are fewer such trials.
    """
    told = [int(trial.trial) for trial in study.complete_trials()]
    told = [number for number in told if study.candidate_of(number) is not None]
    if not 1 <= count <= len(told):
        raise InputError(f"{count} designs", where="--sample", expected=f"1 to the {len(told)} trials told")
    chosen = sorted(np.random.default_rng(seed).choice(told, count, replace=False).tolist())
    settings = study.settings
    source = (
        f"{count} of the {len(told)} trials of study {study.name!r} ({settings.space.n_joints} joints, sampler "
        f"{settings.sampler}, seed {settings.seed}), drawn uniformly with seed {seed}"
    )
    designs = tuple(Listed.of_design(_design(study, number), number) for number in chosen)
    return DesignList(source=source, parts=(Part(space=settings.space, designs=designs),))


def _design(study: StudyRecord, number: int) -> Design:
    candidate = study.candidate_of(number)
    assert candidate is not None
    try:
        return study.settings.space.design(json.loads(candidate.params_json))
    except (ValueError, RecursionError) as error:
        where = f"{study.path} trial {number}"
        raise InputError(f"params_json not readable ({error!s:.80})", where=where, expected="parameters") from None
