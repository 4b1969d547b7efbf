"""What all tests share."""

from __future__ import annotations

from hypothesis import settings

# The same examples on every run, however slow the machine; `--hypothesis-profile=default` looks for new ones.
settings.register_profile("mobo", deadline=None, derandomize=True, database=None)
settings.load_profile("mobo")
