"""How far a command has come, on standard error: a bar on a terminal, elsewhere a line now and then."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

# Off a terminal: s until the first line, and between lines.
FIRST_S = 2.0
EVERY_S = 10.0


@contextmanager
def bar(
    title: str, *, quiet: bool = False, clock: Callable[[], float] = time.monotonic
) -> Iterator[Callable[[int, int], None]]:
    """Yield a function to call with (done, in all)."""
    if quiet:
        yield lambda done, total: None
        return
    if not sys.stderr.isatty():
        yield _lines(title, clock)
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as shown:
        task = shown.add_task(title, total=None)
        yield lambda done, total: shown.update(task, completed=done, total=total)


def _lines(title: str, clock: Callable[[], float]) -> Callable[[int, int], None]:
    """Return what prints ``TITLE 40/75``: nothing of what is done within FIRST_S."""
    due = clock() + FIRST_S

    def show(done: int, total: int) -> None:
        nonlocal due
        now = clock()
        if now >= due and done < total:
            due = now + EVERY_S
            print(f"{title} {done}/{total}", file=sys.stderr, flush=True)

    return show
