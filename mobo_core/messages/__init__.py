"""What is said: the messages between optimizer and evaluators, typed, and as CDR bytes without ROS."""

from mobo_core.messages.codec import MAX_MESSAGE_BYTES, Address, address, decode, encode
from mobo_core.messages.schemas import VERSIONS, Schema, schema, version_of
from mobo_core.messages.types import (
    KINDS,
    SCHEMA_VERSION,
    TOPICS,
    UNABLE,
    Candidate,
    Command,
    Evaluation,
    EvaluatorStatus,
    Header,
    Message,
    OptimizerStatus,
    SpecMessage,
    StudyStatus,
    Trial,
)

__all__ = [
    "KINDS", "MAX_MESSAGE_BYTES", "SCHEMA_VERSION", "TOPICS", "UNABLE", "VERSIONS", "Address", "Candidate", "Command",
    "Evaluation", "EvaluatorStatus", "Header", "Message", "OptimizerStatus", "Schema", "SpecMessage", "StudyStatus",
    "Trial", "address", "decode", "encode", "schema", "version_of",
]  # fmt: skip
