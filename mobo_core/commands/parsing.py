"""Parsers of the verbs."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import TYPE_CHECKING, NoReturn


class Parser(argparse.ArgumentParser):
    """Says what is wrong with the arguments in one line, exit code 2; keeps the lines of its texts as they are.

    Attributes:
        more: returns lines to print below the description in ``--help``, which are not known before it is asked for.
    """

    more: Callable[[], str] | None = None

    def error(self, message: str) -> NoReturn:
        """Print one line and exit with 2."""
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")

    def format_help(self) -> str:
        """Return the help, with what :attr:`more` adds."""
        description = self.description
        if self.more is not None:
            self.description = f"{description or ''}\n\n{self.more()}"
        try:
            return super().format_help()
        finally:
            self.description = description


# To which a module of a verb adds its parser.
if TYPE_CHECKING:
    Verbs = argparse._SubParsersAction[Parser]
else:  # generic for the type checker alone
    Verbs = argparse._SubParsersAction
