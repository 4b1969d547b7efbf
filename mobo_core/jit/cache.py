"""Compiled functions, kept in the user's cache folder: compiled once per machine for each set of sources."""

from __future__ import annotations

import fcntl
import hashlib
import os
import sys
from collections.abc import Callable, Iterable
from functools import cached_property
from pathlib import Path
from typing import TypeVar, cast

Loaded = TypeVar("Loaded")
Function = TypeVar("Function", bound=Callable[..., object])


def _to_stderr(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def cache_base() -> Path:
    """Return the folder that holds all of mobo's caches: below MOBO_CACHE, XDG_CACHE_HOME or ~/.cache."""
    base = os.environ.get("MOBO_CACHE") or os.environ.get("XDG_CACHE_HOME")
    try:
        return (Path(base) if base else Path.home() / ".cache") / "mobo"
    except RuntimeError:  # no home: nothing can be kept
        return Path(os.devnull) / "mobo"


def _widest() -> str | None:
    """Return this processor's features for Numba, with vectors as wide as it has; None where LLVM's choice may stay.

    LLVM keeps to 256 bits on processors with AVX-512 that slow down while they use all of it; loops over lanes gain
    more than that. The user's own choice of a processor or of features stays.
    """
    from llvmlite import binding

    if os.environ.get("NUMBA_CPU_NAME") or os.environ.get("NUMBA_CPU_FEATURES") is not None:
        return None
    features = binding.get_host_cpu_features()
    return f"{features.flatten()},-prefer-256-bit" if features.get("avx512f") else None


class Cache:
    """The compiled functions of some source files, and where they are kept.

    Numba itself looks at one file at a time, and would keep a function whose callee changed. So the functions
    that call each other share a cache, whose folder depends on all of their sources; others have their own.

    Args:
        name: of the set, which the folder's name begins with.
        sources: the files that hold its functions, and those whose functions or constants these use.
        nogil: release the GIL in its functions; they may then write only to what their caller alone has.
    """

    def __init__(self, name: str, sources: Iterable[Path | str], *, nogil: bool = False) -> None:
        self.name, self._nogil = name, nogil
        self._sources = sorted(Path(source) for source in sources)

    def folder(self) -> Path:
        """Return the folder: it depends on the sources, on Numba's version and on the processor compiled for."""
        import numba
        from llvmlite import binding

        cpu = os.environ.get("NUMBA_CPU_NAME") or binding.get_host_cpu_name()
        features = os.environ.get("NUMBA_CPU_FEATURES") or _widest() or ""
        text = hashlib.sha256(f"{numba.__version__} {sys.version_info[:2]} {cpu} {features} {self._nogil}".encode())
        # How they are compiled counts too.
        for source in (*self._sources, Path(__file__)):
            text.update(source.read_bytes())
        return cache_base() / f"{self.name}-{text.hexdigest()[:16]}"

    @cached_property
    def kept(self) -> Path | None:
        """The folder, made if need be; None where nothing can be kept."""
        folder = self.folder()
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError:
            return None
        return folder if os.access(folder, os.W_OK) else None

    def compiled(self, function: Function) -> Function:
        """Compile a function (at its first call), without fastmath: it then neither reorders nor contracts.

        Division follows NumPy's rules. Where nothing can be kept it is compiled for this process.
        """
        import numba

        if self.kept is not None:
            # Numba settles where a function is kept as it decorates it, and would choose __pycache__ otherwise.
            numba.config.CACHE_DIR = str(self.kept)  # type: ignore[attr-defined]
        widest = _widest()
        if widest is not None:
            numba.config.CPU_FEATURES = widest  # type: ignore[attr-defined]
        decorate = numba.njit(cache=self.kept is not None, nogil=self._nogil, error_model="numpy")
        return cast(Function, decorate(function))

    def source_hash(self) -> str:
        """Return a hash of the sources: equal ones compute the same bits on every x86-64 machine."""
        text = hashlib.sha256()
        for source in self._sources:
            text.update(source.read_bytes())
        return text.hexdigest()[:16]

    def is_complete(self, part: str) -> bool:
        """Return whether this machine holds a part, compiled by :meth:`once`, that fits."""
        return (self.folder() / f"complete_{part}").exists()

    def once(
        self, what: str, part: str, load: Callable[[], Loaded], say: Callable[[str], None] = _to_stderr
    ) -> Loaded:
        """Call ``load``, which compiles what the cache lacks, and return what it returns.

        The first process on a machine compiles under a file lock; others wait for it. Both say so.

        Args:
            what: is loaded, for people.
            part: of the set, for the mark that it is complete.
            load: imports and calls the functions.
            say: takes lines for people.
        """
        folder = self.folder() if self.kept is None else self.kept
        complete = folder / f"complete_{part}"
        try:
            lock = (folder / "lock").open("a")
        except OSError as error:
            say(f"mobo: cannot keep {what} compiled ({error.strerror}: {folder}); compiling for this process")
            return load()
        with lock:
            if not complete.exists():
                try:
                    fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                except BlockingIOError:
                    say(f"mobo: waiting for another process that compiles {what} …")
                    fcntl.flock(lock, fcntl.LOCK_EX)
                if not complete.exists():
                    say(f"mobo: compiling {what}, once per machine …")
                    loaded = load()
                    complete.touch()
                    return loaded
        return load()


def interpreted(function: Function) -> Function:
    """Return a compiled function as Python runs it: for a few calls, compiling takes longer."""
    return cast(Function, function.py_func)  # type: ignore[attr-defined]
