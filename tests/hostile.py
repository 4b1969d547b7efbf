"""Candidates that no sane optimizer sends."""

from __future__ import annotations

import math
import random
import re
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from nodes import Nodes, wait_for
from peer import Peer

from mobo_core.design import Design, DesignSpace, to_urdf
from mobo_core.evaluation.spec import EvaluationSpec
from mobo_core.evaluation.spec_message import spec_to_message
from mobo_core.messages import Candidate

URDF = to_urdf(Design("YPPYPY", (0.05, 0.25, 0.2, 0.05, 0.0, 0.05)), DesignSpace())
SPEC = EvaluationSpec(poses_per_voxel=1, restarts=1, iterations=10)

_NUMBER = re.compile(r"-?\d+\.\d+(e-?\d+)?")
_TAG = re.compile(r"<[^>]*>")
_ODD = ("1e308", "-1e308", "1e-320", "9" * 400, "nan", "inf", "-inf", "0x10", "", "1 2", "1_0", "٣", "1e", "\x00")
_BOMB = "<!DOCTYPE r [<!ENTITY a0 'x'>" + "".join(
    f"<!ENTITY a{i} '{f'&a{i - 1};' * 10}'>" for i in range(1, 10)
) + "]>"  # fmt: skip


def _flip(text: str, chance: random.Random) -> str:
    letters = list(text)
    for _ in range(chance.choice((1, 1, 1, 3, 30))):
        letters[chance.randrange(len(letters))] = chr(chance.randrange(256))
    return "".join(letters)


def _cut(text: str, chance: random.Random) -> str:
    first, last = sorted(chance.randrange(len(text)) for _ in range(2))
    return text[:first] + text[last:]


def _tags(text: str, chance: random.Random) -> str:
    """Tags taken out, doubled or put elsewhere."""
    for _ in range(chance.choice((1, 2, 8))):
        found = chance.choice(list(_TAG.finditer(text)) or [re.match("", text)])
        assert found is not None
        text = text[: found.start()] + text[found.end() :]
        if chance.random() < 0.5:
            place = chance.randrange(len(text) + 1)
            text = text[:place] + found.group() * chance.choice((1, 2, 300)) + text[place:]
    return text


def _numbers(text: str, chance: random.Random) -> str:
    share = chance.choice((0.005, 0.05, 1.0))
    return _NUMBER.sub(lambda match: chance.choice(_ODD) if chance.random() < share else match.group(), text)


def _bomb(text: str, chance: random.Random) -> str:
    body = text[text.index("<robot") :]
    return _BOMB + body.replace('name="', f'name="&a{chance.randrange(10)};', chance.choice((1, 50)))


def _deep(text: str, chance: random.Random) -> str:
    depth, place = chance.choice((10, 40, 5000)), chance.choice((len(text) - 9, text.index("<link")))
    return text[:place] + "<link>" * depth + "</link>" * chance.choice((depth, 0)) + text[place:]


def _long_chain(text: str, chance: random.Random) -> str:
    """Thousands of links and joints: Pinocchio has crashed on such."""
    count = chance.choice((60, 65, 257, 1000))
    links = "".join(f'<link name="l{i}"/>' for i in range(count))
    joints = "".join(
        f'<joint name="j{i}" type="revolute"><parent link="l{i}"/><child link="l{i + 1}"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        for i in range(count - 1)
    )
    return f'<robot name="long">{links}{joints}</robot>'


MUTATIONS: tuple[Callable[[str, random.Random], str], ...] = (_flip, _cut, _tags, _numbers, _bomb, _deep, _long_chain)


def mutated_urdfs(count: int, seed: int) -> Iterator[str]:
    """Yield URDFs with damage of every kind in turn, some of them twice damaged."""
    for i in range(count):
        chance = random.Random(f"{seed}-{i}")
        text = MUTATIONS[i % len(MUTATIONS)](URDF, chance)
        yield _flip(text, chance) if chance.random() < 0.2 else text


# Field of the spec -> values that make no sense, or more of it than any machine has.
HOSTILE_SPECS: dict[str, tuple[Any, ...]] = {
    "voxel_size": (0.001, 1e-9, 5e-324, 0.0, -0.2, math.nan, math.inf, 1e308),
    "workspace_min": ((math.nan, 0, 0), (-math.inf, 0, 0), (1e308, 0, 0), (0.7, 0, 0)),
    "workspace_max": ((math.nan, 1, 1), (math.inf, 1, 1), (1e300, 1e300, 1e300), (-1, -1, -1)),
    "poses_per_voxel": (0, 2**32 - 1, 65536),
    "restarts": (1001, 2**32 - 1),
    "iterations": (0, 2**32 - 1),
    "position_tolerance": (math.nan, 0.0, -1.0, math.inf, 2.0),
    "rotation_tolerance": (math.nan, 0.0, -1.0, math.inf, 4.0),
    "gravity": ((math.nan, 0, 0), (0, 0, math.inf)),
    "payload_kg": (-1.0, math.nan, math.inf, 1e300),
    "ik_mode": ("", "best", "../../etc/passwd", "x" * 100_000),
    "orientation": ("", "upside down"),
    "solution": ("", "last"),
    "seed": (2**64 - 1,),
}


def candidate(trial: int, evaluator: str, **fields: Any) -> Any:
    """Return a Candidate of the study ``t``, sound but for what is given."""
    base = {"study": "t", "trial": trial, "attempt": 1, "evaluator": evaluator, "urdf": URDF, "tip": "tool"}
    return Candidate(**{**base, "spec": spec_to_message(SPEC), **fields})


def hostile_candidates(evaluator: str) -> list[Any]:
    """Return candidates that must be refused: a field each of the spec, and odd ones of the rest."""
    found = []
    for name, values in HOSTILE_SPECS.items():
        for value in values:
            spec = spec_to_message(SPEC)
            setattr(spec, name, np.array(value, dtype=float) if isinstance(value, tuple) else value)
            found.append(candidate(len(found), evaluator, spec=spec))
    for fields in ({"tip": "x" * 100_000}, {"tip": "\n\x00\x1b[31m"}, {"urdf": "\x00"}, {"urdf": "<" * 90_000}):
        found.append(candidate(len(found), evaluator, **fields))
    return found


def answers_to(peer: Peer, candidates: list[Any]) -> dict[int, Any]:
    """Send candidates, a few at a time, and return the first answer to each trial."""
    answers: dict[int, Any] = {}

    def take() -> dict[int, Any]:
        for answer in peer.heard.pop("evaluations", []):
            answers.setdefault(int(answer.trial), answer)
        return answers

    for first in range(0, len(candidates), 25):
        batch = candidates[first : first + 25]
        for asked in batch:
            peer.send("candidates", asked)
        missing = [int(asked.trial) for asked in batch]
        peer.until(lambda missing=missing: take().keys() >= set(missing), f"answers to {missing}")
    return answers


def live_evaluator(nodes: Nodes, peer: Peer, **parameters: Any) -> Any:
    """Return an evaluator ``e1`` with one worker, heard of."""
    evaluator = nodes.start("evaluator", remap="__node:=e1", workers=1, **parameters)
    peer.until(lambda: "evaluators" in peer.heard or evaluator.poll() is not None, "the evaluator's heartbeat")
    wait_for(lambda: evaluator.poll() is None, "a live evaluator", 1)
    return evaluator
