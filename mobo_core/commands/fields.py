"""The fields of settings, for people: a commented YAML file, and a Markdown table."""

from __future__ import annotations

import math
import types
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, get_args, get_origin

import annotated_types
import yaml
from pydantic.fields import FieldInfo

from mobo_core.design.numbers import Numbers
from mobo_core.settings import Settings

_WIDTH = 100
_LISTS = {
    "joint": "or a list, one a joint",
    "range": "or a range [low, high]",
    "given": "a list, one a joint, null for none",
    "ranges": "or a list, one or a range [low, high] a joint",
}


@dataclass(frozen=True)
class FieldText:
    """A field: its name, default as YAML, what values it takes, and what it means, units first."""

    name: str
    default: str
    values: str
    meaning: str


def fields_of(model: type[Settings]) -> list[FieldText]:
    """Return the fields of settings in their order."""
    return [
        FieldText(name, _yaml(model().to_dict(full=True)[name]), _values(field), field.description or "")
        for name, field in model.model_fields.items()
    ]


def example(settings: Settings) -> str:
    """Return settings as a YAML file that says of each field what it means; it reads back as the same settings."""
    values = settings.to_dict(full=True)
    blocks = []
    for field in fields_of(type(settings)):
        said = f"{field.meaning} ({field.values}; default {field.default})"
        lines = [*(f"# {line}" for line in _wrapped(said)), f"{field.name}: {_yaml(values[field.name])}"]
        blocks.append("\n".join(lines))
    return "\n\n".join(blocks) + "\n"


def table(model: type[Settings]) -> str:
    """Return the fields of settings as a Markdown table."""
    rows = [
        f"| `{field.name}` | `{field.default}` | {field.values} | {field.meaning} |".replace("<", "&lt;")
        for field in fields_of(model)
    ]
    return "\n".join(["| field | default | values | meaning |", "| --- | --- | --- | --- |", *rows]) + "\n"


def _yaml(value: object) -> str:
    text: str = yaml.safe_dump(value, default_flow_style=True, width=math.inf)
    return text.removesuffix("\n").removesuffix("\n...")


def _values(field: FieldInfo) -> str:
    none = "null or " if type(None) in get_args(field.annotation) and field.metadata else ""
    return none + _values_but_null(field)


def _values_but_null(field: FieldInfo) -> str:
    for note in field.metadata:
        if isinstance(note, Numbers):
            bounds = _bounds(note.low, note.high, above=note.above)
            return f"{_LISTS[note.many]}, {bounds}" if note.many == "given" else f"{bounds}, {_LISTS[note.many]}"
    limits = {type(note): note for note in field.metadata}
    low, high = limits.get(annotated_types.Ge), limits.get(annotated_types.Le)
    above, below = limits.get(annotated_types.Gt), limits.get(annotated_types.Lt)
    if isinstance(low, annotated_types.Ge) and isinstance(high, annotated_types.Le):
        return _bounds(low.ge, high.le)
    if isinstance(above, annotated_types.Gt) and isinstance(high, annotated_types.Le):
        return _bounds(above.gt, high.le, above=True)
    if isinstance(low, annotated_types.Ge) and isinstance(below, annotated_types.Lt):
        return f"{low.ge} or more"
    if isinstance(above, annotated_types.Gt):
        return f"above {above.gt}"
    return _kind(field.annotation)


def _bounds(low: object, high: object, *, above: bool = False) -> str:
    a, b = (f"{each:.6g}" if isinstance(each, float) else f"{each}" for each in (low, high))
    return f"above {a}, up to {b}" if above else f"{a} to {b}"


def _kind(annotation: object) -> str:
    if get_origin(annotation) is Literal:
        *others, last = map(str, get_args(annotation))
        return f"{', '.join(others)} or {last}" if others else last
    if annotation is bool:
        return "true or false"
    if annotation is type(None):
        return "null"
    if annotation is str:
        return "text"
    if get_origin(annotation) is tuple:
        of = get_args(annotation)
        if isinstance(of[0], type) and issubclass(of[0], Settings):
            return f"a list of mappings with {', '.join(of[0].model_fields)}"
        each = {float: "numbers", str: "texts"}.get(of[0], "values")
        return f"a list of {each}" if of[-1] is Ellipsis else f"a list of {len(of)} {each}"
    if isinstance(annotation, types.UnionType):
        return " or ".join(map(_kind, get_args(annotation)))
    return "a number"


def _wrapped(text: str) -> Iterator[str]:
    line = ""
    for word in text.split():
        if line and len(line) + len(word) >= _WIDTH:
            yield line
            line = word
        else:
            line = f"{line} {word}".strip()
    yield line
