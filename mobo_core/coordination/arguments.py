"""The words on a node's command line: what means nothing is refused, with the command that was meant."""

from __future__ import annotations

import difflib
import json
import re
import shlex
from collections.abc import Iterable, Sequence

import yaml

from mobo_core.coordination.parameters import Value
from mobo_core.errors import InputError

# What rclpy itself takes as parameters.
OF_ROS = ("use_sim_time", "qos_overrides.", "start_type")

_WITH_VALUE = (
    "-p", "--param", "-r", "--remap", "--params-file", "--log-level", "--log-config-file", "--log-file-name",
    "-e", "--enclave",
)  # fmt: skip
_ALONE = tuple(f"--{do}able-{what}-logs" for do in ("en", "dis") for what in ("rosout", "stdout", "external-lib"))


def nearest(name: str, known: Iterable[str]) -> str:
    """Return the name that was probably meant, or ""."""
    found = difflib.get_close_matches(name.replace("-", "_").lower(), list(known), 1, 0.75)
    return found[0] if found else ""


def parameter_word(name: str, value: Value) -> str:
    """Return ``NAME:=VALUE`` as a node reads it after ``-p``: a text that looks like something else in quotes."""
    if not isinstance(value, str):
        number = re.sub(r"^(\d+)e", r"\1.0e", json.dumps(value))  # YAML's floats have a point
        return f"{name}:={number}"
    try:
        plain = bool(value) and yaml.safe_load(value) == value
    except yaml.YAMLError:
        plain = False
    return f"{name}:={value if plain else json.dumps(value, ensure_ascii=False)}"


def command_line(executable: str, words: Iterable[str]) -> str:
    """Return the command that starts a node with these ROS arguments, to be copied into a shell."""
    listed = list(words)
    return shlex.join(["ros2", "run", "mobo", executable, *(["--ros-args"] if listed else []), *listed])


def check_arguments(executable: str, words: Sequence[str], known: Iterable[str] | None) -> None:
    """Check the words that follow a node's name on its command line.

    Args:
        executable: the node.
        words: on its command line.
        known: names of its parameters; None: it has none, and reads itself what is not between ``--ros-args``
            and ``--``.

    Raises:
        InputError: a word that means nothing to ROS or to the node, with the command that was probably meant.
    """
    reading = _Reading(words, known)
    if reading.fault:
        expected = command_line(executable, reading.meant) if reading.meant else f"what {executable} --help shows"
        raise InputError(reading.fault, where="arguments", expected=expected)


class _Reading:
    """Takes the words one by one; keeps the first fault, and what can be made of all of them."""

    def __init__(self, words: Sequence[str], known: Iterable[str] | None) -> None:
        self._words, self._known = list(words), None if known is None else list(known)
        self.fault = ""
        self.meant: list[str] = []
        self._in_ros = False
        while self._words:
            self._take(self._words.pop(0))

    def _take(self, word: str) -> None:
        if word == "--ros-args":
            self._in_ros = True
        elif word == "--":
            self._in_ros = False
        elif not self._in_ros and self._known is None:
            return  # its own
        elif word in _WITH_VALUE:
            if not self._in_ros:
                self._blame(f"{word} comes after --ros-args")
            self._take_option(word)
        elif word in _ALONE and self._in_ros:
            self.meant.append(word)
        else:
            self._take_unknown(word)

    def _take_option(self, option: str) -> None:
        if not self._words:
            return self._blame(f"nothing follows {option}")
        value = self._words.pop(0)
        if option in ("-p", "--param"):
            return self._take_parameter(value)
        if option in ("-r", "--remap") and ":=" not in value:
            self._blame(f"{option} {value}, without :=")
        self.meant += [option, value]

    def _take_parameter(self, given: str) -> None:
        name, colon, value = given.partition(":=")
        if not colon:
            self._blame(f"-p {given}, without :=")
            name, equals, value = given.partition("=")
            if not equals and self._words and not self._words[0].startswith("-"):
                value = self._words.pop(0)
        elif not value:
            self._blame(f"-p {given}, without a value")
        if self._known is not None and ":" not in name and name not in self._known and not name.startswith(OF_ROS):
            self._blame(f"unknown parameter {name!r}")
            name = nearest(name, self._known)
        if name and value:
            self.meant += ["-p", f"{name}:={value}"]

    def _take_unknown(self, word: str) -> None:
        name, given, value = word.partition(":=")
        if not given:
            name, given, value = word.partition("=")
        name = nearest(name.lstrip("-"), self._known or ())
        if not name:
            return self._blame(f"unknown argument {word!r}", first=True)
        self._blame(f"unknown argument {word!r}")
        if not given:
            takes = bool(self._words) and not self._words[0].startswith("-")
            value = self._words.pop(0) if takes else "true"
        self.meant += ["-p", f"{name}:={value}"]

    def _blame(self, fault: str, *, first: bool = False) -> None:
        """Keep the first fault; one that nothing can be made of comes before those that are mended."""
        if first and not self.fault.startswith("unknown"):
            self.fault = fault
        self.fault = self.fault or fault
