"""How a study's progress is shown: a bar on a terminal, a line now and then elsewhere."""

from __future__ import annotations

import sys
import time

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from mobo_core.messages import StudyStatus

_LINE_EVERY_S = 5.0


class StudyProgress:
    """Shows the StudyStatus messages of a study on standard error."""

    def __init__(self, study: str, n_trials: int) -> None:
        self._study, self._console = study, Console(stderr=True, highlight=False, markup=False, soft_wrap=True)
        self._last_line, self._last_told = 0.0, -1
        self._bar: Progress | None = None
        if sys.stderr.isatty():
            self._bar = Progress(
                TextColumn(study), BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[text]}"),
                TimeRemainingColumn(), console=self._console,
            )  # fmt: skip
            self._task = self._bar.add_task(study, total=n_trials, text="starting evaluators …")
            self._bar.start()
        else:
            self._console.print(f"{study}: starting the optimizer and evaluators …")

    def show(self, status: StudyStatus) -> None:
        """Show a StudyStatus message."""
        if not status.told and not status.evaluators:
            text = "waiting for evaluators …"
        else:
            text = (
                f"reach {status.best_reach:.1f}  hypervolume {status.hypervolume:.4f}  "
                f"front {status.front_size}  {status.evaluators} evaluators"
            )
        if status.state == StudyStatus.PAUSED:
            text = f"paused  {text}"
        if status.failed:
            text += f"  {status.failed} failed"
        if self._bar is not None:
            self._bar.update(self._task, completed=status.told, total=status.n_trials, text=text)
            return
        now = time.monotonic()
        over = status.state == StudyStatus.DONE
        if status.told != self._last_told and (over or now - self._last_line > _LINE_EVERY_S):
            self._last_line, self._last_told = now, status.told
            self._console.print(f"{self._study}: {status.told}/{status.n_trials}  {text}")

    def say(self, text: str) -> None:
        """Print a line beside the bar."""
        self._console.print(f"{self._study}: {text}")

    def close(self) -> None:
        """Leave the bar as it stands."""
        if self._bar is not None:
            self._bar.stop()
