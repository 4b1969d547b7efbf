"""What a simulation must never see."""

from __future__ import annotations


class Violation(Exception):  # noqa: N818
    """Something happened that mobo promises not to let happen.

    Args:
        rule: which promise, in a few words; a smaller case counts as the same if it breaks the same one.
        text: what happened.
    """

    def __init__(self, rule: str, text: str) -> None:
        self.rule, self.text = rule, text
        super().__init__(f"{rule}: {text}")

    def __reduce__(self) -> tuple[type[Violation], tuple[str, str]]:
        return Violation, (self.rule, self.text)


class KilledError(BaseException):
    """A simulated process ends here and now. Not an Exception: nothing of the process may catch it."""
