"""Messages as objects and as bytes."""

from __future__ import annotations

import functools
import math
import struct
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from mobo_core import messages
from mobo_core.errors import InputError, UnableError
from mobo_core.evaluation import EvaluationSpec
from mobo_core.evaluation.spec import MOST_RULES
from mobo_core.evaluation.spec_message import spec_from_message, spec_to_message
from mobo_core.messages import KINDS, SCHEMA_VERSION, Candidate, Evaluation, Header, Message, Trial, address, encode
from mobo_core.messages.schemas import typestore, version_of
from mobo_core.resources import message_folder


def decode(kind: str, data: bytes) -> Message:
    return messages.decode(KINDS[kind], data)


def fields_of(kind: str, version: int = SCHEMA_VERSION) -> list[tuple[str, tuple[str, str]]]:
    """Return (name, (array | sequence | base | message, element type)) of all fields of a definition."""
    found = []
    for name, (node, detail) in typestore(version).fielddefs[f"mobo_msgs/msg/{kind}"][1]:
        if node == Nodetype.BASE:
            found.append((name, ("base", detail[0])))
        elif node == Nodetype.NAME:
            found.append((name, ("message", detail)))
        else:
            found.append((name, ("array" if node == Nodetype.ARRAY else "sequence", detail[0][1][0])))
    return found


# Fields that schema 1 lacks.
LATER = {"rules", "payload_com", "tool_xyz", "tool_rpy", "floor_z", "obstacles", "target_poses"}

_NUMBERS = {
    "bool": st.booleans(),
    "float64": st.floats(),
    "float32": st.floats(width=32),
    **{f"uint{bits}": st.integers(0, 2**bits - 1) for bits in (8, 16, 32, 64)},
    # CDR strings end in a zero byte; surrogates are not text.
    "string": st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=20),
}


def specs() -> st.SearchStrategy[EvaluationSpec]:
    """Specs that make sense."""
    number = st.floats(0.001, 3.0)
    return st.builds(
        lambda shape, size, low, **rest: EvaluationSpec(
            workspace_min=low, workspace_max=[a + n * size for a, n in zip(low, shape, strict=True)],
            voxel_size=size, **rest,
        ),
        st.tuples(*[st.integers(1, 90)] * 3), number, st.tuples(*[st.floats(-10, 10)] * 3),
        poses_per_voxel=st.integers(1, 60), restarts=st.integers(0, 1000), iterations=st.integers(1, 10000),
        position_tolerance=st.floats(1e-300, 1), rotation_tolerance=st.floats(1e-300, math.pi),
        self_collision=st.booleans(), gravity=st.tuples(*[st.floats(-30, 30)] * 3),
        payload_kg=st.floats(0, 1e4), solution=st.sampled_from(["first", "least_torque"]),
        seed=st.integers(0, 2**63 - 1),
    )  # fmt: skip


def messages_of(kind: str) -> st.SearchStrategy[Any]:
    """Messages of a kind with anything its fields can hold."""
    fields: dict[str, st.SearchStrategy[Any]] = {}
    for name, (shape, element) in fields_of(kind):
        if name == "header":
            fields[name] = st.integers(0, 2**31 * 10**9 - 1).map(Header.at)
        elif shape == "message":
            fields[name] = specs().map(spec_to_message)
        elif shape == "base":
            fields[name] = _NUMBERS[element]
        else:
            length = {"min_size": 3, "max_size": 3} if shape == "array" else {"max_size": 5}
            fields[name] = st.lists(_NUMBERS[element], **length)
    return st.fixed_dictionaries(fields).map(lambda values: KINDS[kind](**values))


any_message = st.sampled_from(sorted(KINDS)).flatmap(lambda kind: st.tuples(st.just(kind), messages_of(kind)))


def plain(message: Any) -> Any:
    """Return a message as nested tuples whose floats are bits, so that NaN equals NaN."""
    if isinstance(message, np.ndarray):
        return str(message.dtype), message.tobytes()
    if isinstance(message, float):
        return struct.pack("<d", message)
    if is_dataclass(message):
        return tuple((part.name, plain(getattr(message, part.name))) for part in fields(message))
    return tuple(message) if isinstance(message, list) else message


@given(any_message)
def test_round_trip(case: tuple[str, Any]) -> None:
    """Every message comes back from its bytes as it was, to the bit, and gives the same bytes again."""
    kind, message = case
    data = encode(message)
    back = decode(kind, data)
    assert type(back) is KINDS[kind]
    assert encode(back) == data
    assert plain(back) == plain(message)


@given(any_message, st.data())
def test_truncated_bytes_are_refused(case: tuple[str, Any], data: st.DataObject) -> None:
    """A message cut short anywhere is refused with an InputError that names its kind."""
    kind, message = case
    whole = encode(message)
    cut = data.draw(st.integers(0, len(whole) - 1))
    with pytest.raises(InputError, match=kind) as error:
        decode(kind, whole[:cut])
    assert "\n" not in str(error.value)


@given(any_message, st.data())
def test_damaged_bytes_are_read_or_refused(case: tuple[str, Any], data: st.DataObject) -> None:
    """Changed bytes give some message or an InputError, nothing else."""
    kind, message = case
    whole = bytearray(encode(message))
    for _ in range(data.draw(st.integers(1, 4))):
        whole[data.draw(st.integers(0, len(whole) - 1))] = data.draw(st.integers(0, 255))
    try:
        decode(kind, bytes(whole))
    except InputError as error:
        assert "\n" not in str(error)


@given(st.sampled_from(sorted(KINDS)), st.binary(max_size=400))
@example("Candidate", b"")
@example("Evaluation", b"\x00\x01\x00\x00" + b"\xff" * 400)
def test_garbage_is_read_or_refused(kind: str, garbage: bytes) -> None:
    """Any bytes at all give a message or an InputError, nothing else."""
    try:
        decode(kind, garbage)
    except InputError as error:
        assert kind in str(error)


def test_huge_bytes_are_refused_unread() -> None:
    """Bytes beyond any message of mobo's are refused by their number."""
    with pytest.raises(InputError, match="64000001 bytes; expected at most 64000000"):
        decode("Candidate", bytes(64_000_001))


@given(specs())
def test_spec_round_trip(spec: EvaluationSpec) -> None:
    """A spec comes back equal from its message, and from that message's bytes."""
    message = spec_to_message(spec)
    assert spec_from_message(message) == spec
    assert spec_from_message(decode("EvaluationSpec", encode(message))) == spec


def test_every_field_of_the_spec_is_in_its_message() -> None:
    """The spec and its message have the same fields in the same order."""
    names = [name for name, _ in fields_of("EvaluationSpec")]
    assert names == list(EvaluationSpec.model_fields)
    assert [name for name, _ in fields_of("EvaluationSpec", 1)] == [name for name in names if name not in LATER]


def test_newer_rules_are_no_question_this_version_can_answer() -> None:
    """A spec message that asks for rules of a later version is refused as beyond this version, not as bad."""
    message = spec_to_message(EvaluationSpec())
    assert spec_from_message(message) == EvaluationSpec()
    message.rules = MOST_RULES + 1
    with pytest.raises(UnableError, match="spec: rules = "):
        spec_from_message(message)


def test_rules_that_are_not_said_are_the_first() -> None:
    """Rules 0 in a message, as before there were any, mean 1."""
    message = spec_to_message(EvaluationSpec())
    message.rules = 0
    assert spec_from_message(message) == EvaluationSpec(rules=1)


def test_classes_and_definitions_agree() -> None:
    """Names, order, types and constants of each message class are those of its .msg file."""
    for kind, cls in KINDS.items():
        defined = fields_of(kind)
        assert [part.name for part in fields(cls)] == [name for name, _ in defined]
        for part, (name, (shape, element)) in zip(fields(cls), defined, strict=True):
            plain_type = {"string": "str", "bool": "bool"}.get(element, "float" if "float" in element else "int")
            arrays = {"string": "list[str]", "float64": "Floats", "float32": "Floats32", "uint16": "Counts16",
                      "uint32": "Counts32"}  # fmt: skip
            expected = {"base": plain_type, "message": {"header": "Header", "spec": "SpecMessage"}.get(name)}
            assert part.type == (expected[shape] if shape in expected else arrays[element]), (kind, name)
        constants = typestore().fielddefs[f"mobo_msgs/msg/{kind}"][0]
        assert {name: value for name, value in vars(cls).items() if name.isupper()} == {
            name: value for name, _, value in constants
        }


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [
        ("voxel_size", math.nan, "spec: voxel_size = nan; expected a finite number"),
        ("voxel_size", 1e-9, "at most 1000000 voxels"),
        ("poses_per_voxel", 0, "poses_per_voxel = 0"),
        ("gravity", np.array([0, 0, math.inf]), "gravity.2 = inf"),
        ("workspace_max", np.array([-0.5, 0.5, 0.5]), "at least one voxel"),
        ("floor_z", math.inf, "floor_z = inf"),
        ("obstacles", np.zeros(10), "obstacles of 10 numbers; expected 9 of each, 64 at most"),
        ("obstacles", np.ones(9 * 65), "obstacles of 585 numbers"),
        ("target_poses", np.zeros(7), "target_poses of 7 numbers; expected 6 of each, 1000 at most"),
        ("target_poses", np.zeros(6 * 1001), "target_poses of 6006 numbers"),
        ("target_poses", np.zeros(6), "poses_per_voxel of 1 where poses are given, not 30"),
        ("obstacles", np.zeros(9), "sides above 0"),
        ("obstacles", np.full(9, math.nan), "obstacles.0.centre.0 = nan"),
        ("orientation", "some", "orientation = 'some'; expected 'full'"),
        ("ik_mode", "", "ik_mode = ''"),
        ("seed", 2**64 - 1, "seed"),
    ],
)
def test_bad_spec_messages(field: str, value: Any, words: str) -> None:
    """A message whose spec makes no sense is refused in one line, as a file would be."""
    message = spec_to_message(EvaluationSpec())
    setattr(message, field, value)
    with pytest.raises(InputError) as error:
        spec_from_message(message)
    assert words in str(error.value)
    assert "\n" not in str(error.value)


def test_fields_left_out_are_zero() -> None:
    """A message made without fields is zero and empty, but for its header and schema version."""
    message = Candidate(spec=spec_to_message(EvaluationSpec()))
    assert (message.study, message.trial, message.urdf, len(message.lengths)) == ("", 0, "", 0)
    assert message.schema_version == messages.SCHEMA_VERSION
    assert message.header.frame_id == "base_link"
    assert message.header.stamp.sec > 1_600_000_000
    assert Evaluation().status == Evaluation.OK == 0


def test_unknown_fields_are_a_mistake() -> None:
    """A field that the kind does not have is a programming error, said by name."""
    with pytest.raises(TypeError, match="score"):
        Trial(score=1.0)  # type: ignore[call-arg]


def test_header_of_a_time() -> None:
    """A header takes nanoseconds since 1970."""
    header = Header.at(1_700_000_000_123_456_789)
    stamp = header.stamp
    assert (stamp.sec, stamp.nanosec) == (1_700_000_000, 123_456_789)
    assert header.time_ns == 1_700_000_000_123_456_789


def test_every_kind_is_readable_with_rosbags_alone() -> None:
    """With the definitions that a bag carries, rosbags alone reads mobo's bytes."""
    message = Candidate(study="s", lengths=[0.25, 0.35], spec=spec_to_message(EvaluationSpec(seed=3)))
    definition = messages.schema("Candidate")
    assert definition.name == "mobo_msgs/msg/Candidate"
    assert definition.type_hash.startswith("RIHS01_")
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg(definition.definition, definition.name))
    read = store.deserialize_cdr(encode(message), definition.name)
    assert (read.study, read.spec.seed, list(read.lengths)) == ("s", 3, [0.25, 0.35])  # type: ignore[attr-defined]


def test_every_message_has_a_topic() -> None:
    """Every message file belongs to a recorded topic, to the spec or to the claims of optimizers."""
    assert {path.stem for path in message_folder().glob("*.msg")} == set(KINDS)


questions = st.sampled_from(["Candidate", "Evaluation"]).flatmap(
    lambda kind: st.tuples(st.just(kind), messages_of(kind))
)


def both(kind: str, data: bytes) -> tuple[Any, Any]:
    """Return the address of a message by :func:`address` and by decoding it all; None where it is refused."""
    found = []
    for read in (address, functools.partial(decode, kind)):
        try:
            message = read(data)
            found.append((message.study, message.trial, message.attempt, message.evaluator))
        except InputError:
            found.append(None)
    return found[0], found[1]


@given(questions, st.data())
def test_address_is_that_of_the_whole_message(case: tuple[str, Any], data: st.DataObject) -> None:
    """The address read from the first bytes is the decoded message's, in damaged messages that decode, too."""
    kind, message = case
    little = data.draw(st.booleans())
    whole = bytearray(typestore().serialize_cdr(message, f"mobo_msgs/msg/{kind}", little_endian=little))
    start, decoded = both(kind, bytes(whole))
    assert start == decoded == (message.study, message.trial, message.attempt, message.evaluator)
    for _ in range(data.draw(st.integers(1, 4))):
        # Most of them where the address is.
        last = data.draw(st.sampled_from([80, len(whole)]))
        whole[data.draw(st.integers(0, min(last, len(whole)) - 1))] = data.draw(st.integers(0, 255))
    start, decoded = both(kind, bytes(whole))
    assert decoded is None or start == decoded


@given(st.binary(max_size=100))
@example(b"\0\1\0\0" + b"\xff" * 96)
def test_address_of_garbage(garbage: bytes) -> None:
    """Any bytes at all give an address or an InputError, nothing else."""
    both("Candidate", garbage)


@given(any_message)
def test_older_schemas(case: tuple[str, Any]) -> None:
    """A message written in schema 1 comes back with all the fields that had; the others mean nothing asked."""
    kind, message = case
    back = messages.decode(KINDS[kind], encode(message, 1), 1)
    known, fresh = {name for name, _ in fields_of(kind, 1)}, KINDS[kind]()
    for part in fields(message):
        if part.name == "spec":
            assert plain(back.spec.seed) == plain(message.spec.seed)  # type: ignore[attr-defined]
        else:
            expected = message if part.name in known else fresh
            assert plain(getattr(back, part.name)) == plain(getattr(expected, part.name))


def test_a_definition_tells_its_version() -> None:
    """Whatever its comments; one that is none of mobo's is refused in a line."""
    for kind in KINDS:
        for version in (1, 2):
            definition = messages.schema(kind, version).definition.encode()
            same = messages.schema(kind, 1).definition.encode() == messages.schema(kind, 2).definition.encode()
            assert version_of(kind, definition, "x") == (2 if same else version)
            assert version_of(kind, b"# a comment\n" + definition, "x") == (2 if same else version)
    for bad in (b"", b"uint8 x\n", b"\xff", messages.schema("Trial").definition.encode() + b"\nuint8 more\n"):
        with pytest.raises(InputError, match="/topic: .*; expected a definition of mobo's, of schema 1 or 2$"):
            version_of("Candidate", bad, "/topic")
