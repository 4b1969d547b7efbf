"""Reads the trials of bags, a message at a time; answers are passed over."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from mobo_core.atlas.trials import Rows, Trials
from mobo_core.bag.collector import message_of
from mobo_core.bag.files import bag_files
from mobo_core.bag.reader import FileContent, read_record, stream
from mobo_core.bag.record import settings_of
from mobo_core.bag.validity import check_plain, values_of
from mobo_core.design.numbers import middle
from mobo_core.errors import InputError
from mobo_core.messages import Candidate, Trial
from mobo_core.search.study import StudySettings, first_difference

_BASE = ("base_height", "base_tilt")
# What bags have to agree in. How lengths are drawn is no matter: all ways span the same arms.
_SAME = ("space", "spec", "objectives")


@dataclass(frozen=True)
class Source:
    """A study that an atlas comes from.

    Attributes:
        name: of the study.
        settings: of it.
        engine: of its evaluators; "" if its bag does not say.
        record: the metadata record of its bag.
        faults: what of its files could not be read, a line each.
    """

    name: str
    settings: StudySettings
    engine: str
    record: dict[str, str]
    faults: tuple[str, ...] = ()


def question(settings: StudySettings) -> dict[str, object]:
    """Return what values of arms depend on, as plain settings: where these are equal, values can be compared."""
    values = settings.to_dict()
    space = values["space"]
    assert isinstance(space, dict)
    kept = {name: value for name, value in space.items() if name != "lengths"}
    return {name: kept if name == "space" else values[name] for name in _SAME}


def names_of(objectives: Sequence[str]) -> tuple[str, ...]:
    """Return the values that every trial of a study has: reach, torque, and its further objectives."""
    return ("reach", "torque", *(name for name in objectives if name not in ("reach", "torque")))


def read_trials(bags: Sequence[Path]) -> tuple[list[Source], Trials]:
    """Read the trials of bags that ask the same; a damaged file counts up to its damage.

    Trials of which a bag lost the candidate are left out, as are values that are no numbers.

    Raises:
        InputError: no bag, not one of a mobo study, or one that asks something else than the first.
    """
    records = [read_record(bag) for bag in bags]
    settings = [settings_of(record, str(bag)) for record, bag in zip(records, bags, strict=True)]
    for bag, other in zip(bags[1:], settings[1:], strict=True):
        if difference := first_difference(question(other), question(settings[0])):
            name, own, expected = difference
            raise InputError(f"{name} is {own!r:.60}", where=str(bag), expected=f"{expected!r:.60}, as in {bags[0]}")
    rows = Rows(names_of(settings[0].objectives), settings[0].space.n_joints)
    sources: list[Source] = []
    for bag, record, own in zip(bags, records, settings, strict=True):
        source = _read(bag, record, own, len(sources), rows)
        known = next((one.engine for one in sources if one.engine), source.engine)
        if source.engine and source.engine != known:
            raise InputError(f"engine is {source.engine!r}", where=str(bag), expected=f"{known!r}, as in {bags[0]}")
        sources.append(source)
    return sources, rows.trials()


def _read(bag: Path, record: dict[str, str], settings: StudySettings, study: int, rows: Rows) -> Source:
    space, names = settings.space, names_of(settings.objectives)
    fixed = middle(space.base_height), middle(space.base_tilt)
    searched = isinstance(space.base_height, tuple) or isinstance(space.base_tilt, tuple)
    arms: dict[int, tuple[str, tuple[float, ...], tuple[float, float]]] = {}  # sent and not told
    told: set[int] = set()
    engine: str = settings.engine
    faults: list[str] = []
    for path in bag_files(bag):
        content = FileContent(path)
        for entry in stream(content):
            if entry.kind not in ("Candidate", "Trial"):
                continue
            message = message_of(entry)
            assert isinstance(message, Candidate | Trial)
            check_plain(message, str(bag))
            number = int(message.trial)
            if number in told:
                continue
            if isinstance(message, Candidate):
                if number not in arms and len(message.lengths) == space.n_joints == len(message.joints):
                    base = _base(message.params_json, fixed) if searched else fixed
                    arms[number] = message.joints, tuple(message.lengths.tolist()), base
                    engine = engine or message.engine
                continue
            told.add(number)
            if (arm := arms.pop(number, None)) is not None:
                values = values_of(message, names)
                good = message.state == Trial.COMPLETE and all(map(math.isfinite, values))
                rows.add(study, number, *arm, values if good else [math.nan] * len(names))
        faults += [f"{path}: {content.fault}"] if content.fault else []
    return Source(record.get("study", ""), settings, engine, record, tuple(faults))


def _base(params_json: str, fixed: tuple[float, float]) -> tuple[float, float]:
    """Return height and tilt of the base that a sampler's parameters give, or the middle of where it may be."""
    try:
        params = json.loads(params_json)
        height, tilt = (float(params.get(name, value)) for name, value in zip(_BASE, fixed, strict=True))
    except (ValueError, TypeError, AttributeError, RecursionError):
        return fixed
    return (height, tilt) if math.isfinite(height) and math.isfinite(tilt) else fixed
