"""The exceptions mobo raises on purpose; each knows the exit code it means for a command."""

from __future__ import annotations


class MoboError(Exception):
    """Base of all errors mobo raises on purpose. As the end of a command: exit code 1."""

    exit_code = 1


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
