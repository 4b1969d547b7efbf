"""What mobo can be extended with: built-in entries by name, and those of other distributions by entry points."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from importlib.metadata import EntryPoint, entry_points
from typing import Generic, Protocol, TypeVar

from mobo_core.errors import InputError


class Named(Protocol):
    """What a registry holds."""

    @property
    def name(self) -> str:
        """The name it is asked for by."""


Entry = TypeVar("Entry", bound=Named)


def _to_stderr(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


class Registry(Generic[Entry], Mapping[str, Entry]):
    """Entries of one kind by name: the built-in ones in their order, then other distributions' by name.

    Entry points of ``group`` are read when a name is asked for that is not built in, or all are listed. One that
    cannot be loaded, is of another kind, or takes a name that is taken, is told once on standard error and left out.

    Args:
        kind: of the entries, for people, such as ``sampler``.
        group: of the entry points, such as ``mobo.samplers``.
        cls: class of the entries.
        built_in: entries that mobo itself brings.
    """

    def __init__(self, kind: str, group: str, cls: type[Entry], built_in: tuple[Entry, ...]) -> None:
        self.kind, self.group = kind, group
        self._cls = cls
        self._entries = {entry.name: entry for entry in built_in}
        self._n_built_in = len(built_in)
        self._complete = False

    def __getitem__(self, name: str) -> Entry:
        """Return the entry of this name; KeyError if there is none."""
        if name not in self._entries:
            self._load()
        return self._entries[name]

    def __iter__(self) -> Iterator[str]:
        """Iterate over all names."""
        self._load()
        return iter(self._entries)

    def __len__(self) -> int:
        """Return the number of entries."""
        self._load()
        return len(self._entries)

    @property
    def built_in(self) -> tuple[Entry, ...]:
        """The entries that mobo itself brings."""
        return tuple(self._entries.values())[: self._n_built_in]

    def of(self, name: str, where: str = "") -> Entry:
        """Return the entry of this name.

        Raises:
            InputError: there is none; says which there are.
        """
        try:
            return self[name]
        except KeyError:
            raise InputError(repr(name), where=where or self.kind, expected=self.names()) from None

    def names(self) -> str:
        """Return all names as people read them: ``a, b or c``."""
        *others, last = self
        return f"{', '.join(others)} or {last}" if others else last

    def _load(self) -> None:
        if self._complete:
            return
        self._complete = True
        for point in sorted(entry_points(group=self.group), key=lambda point: point.name):
            try:
                entry = self._loaded(point)
            except Exception as error:  # whatever another distribution's module raises
                who = point.dist.name if point.dist is not None else point.value
                _to_stderr(f"mobo: {self.kind} {point.name!r} of {who} left out: {' '.join(str(error).split())[:200]}")
            else:
                self._entries[entry.name] = entry

    def _loaded(self, point: EntryPoint) -> Entry:
        entry = point.load()
        if not isinstance(entry, self._cls):
            raise TypeError(f"{point.value} is a {type(entry).__name__}, not a {self._cls.__name__}")
        if entry.name in self._entries:
            raise ValueError(f"the name {entry.name!r} is taken")
        return entry
