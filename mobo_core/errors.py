"""The exceptions mobo raises on purpose; each knows the exit code it means for a command."""

from __future__ import annotations

from collections.abc import Callable


def visible(text: str) -> str:
    """Return a text that came from outside as one line, what cannot be printed escaped: nothing of it speaks to us."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


def visibly(take: Callable[[str], None]) -> Callable[[str], None]:
    """Return a function that hands on lines made visible."""

    def say(line: str) -> None:
        take(visible(line))

    return say


class MoboError(Exception):
    """Base of all errors mobo raises on purpose. As the end of a command: exit code 1.

    Args:
        text: one line; what of it cannot be printed is made visible.
    """

    exit_code = 1

    def __init__(self, text: str = "") -> None:
        super().__init__(visible(text))


class InputError(MoboError):
    """Bad input: says in one line what is wrong, where, and what was expected. Exit code 2.

    Args:
        what: the fault, with the offending value.
        where: file, parameter or element it was found in.
        expected: what would have been accepted.
    """

    exit_code = 2

    def __init__(self, what: str, *, where: str = "", expected: str = "") -> None:
        self.what, self.where, self.expected = what, where, expected
        text = f"{where}: {what}" if where else what
        super().__init__(" ".join((f"{text}; expected {expected}" if expected else text).split()))

    def at(self, where: str) -> InputError:
        """Return the same error, said of ``where`` (outermost place first)."""
        return InputError(
            self.what, where=f"{where}: {self.where}" if self.where else where, expected=self.expected
        )


class UnableError(InputError):
    """A sound question that this engine or version cannot answer; another may."""


class InUseError(InputError):
    """Somebody else holds what only one may have; a moment later that may have changed."""


class StudyError(MoboError):
    """A study cannot go on, or the answer to what was asked is no. Exit code 1."""
