"""What all settings that people write as YAML share: strict fields, one-line errors, one canonical form."""

from __future__ import annotations

import json
import reprlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Self, get_args

import yaml
from pydantic import (
    BaseModel,
    ConfigDict,
    SerializationInfo,
    SerializerFunctionWrapHandler,
    ValidationError,
    model_serializer,
)

from mobo_core.errors import InputError

_MAX_YAML_BYTES = 100_000
# Far more than people write, or metadata.yaml of a bag needs; a number has no thousand digits.
_MAX_YAML_NODES, _MAX_YAML_WORD = 20_000, 1000
_Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # where PyYAML was built with libyaml: ten times faster

_REPR = reprlib.Repr()
_REPR.maxstring = _REPR.maxother = _REPR.maxlong = 200
_REPR.maxlevel = 3


@dataclass(frozen=True)
class Listed:
    """Marks a field, by ``Annotated``, whose help begins with what ``names`` returns once it is asked for."""

    names: Callable[[], str]


class Settings(BaseModel):
    """A frozen set of named values; unknown names, wrong types and numbers that are not finite are refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, strict=False)
    # Fields that came later: left out of what is written where they have their defaults, so that settings of older
    # versions read, and compare, as they wrote them.
    later: ClassVar[tuple[str, ...]] = ()

    @model_serializer(mode="wrap")
    def _written(self, write: SerializerFunctionWrapHandler, info: SerializationInfo) -> dict[str, object]:
        values: dict[str, object] = write(self)
        if (info.context or {}).get("full"):
            return values
        fields = type(self).model_fields
        idle = {name for name in self.later if getattr(self, name) == fields[name].default}
        return {name: value for name, value in values.items() if name not in idle}

    @classmethod
    def of(cls, values: object, where: str = "") -> Self:
        """Check ``values`` (a mapping) and build the settings.

        Raises:
            InputError: names the first offending field, its value and what was expected.
        """
        where = where or cls.__name__
        if not isinstance(values, dict):
            raise InputError(f"got {_short(values)}", where=where, expected="a mapping of names to values")
        try:
            return cls(**{str(name): value for name, value in values.items()})
        except ValidationError as error:
            raise _one_line(cls, error, where) from None

    @classmethod
    def from_yaml(cls, path: Path | str) -> Self:
        """Read the settings from a YAML file; fields it leaves out keep their defaults.

        Raises:
            InputError: no such file, not YAML, or a field that does not fit.
        """
        path = Path(path)
        try:
            if path.stat().st_size > _MAX_YAML_BYTES:
                raise InputError("file too large", where=str(path), expected=f"at most {_MAX_YAML_BYTES} bytes")
            values = read_yaml(path.read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError) as error:
            reason = getattr(error, "strerror", None) or "not UTF-8 text"
            raise InputError(reason, where=str(path), expected=f"a YAML file of {cls.__name__}") from None
        except ValueError as error:
            raise InputError(f"not YAML ({_short(str(error))})", where=str(path), expected="YAML") from None
        return cls.of(cls._from_file({} if values is None else values, path), where=str(path))

    @classmethod
    def _from_file(cls, values: object, path: Path) -> object:
        """Return the values of a file as :meth:`of` takes them; for fields that other files hold."""
        return values

    def to_dict(self, *, full: bool = False) -> dict[str, object]:
        """Return plain values (numbers, strings, lists), fit for JSON and YAML.

        Args:
            full: with the fields that are left out where they ask for nothing, if the settings have such.
        """
        return self.model_dump(mode="json", context={"full": full})

    def to_json(self) -> str:
        """Return the canonical text: equal settings give equal text."""
        return json.dumps(self.to_dict(), sort_keys=True)


def read_yaml(text: str | bytes) -> object:
    """Return what a YAML text holds: plain values.

    Raises:
        ValueError: it is none, or one that only grows beyond measure when it is read: aliases of aliases.
    """
    try:
        _check_nodes(text)
        return yaml.load(text, _Loader)
    except Exception as error:  # its constructors raise whatever they meet; deep nesting ends the stack
        raise ValueError(str(error) or type(error).__name__) from None


def _check_nodes(text: str | bytes) -> None:
    """Count the nodes of a YAML text, aliases as what they stand for; raise ValueError at too many."""
    sizes: dict[str, int] = {}
    open_: list[tuple[str | None, int]] = []  # anchor, and the count before it
    count = 0
    for event in yaml.parse(text, _Loader):
        if isinstance(event, yaml.CollectionEndEvent):
            anchor, before = open_.pop()
            sizes |= {anchor: count - before} if anchor else {}
        elif isinstance(event, yaml.AliasEvent):
            if event.anchor is None or event.anchor not in sizes:
                raise ValueError(f"alias {event.anchor!r:.40} of what is not complete")
            count += sizes[event.anchor]
        elif isinstance(event, yaml.NodeEvent):
            open_ += [(event.anchor, count)] if isinstance(event, yaml.CollectionStartEvent) else []
            count += 1
            if isinstance(event, yaml.ScalarEvent):
                sizes |= {event.anchor: 1} if event.anchor else {}
                if event.implicit[0] and len(event.value) > _MAX_YAML_WORD:
                    raise ValueError(f"a word of {len(event.value):,} characters")
        if count > _MAX_YAML_NODES:
            raise ValueError(f"more than {_MAX_YAML_NODES:,} values")


def _short(value: object) -> str:
    # Never the whole value: a few aliases in a YAML make one that no memory holds.
    try:
        text = " ".join(_REPR.repr(value).split())
    except ValueError:  # an integer with more digits than Python prints
        text = "a very large number"
    return text if len(text) <= 80 else text[:77] + "..."


def _one_line(cls: type[BaseModel], error: ValidationError, where: str) -> InputError:
    first = error.errors(include_url=False)[0]
    name = ".".join(str(part) for part in first["loc"])
    if first["type"] == "extra_forbidden":
        fields = cls.model_fields
        for part in (part for part in first["loc"][:-1] if isinstance(part, str)):
            # Down to the settings within settings, or in a list of them, that it is in.
            annotation = fields[part].annotation
            fields = getattr((*get_args(annotation), annotation)[0], "model_fields", fields)
        return InputError(f"unknown field {name!r}", where=where, expected="one of " + ", ".join(fields))
    what = f"{name} = {_short(first['input'])}" if name else _short(first["input"])
    message = str(first["msg"])
    for prefix in ("Value error, ", "Input should be ", "Assertion failed, "):
        message = message.removeprefix(prefix)
    return InputError(what, where=where, expected=message)
