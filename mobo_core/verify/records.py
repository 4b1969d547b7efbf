"""Whether what was sent out belongs to the study's settings, and is one arm."""

from __future__ import annotations

import json
from collections.abc import Iterator

from mobo_core.bag.record import StudyRecord, schema_version_of
from mobo_core.design import to_urdf
from mobo_core.design.description import TIP_LINK
from mobo_core.errors import InputError
from mobo_core.evaluation.spec_message import spec_to_message
from mobo_core.messages import encode
from mobo_core.verify.fault import Fault


def check_candidates(study: StudyRecord) -> Iterator[Fault]:
    """Check what was sent out: it is of the study, and its parameters, lengths, joints and URDF are one arm's."""
    settings, space = study.settings, study.settings.space
    spec = encode(spec_to_message(settings.spec))
    version = schema_version_of(study.record, str(study.path))
    urdfs: dict[int, str] = {}
    params: dict[int, str] = {}
    engine: str = settings.engine
    for candidate in study.candidates:
        trial = candidate.trial
        if encode(candidate.spec) != spec:
            yield Fault(trial, "spec", "differs from the study's")
        engine = engine or candidate.engine  # a study that names none goes by its first candidate's
        known: tuple[tuple[str, object, object], ...] = (
            ("tip", candidate.tip, TIP_LINK),
            ("schema_version", candidate.schema_version, version),
            ("objectives", list(candidate.objectives), list(settings.objectives) if version > 1 else []),
            ("engine", candidate.engine, engine if version > 1 else ""),
            ("params_json", candidate.params_json, params.setdefault(trial, candidate.params_json)),
        )
        for field, is_, should in known:
            if is_ != should:
                yield Fault(trial, field, f"{is_!r:.200}, but it should be {should!r:.200}")
        try:
            found = json.loads(candidate.params_json)
            design = space.design(found)
        except (ValueError, RecursionError, InputError) as error:
            yield Fault(trial, "params_json", f"no parameters of the space ({error!r:.80})")
            continue
        if candidate.params_json != json.dumps(found):
            yield Fault(trial, "params_json", f"{candidate.params_json!r:.200}, which says {found}")
        arm: tuple[tuple[str, object, object], ...] = (
            ("sampled_joints", candidate.sampled_joints, design.sampled_joints),
            ("joints", candidate.joints, design.joints),
            ("lengths", tuple(candidate.lengths.tolist()), design.lengths),
        )
        for field, is_, should in arm:
            if is_ != should:
                yield Fault(trial, field, f"{is_!r:.200}, but the parameters give {should!r:.200}")
        if trial not in urdfs:
            urdfs[trial] = to_urdf(design, space)
        if candidate.urdf != urdfs[trial]:
            yield Fault(trial, "urdf", _first_difference(candidate.urdf, urdfs[trial]))


def check_enqueued(study: StudyRecord) -> Iterator[Fault]:
    """Check that each command that enqueues names an arm of the space."""
    for command in study.commands:
        if command.command != "enqueue":
            continue
        number = command.trial
        try:
            asked = json.loads(command.arguments_json)
            params = study.settings.space.params(study.settings.space.arm(asked["joints"], asked["lengths"]))
        except (ValueError, KeyError, TypeError, ArithmeticError, RecursionError, InputError) as error:
            yield Fault(number, "command", f"enqueued no arm of the space ({error!r:.80})")
            continue
        if asked.get("params") != params:
            yield Fault(number, "command", f"enqueued {asked.get('params')!r:.200}, but its lengths give {params}")


def _first_difference(found: str, expected: str) -> str:
    pairs = enumerate(zip(found, expected, strict=False))
    at = next((i for i, (a, b) in pairs if a != b), min(len(found), len(expected)))
    return f"byte {at}: {found[at : at + 20]!r}, but xacro gives {expected[at : at + 20]!r}"
