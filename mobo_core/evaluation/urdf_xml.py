"""Reading XML from anywhere: its size in depth, its names and its numbers are checked."""

from __future__ import annotations

import math
from typing import NoReturn
from xml.etree.ElementTree import Element
from xml.parsers import expat

from mobo_core.errors import InputError

MAX_DEPTH = 32
_MAX_NUMBER = 1e6


def parse(data: bytes) -> Element:
    """Return the root element, without the text between tags.

    Raises:
        InputError: it is not XML, has a DTD (hence, maybe, entities), or is nested too deep.
    """
    roots: list[Element] = []
    open_: list[Element] = []

    def start(tag: str, attributes: dict[str, str]) -> None:
        element = Element(tag, attributes)
        (open_[-1] if open_ else roots).append(element)
        open_.append(element)
        if len(open_) > MAX_DEPTH:
            raise InputError(f"elements nested deeper than {MAX_DEPTH}", where="urdf", expected="a URDF robot")

    def end(tag: str) -> None:
        open_.pop()

    def doctype(*_: object) -> NoReturn:
        raise InputError("forbidden XML (DTDForbidden)", where="urdf", expected="XML without DTD or entities")

    # A tag of a namespace is none of URDF's: its name has the namespace in front.
    parser = expat.ParserCreate(namespace_separator="}")
    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.StartDoctypeDeclHandler = doctype
    try:
        parser.Parse(data, True)
    except (expat.ExpatError, ValueError, LookupError) as error:
        raise InputError(f"not well-formed XML ({error})", where="urdf", expected="a URDF robot") from None
    return roots[0]


def unique_names(elements: list[Element], kind: str) -> set[str]:
    """Return the elements' names; InputError if one has none, or one is there twice."""
    names: set[str] = set()
    for element in elements:
        name = element.get("name", "")
        if not name or len(name) > 200 or not name.isprintable():
            raise InputError(f"{kind} named {name[:40]!r}", where="urdf", expected="a printable name")
        if name in names:
            raise InputError(f"two {kind}s named {name!r}", where="urdf", expected="distinct names")
        names.add(name)
    return names


def numbers(element: Element | None, attribute: str, default: str, where: str, count: int = 3) -> tuple[float, ...]:
    """Return the ``count`` numbers of an attribute; InputError if they are not, or not finite, or huge."""
    text = default if element is None else element.get(attribute, default)
    try:
        values = tuple(float(word) for word in text.split())
    except ValueError:
        values = ()
    if len(values) != count or not all(math.isfinite(v) and abs(v) <= _MAX_NUMBER for v in values):
        what = f"{attribute}={text[:60]!r}"
        raise InputError(what, where=where, expected=f"{count} finite number{'s' if count > 1 else ''}")
    return values


def text(values: tuple[float, ...]) -> str:
    """Return numbers as an attribute holds them, to the bit."""
    return " ".join(repr(value) for value in values)
